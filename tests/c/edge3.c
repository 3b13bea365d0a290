/* As edge.c, through the functions of FMI 3.0. Arguments as there; one line of JSON. */
#include "host.h"

#include <time.h>

#include "fmi3FunctionTypes.h"

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
            for (int i = 0; i < CALLS; ++i, ++k) CHECK((call) == fmi3OK, "a call failed");         \
            double per_call = (seconds() - begin) / CALLS * 1e9;                                   \
            if (per_call < least) least = per_call;                                                \
        }                                                                                          \
        result = least;                                                                            \
    } while (0)

#define FUNCTION(name) fmi3##name##TYPE *name = (fmi3##name##TYPE *)dlsym(library, "fmi3" #name)

int main(int argc, char **argv) {
    struct given given = given_by(argc, argv);
    void *library = dlopen(given.library, RTLD_NOW | RTLD_LOCAL);
    CHECK(library, "%s", dlerror());
    FUNCTION(InstantiateCoSimulation);
    FUNCTION(FreeInstance);
    FUNCTION(EnterInitializationMode);
    FUNCTION(ExitInitializationMode);
    FUNCTION(SetFloat64);
    FUNCTION(GetFloat64);
    FUNCTION(DoStep);
    fmi3Instance c =
        InstantiateCoSimulation("instance", given.guid, given.resources, fmi3False, fmi3False,
                                fmi3False, fmi3False, NULL, 0, NULL, NULL, NULL);
    CHECK(c, "no instance");
    CHECK(EnterInitializationMode(c, fmi3False, 0, 0, fmi3False, 0) == fmi3OK, "initialization");
    CHECK(ExitInitializationMode(c) == fmi3OK, "initialization");
    double u = 1, y, last, bare, set, get, idle, step, exchange, h = given.period;
    fmi3Boolean a, b, e;
    long k = 0;
    MEASURE(bare, SetFloat64(c, NULL, 0, NULL, 0));
    MEASURE(set, (u = (double)(k & 63), SetFloat64(c, given.input, 1, &u, 1)));
    MEASURE(get, GetFloat64(c, given.output, 1, &y, 1));
    k = 0;
    double little = h / 65536.0;
    MEASURE(idle, DoStep(c, (double)k * little, little, fmi3True, &a, &b, &e, &last));
    double from = (double)k * little;
    k = 0;
    MEASURE(step, DoStep(c, from + (double)k * h, h, fmi3True, &a, &b, &e, &last));
    MEASURE(exchange, (u = (double)(k & 63), SetFloat64(c, given.input, 1, &u, 1)) |
                          DoStep(c, from + (double)k * h, h, fmi3True, &a, &b, &e, &last) |
                          GetFloat64(c, given.output, 1, &y, 1));
    FreeInstance(c);
    printf("{\"bare\": %.2f, \"set\": %.2f, \"get\": %.2f, \"idle_step\": %.2f, \"step\": %.2f, \"exchange\": %.2f}\n",
           bare, set, get, idle, step, exchange);
    return 0;
}
