/* Replays what Python recorded: every step of the file is solved here, each warm start shifted from this program's own answer.
 * Prints one JSON document: steps, max_error (largest difference of a state or an input from Python's), apart (steps that differ by more
 * than 1e-6), mismatches (that ended otherwise or took another number of iterations), and the time of a step in microseconds. Memory is
 * taken once, before the first step. */

#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "mcdas_mpc.h"

#define MOST 200000
#define FARTHEST 1e300

typedef struct {
    int32_t slot, warm, iterations, ending, took;
} Head;

static mcdas_iterate slots[MCDAS_SLOTS];
static mcdas_answer answer;
static double times_us[MOST];
static double x0[MCDAS_NX], p[(MCDAS_NODES + 1) * MCDAS_NP], steps_s[MCDAS_NODES];
static double x[(MCDAS_NODES + 1) * MCDAS_NX], u[MCDAS_NODES * MCDAS_NU];

static int ascending(const void *a, const void *b)
{
    const double left = *(const double *)a, right = *(const double *)b;
    return (left > right) - (left < right);
}

static double now_us(void)
{
#if defined(_WIN32) /* C's own clock, which there tells the time that went by, to a millisecond */
    return 1e6 * (double)clock() / CLOCKS_PER_SEC;
#else
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e6 * (double)t.tv_sec + 1e-3 * (double)t.tv_nsec;
#endif
}

static int numbers(FILE *file, double *to, size_t count) { return fread(to, sizeof(double), count, file) == count; }

static double farthest(const double *a, const double *b, size_t count, double most)
{
    for (size_t i = 0; i < count; i++) {
        const double off = fabs(a[i] - b[i]);
        if (!(off <= most)) most = isfinite(off) ? off : FARTHEST; /* what is not a number is farthest of all */
    }
    return most;
}

int main(int argc, char **argv)
{
    const char *path = argc > 1 ? argv[1] : "replay.bin";
    FILE *file = fopen(path, "rb");
    int32_t sizes[6];
    Head head;
    double magic, off, error = 0.0, total = 0.0;
    int count = 0, apart = 0, mismatches = 0;
    const size_t bytes = mcdas_mpc_bytes();
    void *memory = malloc(bytes);
    mcdas_mpc *mpc = mcdas_mpc_init(memory, bytes);
    const int32_t wanted[6] = {MCDAS_NODES, MCDAS_NX, MCDAS_NU, MCDAS_NP, MCDAS_SLOTS, 0};

    if (file == NULL || mpc == NULL) {
        fprintf(stderr, "replay: %s\n", file == NULL ? "the recording cannot be read" : "no memory");
        return 1;
    }
    if (!numbers(file, &magic, 1) || magic != MCDAS_MAGIC || fread(sizes, sizeof sizes, 1, file) != 1 ||
        memcmp(sizes, wanted, sizeof sizes) != 0 || !numbers(file, steps_s, MCDAS_NODES)) {
        fprintf(stderr, "replay: %s is no recording of this solver (or of another byte order)\n", path);
        return 1;
    }
    while (count < MOST && fread(&head, sizeof head, 1, file) == 1) {
        int whole = head.slot >= 0 && head.slot < MCDAS_SLOTS && numbers(file, x0, MCDAS_NX) && numbers(file, p, sizeof p / sizeof *p);
        mcdas_iterate *guess = whole ? &slots[head.slot] : NULL;
        if (whole && head.warm)
            mcdas_mpc_shift(guess);
        else if (whole) {
            guess->warm = 0;
            whole = numbers(file, guess->x, sizeof x / sizeof *x) && numbers(file, guess->u, sizeof u / sizeof *u);
        }
        if (!whole || !numbers(file, x, sizeof x / sizeof *x) || !numbers(file, u, sizeof u / sizeof *u)) {
            fprintf(stderr, "replay: %s is cut off in step %d\n", path, count);
            return 1;
        }
        const double begun = now_us();
        mcdas_mpc_solve(mpc, x0, p, steps_s, guess, head.iterations, &answer);
        times_us[count] = now_us() - begun;
        total += times_us[count++];
        off = farthest(answer.iterate.x, x, sizeof x / sizeof *x, 0.0);
        off = farthest(answer.iterate.u, u, sizeof u / sizeof *u, off);
        if (off > error) error = off;
        apart += off > 1e-6;
        mismatches += (int32_t)answer.ending != head.ending || answer.iterations != head.took;
        *guess = answer.iterate;
    }
    fclose(file);
    free(memory);
    if (count == 0) {
        fprintf(stderr, "replay: %s holds no step\n", path);
        return 1;
    }
    qsort(times_us, (size_t)count, sizeof *times_us, ascending);
    printf("{\"steps\": %d, \"max_error\": %.17g, \"apart\": %d, \"mismatches\": %d, ", count, error, apart, mismatches);
    printf("\"timing_us\": {\"mean\": %.3f, \"p50\": %.3f, \"p99\": %.3f, \"max\": %.3f}}\n", total / count, times_us[count / 2],
           times_us[(int)(0.99 * (count - 1))], times_us[count - 1]);
    return 0;
}
