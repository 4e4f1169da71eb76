/*
 * A planner in C: loads a robot and a scene, has a path shortened, prints each improvement, keeps the last.
 *
 *   gcc -std=c11 -Iipc/c/include examples/c/shorten.c -Ltarget/release -ltaut -Wl,-rpath,$PWD/target/release -o shorten
 *   ./shorten config
 */
#include "taut.h"

#include <stdio.h>
#include <stdlib.h>

/* What a planner found: turn to a wall, reach through its window (config/problems/arm_window.json). */
static const double path[][7] = {
    {-1.5, -0.4, 0.0, -2.2, 0.0, 1.9, 0.785},
    {-1.437788, -0.329843, 0.387754, -2.488961, -0.084143, 1.569325, -0.097564},
    {-1.240192, -0.487351, 0.635639, -2.506844, 0.533576, 1.897626, 0.465073},
    {-1.133743, -0.572205, 0.76918, -2.516478, 0.866355, 2.074489, 0.768179},
    {-0.930693, -0.759014, 1.080606, -2.462474, 0.903104, 2.337022, 1.343845},
    {-1.169123, -0.872609, 1.305671, -2.331107, 1.552551, 2.257014, 1.113459},
    {-1.284336, -1.197473, 1.214081, -2.315599, 1.304429, 2.469726, 1.714743},
    {-1.578729, -1.185159, 1.253734, -2.256439, 2.077625, 2.353562, 1.658777},
    {-1.6131, -1.466, 1.3759, -2.1759, 2.819, 2.4679, 2.1542}};
enum { WAYPOINTS = sizeof path / sizeof path[0], COLUMNS = 7 };

static const char *const columns[COLUMNS] = {
    "joint1", "joint2", "joint3", "joint4", "joint5", "joint6", "joint7"};

/* Ends the program with what went wrong, and where on the path. */
static void expect(int32_t code, taut_error **error) {
    taut_place place;
    if (code == TAUT_SUCCESS) return;
    fprintf(stderr, "%s: %s\n", taut_code_name(code), taut_error_message(*error));
    if (taut_error_place(*error, &place, sizeof place))
        fprintf(stderr, "  %s %s, segment %u, t = %.3f: %g kept of %g\n", place.names[0], place.names[1],
            (unsigned)place.segment, place.t, place.amount, place.allowed);
    exit(1);
}

/* A whole file as a string. */
static char *text_of(const char *name) {
    FILE *file = fopen(name, "rb");
    long size;
    char *text;
    if (!file || fseek(file, 0, SEEK_END) || (size = ftell(file)) < 0) {
        fprintf(stderr, "%s cannot be read\n", name);
        exit(1);
    }
    rewind(file);
    text = malloc((size_t)size + 1);
    text[fread(text, 1, (size_t)size, file)] = 0;
    fclose(file);
    return text;
}

int main(int count, char **arguments) {
    const char *config = count > 1 ? arguments[1] : "config";
    char urdf[512], srdf[512], scene_file[512];
    taut_robot_files files = {.size = sizeof files, .urdf = urdf, .srdf = srdf};
    taut_daemon *daemon;
    taut_answers *answers;
    taut_answer *answer;
    taut_options options;
    taut_error *error;
    double kept[256][COLUMNS];
    int32_t code;

    snprintf(urdf, sizeof urdf, "%s/robots/panda_like.urdf", config);
    snprintf(srdf, sizeof srdf, "%s/robots/panda_like.srdf", config);
    snprintf(scene_file, sizeof scene_file, "%s/scenes/arm_window.json", config);
    char *scene = text_of(scene_file);

    /* Once. */
    expect(taut_connect(NULL, &daemon, &error), &error);
    expect(taut_load_robot(daemon, "c_arm", &files, false, NULL, &error), &error);
    expect(taut_load_scene(daemon, "c_window", scene, NULL, false, NULL, 0, &error), &error);
    free(scene);

    /* For each path. */
    taut_options_default(&options, sizeof options);
    options.deadline_s = 5;
    options.columns = columns;
    options.column_count = COLUMNS;
    expect(taut_shorten(daemon, "c_arm", "c_window", path[0], WAYPOINTS, COLUMNS, &options, &answers, &error), &error);
    while ((code = taut_next(answers, 1.0, &answer, &error)) != TAUT_END) {
        taut_info info;
        taut_rows rows;
        if (code == TAUT_PENDING) continue;
        expect(code, &error);
        expect(taut_answer_info(answer, &info, sizeof info, &error), &error);
        expect(taut_answer_rows(answer, &rows, sizeof rows, &error), &error); /* in shared memory */
        printf("length %.4f -> %.4f, %zu waypoints, %s, joint1 of the second is %.3f\n", info.length_before,
            info.length_after, rows.waypoints, info.proved ? "proved" : "not proved", rows.first[rows.stride]);
        if (info.is_final) expect(taut_answer_copy(answer, kept[0], sizeof kept / sizeof(double), &error), &error);
        taut_answer_free(answer);
    }
    printf("kept: from %.3f to joint1 = %.3f\n", kept[0][0], kept[1][0]);
    taut_answers_free(answers);
    taut_close(daemon);
    return 0;
}
