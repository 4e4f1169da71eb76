/* Waits for an answer that never comes, in two threads; says so; ends with what both got: daemon_dies PATH. */
#include "common.h"

#include <pthread.h>

static taut_answers *answers;
static int32_t codes[2];

static void *wait_for_it(void *code) {
    taut_answer *answer;
    do {
        *(int32_t *)code = taut_next(answers, INFINITY, &answer, NULL);
        if (*(int32_t *)code == TAUT_SUCCESS) taut_answer_free(answer);
    } while (*(int32_t *)code == TAUT_SUCCESS);
    return NULL;
}

int main(int count, char **arguments) {
    taut_error *error;
    taut_daemon *daemon;
    taut_options options;
    pthread_t thread;
    test_path path;
    CHECK(count == 2);
    path = read_path(arguments[1]);
    EXPECT(TAUT_SUCCESS, taut_connect(NULL, &daemon, &error));
    taut_options_default(&options, sizeof options);
    options.mode = TAUT_MODE_RANDOM_SHORTCUT;
    options.seed = 0x4a464a464a464a46; /* does not end by itself */
    EXPECT(TAUT_SUCCESS, taut_shorten(daemon, "arm_window", "arm_window", path.numbers, path.waypoints, 7, &options,
                             &answers, &error));
    free(path.numbers);
    CHECK(pthread_create(&thread, NULL, wait_for_it, &codes[1]) == 0);
    puts("waiting");
    fflush(stdout);
    wait_for_it(&codes[0]);
    pthread_join(thread, NULL);
    taut_answers_free(answers);
    taut_close(daemon);
    printf("%s %s\n", taut_code_name(codes[0]), taut_code_name(codes[1]));
    return 0;
}
