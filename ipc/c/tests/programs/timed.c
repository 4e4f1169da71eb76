/* A trajectory, its bits in hexadecimal, one number a line: timed PATH. Robot and scene "arm_window" are loaded. */
#include "common.h"

static void show(double number) {
    uint64_t bits;
    memcpy(&bits, &number, sizeof bits);
    printf("%016llx\n", (unsigned long long)bits);
}

int main(int count, char **arguments) {
    taut_error *error = NULL;
    taut_daemon *daemon_;
    taut_options options;
    taut_answers *answers;
    taut_answer *answer;
    taut_trajectory found;
    test_path path;
    size_t index;
    CHECK(count == 2);
    path = read_path(arguments[1]);
    EXPECT(TAUT_SUCCESS, taut_connect(NULL, &daemon_, &error));
    taut_options_default(&options, sizeof options);
    options.work_budget = 20000;
    options.timing = "acceleration=2/s speed=0.5 work=20000";
    EXPECT(TAUT_SUCCESS, taut_shorten(daemon_, "arm_window", "arm_window", path.numbers, path.waypoints, path.columns,
                             &options, &answers, &error));
    EXPECT(TAUT_SUCCESS, taut_result(answers, 60, &answer, &error));
    EXPECT(TAUT_SUCCESS, taut_answer_trajectory(answer, &found, sizeof found, &error));
    for (index = 0; index < found.points; ++index) printf("%016llx\n", (unsigned long long)found.times_ns[index]);
    for (index = 0; index < found.points * found.columns; ++index) show(found.positions[index]);
    for (index = 0; index < found.points * found.columns; ++index) show(found.velocities[index]);
    taut_answer_free(answer);
    taut_answers_free(answers);
    free(path.numbers);
    taut_close(daemon_);
    return 0;
}
