/* Everything as it is not meant: wrong_use PATH. Robot and scene "arm_window" are loaded. */
#include "common.h"

static taut_error *error;
static taut_daemon *daemon_;

static void wrong_handles(const test_path *path) {
    taut_daemon *closed, *none = NULL;
    taut_answers *answers;
    taut_answer *answer, *other;
    taut_info info;
    taut_rows rows;
    double number;
    EXPECT(TAUT_SUCCESS, taut_connect(NULL, &closed, &error));
    taut_close(closed);
    taut_close(closed);
    taut_close(NULL);
    REFUSED(TAUT_MALFORMED_REQUEST, "NULL", taut_describe_robot(none, "arm_window", NULL, &error));
    REFUSED(TAUT_MALFORMED_REQUEST, "freed", taut_describe_robot(closed, "arm_window", NULL, &error));
    REFUSED(TAUT_MALFORMED_REQUEST, "taut_daemon",
        taut_describe_robot((taut_daemon *)(void *)path->numbers, "arm_window", NULL, &error));
    REFUSED(TAUT_MALFORMED_REQUEST, "daemon is NULL", taut_connect(NULL, NULL, &error));
    CHECK(taut_connect(NULL, NULL, NULL) == TAUT_MALFORMED_REQUEST); /* nobody wants the error */

    REFUSED(TAUT_MALFORMED_REQUEST, "answers is NULL",
        taut_shorten(daemon_, "arm_window", NULL, path->numbers, path->waypoints, 7, NULL, NULL, &error));
    EXPECT(TAUT_SUCCESS, taut_shorten(daemon_, "arm_window", "arm_window", path->numbers, path->waypoints, 7, NULL,
                             &answers, &error));
    REFUSED(TAUT_MALFORMED_REQUEST, "answer is NULL", taut_next(answers, 1, NULL, &error));
    REFUSED(TAUT_MALFORMED_REQUEST, "timeout_s", taut_next(answers, -1, &answer, &error));
    REFUSED(TAUT_MALFORMED_REQUEST, "timeout_s", taut_next(answers, NAN, &answer, &error));
    EXPECT(TAUT_SUCCESS, taut_result(answers, 60, &answer, &error));
    REFUSED(TAUT_MALFORMED_REQUEST, "info is NULL", taut_answer_info(answer, NULL, sizeof info, &error));
    REFUSED(TAUT_MALFORMED_REQUEST, "room for 1", taut_answer_copy(answer, &number, 1, &error));
    REFUSED(TAUT_MALFORMED_REQUEST, "taut_answers", taut_next((taut_answers *)(void *)answer, 1, &other, &error));
    taut_answer_free(answer);
    taut_answer_free(answer);
    taut_answer_free(NULL);
    REFUSED(TAUT_MALFORMED_REQUEST, "freed", taut_answer_info(answer, &info, sizeof info, &error));
    REFUSED(TAUT_MALFORMED_REQUEST, "freed", taut_answer_rows(answer, &rows, sizeof rows, &error));
    taut_answers_free(answers);
    taut_answers_free(answers);
    REFUSED(TAUT_MALFORMED_REQUEST, "freed", taut_next(answers, 1, &answer, &error));
    REFUSED(TAUT_MALFORMED_REQUEST, "freed", taut_finish_early(answers, &error));
    REFUSED(TAUT_MALFORMED_REQUEST, "NULL", taut_cancel(NULL, &error));

    CHECK(taut_error_code(NULL) == TAUT_SUCCESS && *taut_error_message(NULL) == 0);
    CHECK(taut_cancel(NULL, &error) == TAUT_MALFORMED_REQUEST);
    CHECK(!taut_error_place(error, NULL, 0));
    taut_error_free(error);
    taut_error_free(error);
    CHECK(taut_error_code(error) == TAUT_MALFORMED_REQUEST && *taut_error_message(error) == 0);
    error = NULL;
}

static void wrong_names(const test_path *path) {
    const char *columns[] = {"joint1", "joint2", "joint3", "joint4", "joint5", "joint6", "elbow"};
    const char no_text[] = {(char)0xff, 0};
    taut_answers *answers;
    taut_options options;
    taut_robot *robot;
    taut_robot_files files;
    memset(&files, 0, sizeof files);
    files.size = sizeof files;
#define SHORTEN(robot, scene, options)                                                                             \
    taut_shorten(daemon_, robot, scene, path->numbers, path->waypoints, 7, options, &answers, &error)
    REFUSED(TAUT_UNKNOWN_ROBOT, "arm_window", SHORTEN("nobody", "arm_window", NULL));
    REFUSED(TAUT_MALFORMED_REQUEST, "robot is NULL", SHORTEN(NULL, "arm_window", NULL));
    REFUSED(TAUT_MALFORMED_REQUEST, "UTF-8", SHORTEN(no_text, NULL, NULL));
    REFUSED(TAUT_UNKNOWN_ROBOT, "nobody", taut_describe_robot(daemon_, "nobody", &robot, &error));
    REFUSED(TAUT_MALFORMED_REQUEST, "files.urdf", taut_load_robot(daemon_, "x", &files, false, NULL, &error));
    files.urdf = "/nowhere/x.urdf";
    REFUSED(TAUT_UNREADABLE_FILE, "/nowhere/x.urdf", taut_load_robot(daemon_, "x", &files, false, NULL, &error));
    REFUSED(TAUT_INVALID_MODEL, "", taut_load_scene(daemon_, "x", "no scene", NULL, false, NULL, 0, &error));
    REFUSED(TAUT_INVALID_OBJECT_NAME, "teapot", taut_remove_object(daemon_, "arm_window", "teapot", NULL, 0, &error));
    REFUSED(TAUT_MALFORMED_REQUEST, "pose", taut_move_object(daemon_, "arm_window", "floor", NULL, NULL, NULL, 0, &error));

    taut_options_default(&options, sizeof options);
    options.columns = columns;
    options.column_count = 7;
    REFUSED(TAUT_INVALID_ROBOT_STATE, "elbow", SHORTEN("arm_window", "arm_window", &options));
    options.column_count = 6;
    REFUSED(TAUT_INVALID_ROBOT_STATE, "joint7", SHORTEN("arm_window", "arm_window", &options));
    options.columns = NULL;
    REFUSED(TAUT_MALFORMED_REQUEST, "options.columns", SHORTEN("arm_window", "arm_window", &options));
    taut_options_default(&options, sizeof options);
    options.group = "leg";
    REFUSED(TAUT_INVALID_GROUP_NAME, "arm", SHORTEN("arm_window", "arm_window", &options));
    taut_options_default(&options, sizeof options);
    options.mode = 17;
    REFUSED(TAUT_MALFORMED_REQUEST, "17", SHORTEN("arm_window", "arm_window", &options));
    memset(&options, 0xff, sizeof options); /* nobody filled it in */
    REFUSED(TAUT_MALFORMED_REQUEST, "options", SHORTEN("arm_window", "arm_window", &options));
    memset(&options, 0, sizeof options);
    REFUSED(TAUT_MALFORMED_REQUEST, "options", SHORTEN("arm_window", "arm_window", &options));
    taut_options_default(&options, sizeof options);
    options.deadline_s = -1;
    REFUSED(TAUT_MALFORMED_REQUEST, "deadline", SHORTEN("arm_window", "arm_window", &options));
}

/* What is no constraint, and what cannot be kept. */
static void wrong_constraints(const test_path *path) {
    static const char *const wrong[][2] = {
        {"hand", "valid: "},
        {"upright nobody:z=0.1", "links: "},
        {"upright hand:z=0", "0.001"},
        {"upright hand:z=2", "\xcf\x80/2"},
        {"{\"joint_constraints\": [{\"joint_name\": \"elbow\", \"position\": 0, \"tolerance_above\": 1, "
         "\"tolerance_below\": 1}]}",
            "joint1, joint2"},
        {"{\"visibility_constraints\": [{}]}", "visibility_constraints"},
        {"{\"orientation\": 1}", "orientation_constraints"},
        {"{", "Constraints"},
    };
    taut_options options;
    size_t index;
    taut_options_default(&options, sizeof options);
#define CHECK_KEPT()                                                                                               \
    taut_check(daemon_, "arm_window", "arm_window", path->numbers, path->waypoints, 7, &options, NULL, 0, &error)
    for (index = 0; index < sizeof wrong / sizeof *wrong; ++index) {
        options.constraints = wrong[index][0];
        REFUSED(TAUT_INVALID_CONSTRAINT, wrong[index][1], CHECK_KEPT());
    }
    options.constraints = "\xff\xfe";
    REFUSED(TAUT_MALFORMED_REQUEST, "UTF-8", CHECK_KEPT());
    options.constraints = "";
    EXPECT(TAUT_SUCCESS, CHECK_KEPT());
}

static void wrong_paths(const test_path *path) {
    double bad[14];
    taut_answers *answers;
    taut_answer *answer;
    memcpy(bad, path->numbers, sizeof bad);
#define CHECK_PATH(numbers, waypoints, columns)                                                                    \
    taut_check(daemon_, "arm_window", "arm_window", numbers, waypoints, columns, NULL, NULL, 0, &error)
    bad[8] = NAN;
    REFUSED(TAUT_INVALID_ROBOT_STATE, "NaN", CHECK_PATH(bad, 2, 7));
    bad[8] = 100;
    REFUSED(TAUT_INVALID_ROBOT_STATE, "joint2", CHECK_PATH(bad, 2, 7));
    REFUSED(TAUT_MALFORMED_REQUEST, "path is NULL", CHECK_PATH(NULL, 2, 7));
    REFUSED(TAUT_INVALID_ROBOT_STATE, "joint7", CHECK_PATH(bad, 7, 2));
    REFUSED(TAUT_INVALID_ROBOT_STATE, "0 numbers", CHECK_PATH(bad, 0, 7));
    REFUSED(TAUT_MALFORMED_REQUEST, "memory", CHECK_PATH(bad, (size_t)-1, 7));
    REFUSED(TAUT_MALFORMED_REQUEST, "path", CHECK_PATH(bad, (size_t)1 << 60, 7));
    /* What the daemon says against a path comes as the answer. */
    bad[8] = NAN;
    EXPECT(TAUT_SUCCESS, taut_shorten(daemon_, "arm_window", "arm_window", bad, 2, 7, NULL, &answers, &error));
    REFUSED(TAUT_INVALID_ROBOT_STATE, "NaN", taut_next(answers, 60, &answer, &error));
    EXPECT(TAUT_END, taut_next(answers, 60, &answer, &error));
    taut_answers_free(answers);
}

/* Nobody frees anything: codes, and the requests that others made go on. */
static void greed(const test_path *path) {
    static const char crate[] =
        "{\"is_diff\": true, \"objects\": [{\"id\": \"crate\", \"operation\": \"ADD\", \"primitives\": [{\"type\": "
        "\"box\", \"dimensions\": [2, 2, 2]}], \"primitive_poses\": [{\"position\": [0.6, 0, 0.5]}]}]}";
    taut_answers *answers[5];
    taut_answer *answer[3];
    taut_options options;
    size_t index, sent = 0;
    int32_t code = TAUT_SUCCESS;
    taut_options_default(&options, sizeof options);
    options.mode = TAUT_MODE_RANDOM_SHORTCUT;
    options.seed = 0x4a464a464a464a46; /* does not end by itself */
    while (sent < 5 && code == TAUT_SUCCESS) {
        code = taut_shorten(daemon_, "arm_window", "arm_window", path->numbers, path->waypoints, 7, &options,
            &answers[sent], &error);
        sent += code == TAUT_SUCCESS;
    }
    CHECK(sent == 4 && code == TAUT_QUOTA);
    taut_error_free(error);
    error = NULL;
    for (index = 0; index < sent; ++index) taut_answers_free(answers[index]);

    /* A watched path has an answer for each change that concerns it: safe, unsafe, safe. */
    taut_options_default(&options, sizeof options);
    options.mode = TAUT_MODE_CHECK;
    options.watch = 1;
    EXPECT(TAUT_SUCCESS, taut_shorten(daemon_, "arm_window", "arm_window", path->numbers, path->waypoints, 7, &options,
                             &answers[0], &error));
    EXPECT(TAUT_SUCCESS, taut_next(answers[0], INFINITY, &answer[0], &error));
    EXPECT(TAUT_SUCCESS, taut_change_scene(daemon_, "arm_window", crate, NULL, 0, NULL, 0, &error));
    REFUSED(TAUT_MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE, "crate",
        taut_next(answers[0], INFINITY, &answer[1], &error));
    EXPECT(TAUT_SUCCESS, taut_remove_object(daemon_, "arm_window", "crate", NULL, 0, &error));
    EXPECT(TAUT_SUCCESS, taut_next(answers[0], INFINITY, &answer[1], &error));
    REFUSED(TAUT_QUOTA, "taut_answer_free", taut_next(answers[0], 0, &answer[2], &error));
    taut_answer_free(answer[0]);
    EXPECT(TAUT_PENDING, taut_next(answers[0], 0, &answer[2], &error));
    taut_answer_free(answer[1]);
    taut_answers_free(answers[0]);
}

int main(int count, char **arguments) {
    test_path path;
    taut_daemon *nobody;
    CHECK(count == 2);
    path = read_path(arguments[1]);
    REFUSED(TAUT_DAEMON_LOST, "", taut_connect("nobody", &nobody, &error));
    REFUSED(TAUT_DAEMON_LOST, "", taut_connect("A Bad Name", &nobody, &error));
    CHECK(strcmp(taut_code_name(-6), "TIMED_OUT") == 0 && strcmp(taut_code_name(77), "UNKNOWN") == 0);
    EXPECT(TAUT_SUCCESS, taut_connect(NULL, &daemon_, &error));
    wrong_handles(&path);
    wrong_names(&path);
    wrong_constraints(&path);
    wrong_paths(&path);
    greed(&path);
    free(path.numbers);
    taut_close(daemon_);
    puts("wrong use is told");
    return 0;
}
