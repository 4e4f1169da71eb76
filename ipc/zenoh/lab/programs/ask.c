/* Has the problem of a folder answered and prints length and path, each number by its bits. */
#include "taut.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double path[][2] = {{-2, 0}, {-1.5, 1}, {-0.7, 1.6}, {0.1, 1.8}, {0.9, 1.5}, {1.5, 0.8}, {2, 0}};
enum { WAYPOINTS = sizeof path / sizeof path[0], COLUMNS = 2 };
static const char *const columns[COLUMNS] = {"x", "y"};

static void expect(int32_t code, taut_error **error) {
    if (code == TAUT_SUCCESS) return;
    fprintf(stderr, "%s: %s\n", taut_code_name(code), taut_error_message(*error));
    exit(1);
}

static void print(double number) {
    uint64_t bits;
    memcpy(&bits, &number, sizeof bits);
    printf("%016" PRIx64 "\n", bits);
}

static char *text_of(const char *name) {
    static char text[4096];
    FILE *file = fopen(name, "rb");
    if (!file) exit(1);
    text[fread(text, 1, sizeof text - 1, file)] = 0;
    fclose(file);
    return text;
}

int main(int count, char **arguments) {
    char urdf[512], scene[512];
    taut_robot_files files = {.size = sizeof files, .urdf = urdf};
    taut_daemon *daemon;
    taut_answers *answers;
    taut_answer *answer;
    taut_options options;
    taut_error *error;
    int32_t code;

    if (count < 2) return 1;
    snprintf(urdf, sizeof urdf, "%s/cart.urdf", arguments[1]);
    snprintf(scene, sizeof scene, "%s/scene.json", arguments[1]);
    expect(taut_connect(NULL, &daemon, &error), &error);
    expect(taut_load_robot(daemon, "cart_in_c", &files, false, NULL, &error), &error);
    expect(taut_load_scene(daemon, "wall_in_c", text_of(scene), arguments[1], false, NULL, 0, &error), &error);
    taut_options_default(&options, sizeof options);
    options.work_budget = 6000;
    options.seed = 7;
    options.columns = columns;
    options.column_count = COLUMNS;
    expect(taut_shorten(daemon, "cart_in_c", "wall_in_c", path[0], WAYPOINTS, COLUMNS, &options, &answers, &error),
        &error);
    while ((code = taut_next(answers, 1.0, &answer, &error)) != TAUT_END) {
        taut_info info;
        taut_rows rows;
        if (code == TAUT_PENDING) continue;
        expect(code, &error);
        expect(taut_answer_info(answer, &info, sizeof info, &error), &error);
        expect(taut_answer_rows(answer, &rows, sizeof rows, &error), &error);
        if (info.is_final) {
            print(info.length_after);
            for (size_t row = 0; row < rows.waypoints; row++)
                for (size_t column = 0; column < COLUMNS; column++) print(rows.first[row * rows.stride + column]);
        }
        taut_answer_free(answer);
    }
    taut_answers_free(answers);
    taut_close(daemon);
    return 0;
}
