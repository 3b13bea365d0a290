/* Nanoseconds per call through the C functions: the least of many short batches, so that what else
   the machine does matters little. One line of JSON. */
#include "host.h"

#include <time.h>

enum { BATCHES = 400, CALLS = 2000 };

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* The least time of one call in ns; `k` counts all calls. */
#define MEASURE(result, call)                                                                      \
    do {                                                                                           \
        double least = INFINITY;                                                                   \
        for (int batch = 0; batch < BATCHES; ++batch) {                                            \
            double begin = seconds();                                                              \
            for (int i = 0; i < CALLS; ++i, ++k) {                                                 \
                CHECK((call) == fmi2OK, "%s", last_message);                                       \
            }                                                                                      \
            double per_call = (seconds() - begin) / CALLS * 1e9;                                   \
            if (per_call < least) least = per_call;                                                \
        }                                                                                          \
        result = least;                                                                            \
    } while (0)

int main(int argc, char **argv) {
    struct given given = given_by(argc, argv);
    struct library fmu = load(given.library, RTLD_NOW | RTLD_LOCAL);
    fmi2Component c = started(&fmu, &given, 0.0);
    double u[MOST], y[MOST], bare, set, get, idle, step, exchange, save, restore, h = given.period;
    fmi2FMUstate state = NULL;
    long k = 0;
    for (size_t i = 0; i < given.inputs; ++i) u[i] = 1.0;
    /* What every call costs: the instance, the table of states, the guard against unwinding. */
    MEASURE(bare, fmu.SetReal(c, NULL, 0, NULL));
    MEASURE(set, (u[0] = (double)(k & 63), fmu.SetReal(c, given.input, 1, u)));
    MEASURE(get, fmu.GetReal(c, given.output, 1, y));
    k = 0;
    /* Steps in which the model has nearly nothing to do: what is left is the edge. */
    double little = h / 65536.0;
    MEASURE(idle, fmu.DoStep(c, (double)k * little, little, fmi2True));
    double from = (double)k * little;
    k = 0;
    MEASURE(step, fmu.DoStep(c, from + (double)k * h, h, fmi2True));
    MEASURE(exchange, (u[0] = (double)(k & 63), fmu.SetReal(c, given.input, 1, u)) |
                          fmu.DoStep(c, from + (double)k * h, h, fmi2True) |
                          fmu.GetReal(c, given.output, 1, y));
    long end = k;
    save = restore = NAN;
    if (fmu.GetFMUstate(c, &state) == fmi2OK) {
        MEASURE(save, fmu.GetFMUstate(c, &state));
        MEASURE(restore, fmu.SetFMUstate(c, state));
        fmu.FreeFMUstate(c, &state);
    }
    fmu.FreeInstance(c);
    double begin = seconds();
    for (int i = 0; i < 20; ++i) fmu.FreeInstance(instantiate(&fmu, &given));
    double life = (seconds() - begin) / 20 * 1e6;
    printf("{\"bare\": %.2f, \"set\": %.2f, \"get\": %.2f, \"idle_step\": %.2f, \"step\": %.2f, \"exchange\": %.2f, ",
           bare, set, get, idle, step, exchange);
    if (!isnan(save)) printf("\"save\": %.2f, \"restore\": %.2f, ", save, restore);
    printf("\"instantiate_us\": %.1f, \"steps\": %ld}\n", life, end);
    return 0;
}
