/* The loop of exchange.rs by the bare C functions: bare CONTROLLER.so PLANT.so STEPS REPEATS
 * Prints the best time of some repeats, ns per step and FMU. */
#include <dlfcn.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

struct callbacks { void *logger, *allocate, *release, *finished, *environment; };
typedef void *instantiate_type(const char *, int, const char *, const char *, const struct callbacks *, int, int);
typedef int phase_type(void *);
typedef int real_type(void *, const uint32_t *, size_t, double *);
typedef int step_type(void *, double, double, int);

struct fmu { void *instance; real_type *set, *get; step_type *step; };

static const double H = 1e-3;

static void *function(void *library, const char *name) {
    void *found = dlsym(library, name);
    if (!found) { fprintf(stderr, "no %s\n", name); exit(1); }
    return found;
}

static struct fmu load(const char *path, const char *guid) {
    static const struct callbacks callbacks;
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) { fprintf(stderr, "%s\n", dlerror()); exit(1); }
    struct fmu fmu = { .set = (real_type *)function(library, "fmi2SetReal"),
                       .get = (real_type *)function(library, "fmi2GetReal"),
                       .step = (step_type *)function(library, "fmi2DoStep") };
    instantiate_type *instantiate = (instantiate_type *)function(library, "fmi2Instantiate");
    fmu.instance = instantiate("bare", 1, guid, "file:///", &callbacks, 0, 0);
    if (!fmu.instance) { fprintf(stderr, "%s: no instance\n", path); exit(1); }
    ((phase_type *)function(library, "fmi2EnterInitializationMode"))(fmu.instance);
    ((phase_type *)function(library, "fmi2ExitInitializationMode"))(fmu.instance);
    return fmu;
}

static double exchange(const struct fmu *fmu, double time, const double *inputs, size_t count, uint32_t output) {
    static const uint32_t references[] = { 0, 1 };
    double y = 0.0;
    fmu->set(fmu->instance, references, count, (double *)inputs);
    fmu->step(fmu->instance, time, H, 1);
    fmu->get(fmu->instance, &output, 1, &y);
    return y;
}

int main(int count, char **arguments) {
    if (count != 5) return 2;
    long steps = atol(arguments[3]), repeats = atol(arguments[4]);
    double best = 1e300;
    for (long r = 0; r < repeats; r++) {
        struct fmu controller = load(arguments[1], "controller"), plant = load(arguments[2], "integrator");
        struct timespec begin, end;
        double y = 0.0;
        clock_gettime(CLOCK_MONOTONIC, &begin);
        for (long k = 0; k < steps; k++) {
            double inputs[] = { 1.0, y };
            double u = exchange(&controller, k * H, inputs, 2, 2);
            y = exchange(&plant, k * H, &u, 1, 1);
        }
        clock_gettime(CLOCK_MONOTONIC, &end);
        double ns = (end.tv_sec - begin.tv_sec) * 1e9 + (end.tv_nsec - begin.tv_nsec);
        if (ns / (2 * steps) < best) best = ns / (2 * steps);
        if (y != y) return 1;
    }
    printf("%.3f\n", best);
    return 0;
}
