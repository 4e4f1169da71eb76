/* What the test programs share: checks that name their line, and a path from a file. */
#ifndef COMMON_H
#define COMMON_H

#include "taut.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Ends the program where something is not so. */
#define CHECK(so)                                                                                                  \
    do {                                                                                                           \
        if (!(so)) {                                                                                               \
            fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #so);                                       \
            exit(1);                                                                                               \
        }                                                                                                          \
    } while (0)

/* Ends the program where a call gives another code; tells what the error says. */
#define EXPECT(expected, call)                                                                                     \
    do {                                                                                                           \
        const int32_t found_ = (call);                                                                             \
        if (found_ != (expected)) {                                                                                \
            fprintf(stderr, "%s:%d: %s instead of %s: %s\n  %s\n", __FILE__, __LINE__, taut_code_name(found_),       \
                taut_code_name(expected), #call, taut_error_message(error));                                       \
            exit(1);                                                                                               \
        }                                                                                                          \
        CHECK((found_ < 0) == (taut_error_code(error) == found_) || found_ == TAUT_SUCCESS);                       \
    } while (0)

/* Ends the program where a call does not fail with this code and a message that has this word; frees the error. */
#define REFUSED(expected, word, call)                                                                              \
    do {                                                                                                           \
        EXPECT(expected, call);                                                                                    \
        if (!strstr(taut_error_message(error), word)) {                                                            \
            fprintf(stderr, "%s:%d: no \"%s\" in: %s\n", __FILE__, __LINE__, word, taut_error_message(error));       \
            exit(1);                                                                                               \
        }                                                                                                          \
        taut_error_free(error);                                                                                    \
        error = NULL;                                                                                              \
    } while (0)

typedef struct test_path {
    double *numbers;
    size_t waypoints, columns;
} test_path;

/* The path that a file holds: waypoints, columns, numbers. */
static test_path read_path(const char *name) {
    test_path path;
    size_t count, index;
    FILE *file = fopen(name, "r");
    CHECK(file && fscanf(file, "%zu %zu", &path.waypoints, &path.columns) == 2);
    count = path.waypoints * path.columns;
    path.numbers = (double *)malloc(count * sizeof(double));
    for (index = 0; index < count; ++index) CHECK(fscanf(file, "%lf", &path.numbers[index]) == 1);
    fclose(file);
    return path;
}

#endif
