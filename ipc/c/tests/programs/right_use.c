/* Everything as it is meant: right_use PATH. Robot and scene "arm_window" are loaded. */
#include "common.h"

static taut_error *error;
static taut_daemon *daemon_;

static void shortens(const test_path *path) {
    taut_options options;
    taut_answers *answers;
    taut_answer *answer;
    taut_info info, last;
    taut_rows rows;
    taut_corridor corridor;
    double *copy;
    int32_t code;
    int improvements = 0;
    memset(&last, 0, sizeof last);
    taut_options_default(&options, sizeof options);
    options.work_budget = 20000;
    options.corridor = 1;
    EXPECT(TAUT_SUCCESS, taut_shorten(daemon_, "arm_window", "arm_window", path->numbers, path->waypoints,
                             path->columns, &options, &answers, &error));
    while ((code = taut_next(answers, INFINITY, &answer, &error)) == TAUT_SUCCESS) {
        EXPECT(TAUT_SUCCESS, taut_answer_info(answer, &info, sizeof info, &error));
        EXPECT(TAUT_SUCCESS, taut_answer_rows(answer, &rows, sizeof rows, &error));
        CHECK(info.proved && rows.waypoints == info.waypoints && rows.columns == 7 && rows.stride == 7);
        CHECK(improvements == 0 || info.length_after <= last.length_after);
        CHECK(memcmp(rows.first, path->numbers, 7 * sizeof(double)) == 0);
        if (info.is_final) {
            copy = (double *)malloc(info.waypoints * 7 * sizeof(double));
            EXPECT(TAUT_SUCCESS, taut_answer_copy(answer, copy, info.waypoints * 7, &error));
            CHECK(memcmp(rows.first, copy, info.waypoints * 7 * sizeof(double)) == 0);
            free(copy);
            CHECK(taut_answer_corridor(answer, &corridor, sizeof corridor));
            CHECK(corridor.reach_count == 7 && corridor.slack_count == info.waypoints - 1);
            CHECK(corridor.floor_m == info.floor_m && corridor.slack_m[0] >= 0 && corridor.reach[0] >= 0);
        } else {
            CHECK(!taut_answer_corridor(answer, &corridor, sizeof corridor));
        }
        last = info;
        ++improvements;
        taut_answer_free(answer);
    }
    EXPECT(TAUT_END, code);
    EXPECT(TAUT_END, taut_next(answers, 0, &answer, &error));
    CHECK(answer == NULL && last.is_final && last.length_after < 0.9 * last.length_before);
    CHECK(last.lower_bound <= last.length_after && last.clearance_m > 0 && last.scene_version == 1);
    taut_answers_free(answers);
}

/* What is kept besides clearance, with its numbers. */
static void keeps(const test_path *path) {
    taut_options options;
    taut_answers *answers;
    taut_answer *answer;
    taut_kept kept;
    taut_options_default(&options, sizeof options);
    options.work_budget = 20000;
    options.constraints = "keep hand in ball 3 at 0,0,0";
    EXPECT(TAUT_SUCCESS, taut_shorten(daemon_, "arm_window", "arm_window", path->numbers, path->waypoints,
                             path->columns, &options, &answers, &error));
    EXPECT(TAUT_SUCCESS, taut_result(answers, INFINITY, &answer, &error));
    CHECK(taut_answer_keeps(answer) == 1 && taut_answer_kept(answer, 0, &kept, sizeof kept));
    CHECK(strcmp(kept.name, "hand") == 0 && kept.kind == TAUT_KIND_POSITION && kept.unit == TAUT_UNIT_METRE);
    CHECK(kept.asked == 3 && 0 < kept.left && kept.left <= kept.found && kept.found < 3);
    CHECK(kept.t >= 0 && kept.t <= 1 && kept.reserved == 0);
    CHECK(!taut_answer_kept(answer, 1, &kept, sizeof kept));
    taut_answer_free(answer);
    CHECK(taut_answer_keeps(answer) == 0);
    taut_answers_free(answers);
}

/* Times after the path, each trajectory faster than the one before; what is missing is told. */
static void times(const test_path *path) {
    taut_options options;
    taut_answers *answers;
    taut_answer *answer;
    taut_info info;
    taut_trajectory found;
    double last = INFINITY;
    int seen = 0;
    size_t at, column;
    int32_t code;
    memset(&info, 0, sizeof info);
    memset(&found, 0, sizeof found);
    taut_options_default(&options, sizeof options);
    options.work_budget = 20000;
    options.timing = "acceleration=2/s speed=0.5 work=20000";
    EXPECT(TAUT_SUCCESS, taut_shorten(daemon_, "arm_window", "arm_window", path->numbers, path->waypoints,
                             path->columns, &options, &answers, &error));
    while ((code = taut_next(answers, INFINITY, &answer, &error)) == TAUT_SUCCESS) {
        EXPECT(TAUT_SUCCESS, taut_answer_info(answer, &info, sizeof info, &error));
        code = taut_answer_trajectory(answer, &found, sizeof found, &error);
        if (code == TAUT_SUCCESS) {
            CHECK(found.points > 1 && found.columns == 7 && found.times_ns[0] == 0 && found.duration_s <= last);
            CHECK(found.positions && found.velocities && !found.accelerations);
            CHECK(memcmp(found.positions, path->numbers, 7 * sizeof(double)) == 0);
            for (at = 1; at < found.points; ++at) CHECK(found.times_ns[at - 1] < found.times_ns[at]);
            for (column = 0; column < 7; ++column)
                CHECK(found.velocities[column] == 0 && found.velocities[(found.points - 1) * 7 + column] == 0);
            CHECK(found.duration_s >= found.bound_s && found.duration_s <= found.stops_s && found.decides < 7);
            last = found.duration_s;
            ++seen;
        } else {
            CHECK(code == TAUT_UNTIMED && !info.is_final);
            taut_error_free(error);
            error = NULL;
        }
        if (info.is_final) CHECK(found.used[0] <= 1.000001 && found.limits[1] > 0 && found.clearance_m > 0);
        taut_answer_free(answer);
    }
    EXPECT(TAUT_END, code);
    CHECK(seen >= 1 && info.is_final && found.controller == TAUT_CONTROLLER_CUBIC);
    taut_answers_free(answers);
    options.timing = "speed=0.5";
    REFUSED(TAUT_INVALID_TIMING, "acceleration limit",
        taut_check(daemon_, "arm_window", "arm_window", path->numbers, path->waypoints, 7, &options, NULL, 0, &error));
    options.timing = NULL;
    EXPECT(TAUT_SUCCESS, taut_shorten(daemon_, "arm_window", "arm_window", path->numbers, path->waypoints, 7, &options,
                             &answers, &error));
    EXPECT(TAUT_SUCCESS, taut_result(answers, 60, &answer, &error));
    REFUSED(TAUT_UNTIMED, "asked for no times", taut_answer_trajectory(answer, &found, sizeof found, &error));
    taut_answer_free(answer);
    taut_answers_free(answers);
}

/* Columns by name: backwards, with one left out that is held. */
static void columns_by_name(const test_path *path) {
    const char *backwards[] = {"joint7", "joint6", "joint5", "joint4", "joint3", "joint2", "joint1"};
    double *turned = (double *)malloc(path->waypoints * 7 * sizeof(double));
    double *found = (double *)malloc(path->waypoints * 7 * sizeof(double));
    taut_options options;
    taut_answers *answers;
    taut_answer *answer;
    taut_info info;
    taut_rows rows;
    size_t row, column;
    for (row = 0; row < path->waypoints; ++row)
        for (column = 0; column < 7; ++column)
            turned[row * 7 + column] = path->numbers[row * 7 + 6 - column];
    taut_options_default(&options, sizeof options);
    options.columns = backwards;
    options.column_count = 7;
    EXPECT(TAUT_SUCCESS, taut_check(daemon_, "arm_window", "arm_window", turned, path->waypoints, 7, &options, &info,
                             sizeof info, &error));
    CHECK(info.proved && info.length_before == info.length_after);
    options.mode = TAUT_MODE_CHECK;
    EXPECT(TAUT_SUCCESS, taut_shorten(daemon_, "arm_window", "arm_window", turned, path->waypoints, 7, &options,
                             &answers, &error));
    EXPECT(TAUT_SUCCESS, taut_result(answers, 60, &answer, &error));
    REFUSED(TAUT_INVALID_ROBOT_STATE, "taut_answer_copy", taut_answer_rows(answer, &rows, sizeof rows, &error));
    EXPECT(TAUT_SUCCESS, taut_answer_copy(answer, found, path->waypoints * 7, &error));
    CHECK(memcmp(found, turned, path->waypoints * 7 * sizeof(double)) == 0);
    taut_answer_free(answer);
    taut_answers_free(answers);
    free(turned);
    free(found);
}

/* A box in the way: what is not kept, and where; moved away, the path is free again. */
static void scenes_change(const test_path *path) {
    const char *box = "{\"is_diff\": true, \"objects\": [{\"id\": \"crate\", \"operation\": \"ADD\", \"primitives\": "
                      "[{\"type\": \"box\", \"dimensions\": [2, 2, 2]}], \"primitive_poses\": [{\"position\": [0.6, 0, "
                      "0.5], \"orientation\": {\"x\": 0, \"y\": 0, \"z\": 0, \"w\": 1}}]}]}";
    const taut_pose away = {{5, 5, 5}, {0, 0, 0, 1}};
    taut_scene_info info;
    taut_place place;
    EXPECT(TAUT_SUCCESS, taut_change_scene(daemon_, "arm_window", box, NULL, 1, &info, sizeof info, &error));
    CHECK(info.version == 2 && info.objects == 6);
    EXPECT(TAUT_START_STATE_IN_COLLISION, taut_check(daemon_, "arm_window", "arm_window", path->numbers,
                                              path->waypoints, 7, NULL, NULL, 0, &error));
    CHECK(taut_error_place(error, &place, sizeof place));
    CHECK(strcmp(place.names[0], "crate") == 0 || strcmp(place.names[1], "crate") == 0);
    CHECK(place.kind == TAUT_KIND_CLEARANCE && place.unit == TAUT_UNIT_METRE && place.allowed > 0);
    CHECK(place.segment == 0 && place.t == 0 && place.amount < 0);
    taut_error_free(error);
    REFUSED(TAUT_VERSION_CONFLICT, "version",
        taut_change_scene(daemon_, "arm_window", box, NULL, 1, NULL, 0, &error));
    EXPECT(TAUT_SUCCESS, taut_move_object(daemon_, "arm_window", "crate", NULL, &away, &info, sizeof info, &error));
    EXPECT(TAUT_SUCCESS, taut_check(daemon_, "arm_window", "arm_window", path->numbers, path->waypoints, 7, NULL,
                             NULL, 0, &error));
    EXPECT(TAUT_SUCCESS,
        taut_attach_object(daemon_, "arm_window", "crate", "hand", &away, NULL, 0, &info, sizeof info, &error));
    EXPECT(TAUT_SUCCESS, taut_detach_object(daemon_, "arm_window", "crate", &away, &info, sizeof info, &error));
    EXPECT(TAUT_SUCCESS, taut_remove_object(daemon_, "arm_window", "crate", &info, sizeof info, &error));
    CHECK(info.objects == 5);
}

/* A path keeps what a text asks for: few words, or MoveIt's message; what it does not keep is told with its number. */
static void keeps_constraints(const test_path *path) {
    const char *texts[] = {"keep hand in ball 2 at 0,0,0",
        "[\"keep hand in box 4,4,4 at 0,0,0\", {\"name\": \"near\", \"position_constraints\": [{\"link_name\": \"hand\", "
        "\"constraint_region\": {\"primitives\": [{\"type\": 2, \"dimensions\": [2]}], \"primitive_poses\": [{}]}}]}]"};
    const double allowed = 0.01;
    char narrow[256];
    taut_options options;
    taut_answers *answers;
    taut_answer *answer;
    taut_info info;
    taut_place place;
    double at, left;
    size_t text;
    taut_options_default(&options, sizeof options);
    options.work_budget = 20000;
    for (text = 0; text < 2; ++text) {
        options.constraints = texts[text];
        EXPECT(TAUT_SUCCESS, taut_shorten(daemon_, "arm_window", "arm_window", path->numbers, path->waypoints, 7,
                                 &options, &answers, &error));
        EXPECT(TAUT_SUCCESS, taut_result(answers, 60, &answer, &error));
        EXPECT(TAUT_SUCCESS, taut_answer_info(answer, &info, sizeof info, &error));
        CHECK(info.proved && info.length_after < info.length_before);
        taut_answer_free(answer);
        taut_answers_free(answers);
    }
    snprintf(narrow, sizeof narrow,
        "{\"name\": \"still\", \"joint_constraints\": [{\"joint_name\": \"joint1\", \"position\": %.17g, "
        "\"tolerance_above\": %g, \"tolerance_below\": %g}]}",
        path->numbers[0], allowed, allowed);
    options.constraints = narrow;
    CHECK(taut_check(daemon_, "arm_window", "arm_window", path->numbers, path->waypoints, 7, &options, NULL, 0, &error)
        == TAUT_GOAL_VIOLATES_PATH_CONSTRAINTS);
    CHECK(taut_error_place(error, &place, sizeof place));
    CHECK(place.kind == TAUT_KIND_JOINT && place.unit == TAUT_UNIT_RADIAN && strcmp(place.names[0], "still: joint1") == 0);
    at = path->numbers[place.segment * 7];
    at += place.t * (path->numbers[(place.segment + 1) * 7] - at);
    left = allowed - fabs(at - path->numbers[0]);
    CHECK(place.amount < 0 && fabs(place.amount - left) < 1e-9);
    CHECK(strstr(taut_error_message(error), "still: joint1") && strstr(taut_error_message(error), "outside by"));
    taut_error_free(error);
    error = NULL;
}

/* The seed that never ends by itself: asked for its best, and cancelled. */
static void ends_when_told(const test_path *path) {
    taut_options options;
    taut_answers *answers;
    taut_answer *answer;
    taut_options_default(&options, sizeof options);
    options.mode = TAUT_MODE_RANDOM_SHORTCUT;
    options.seed = 0x4a464a464a464a46;
    EXPECT(TAUT_SUCCESS, taut_shorten(daemon_, "arm_window", "arm_window", path->numbers, path->waypoints, 7, &options,
                             &answers, &error));
    EXPECT(TAUT_SUCCESS, taut_next(answers, INFINITY, &answer, &error)); /* so the path is proved */
    taut_answer_free(answer);
    EXPECT(TAUT_PENDING, taut_result(answers, 0.05, &answer, &error));
    CHECK(answer == NULL);
    EXPECT(TAUT_SUCCESS, taut_finish_early(answers, &error));
    EXPECT(TAUT_SUCCESS, taut_result(answers, 60, &answer, &error));
    taut_answers_free(answers);
    taut_answer_free(answer); /* it outlived its request */
    EXPECT(TAUT_SUCCESS, taut_shorten(daemon_, "arm_window", "arm_window", path->numbers, path->waypoints, 7, &options,
                             &answers, &error));
    EXPECT(TAUT_SUCCESS, taut_cancel(answers, &error));
    REFUSED(TAUT_PREEMPTED, "cancelled", taut_next(answers, 60, &answer, &error));
    taut_answers_free(answers);
}

int main(int count, char **arguments) {
    test_path path;
    taut_robot *robot;
    taut_variable variable;
    CHECK(count == 2);
    path = read_path(arguments[1]);
    EXPECT(TAUT_SUCCESS, taut_connect(NULL, &daemon_, &error));
    EXPECT(TAUT_SUCCESS, taut_describe_robot(daemon_, "arm_window", &robot, &error));
    CHECK(taut_robot_variables(robot) == 7 && taut_robot_variable(robot, 6, &variable));
    CHECK(strcmp(variable.name, "joint7") == 0 && variable.lower == -2.8973 && !variable.continuous);
    CHECK(!taut_robot_variable(robot, 7, &variable));
    taut_robot_free(robot);
    shortens(&path);
    keeps(&path);
    times(&path);
    columns_by_name(&path);
    keeps_constraints(&path);
    ends_when_told(&path);
    scenes_change(&path);
    free(path.numbers);
    taut_close(daemon_);
    puts("right use is right");
    return 0;
}
