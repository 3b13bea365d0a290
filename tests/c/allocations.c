/* Counts what the packed library allocates and frees, by standing before the C library's
   functions, while an importer sets, steps and gets. */
#include "host.h"

#include <errno.h>

#include "fmi3FunctionTypes.h"

extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t);
extern void *__libc_memalign(size_t, size_t);
extern void __libc_free(void *);

static volatile long calls;

void *malloc(size_t size) { return ++calls, __libc_malloc(size); }
void *calloc(size_t count, size_t size) { return ++calls, __libc_calloc(count, size); }
void *realloc(void *old, size_t size) { return ++calls, __libc_realloc(old, size); }
void *memalign(size_t alignment, size_t size) { return ++calls, __libc_memalign(alignment, size); }
void *aligned_alloc(size_t alignment, size_t size) { return memalign(alignment, size); }
int posix_memalign(void **into, size_t alignment, size_t size) {
    *into = memalign(alignment, size);
    return *into ? 0 : ENOMEM;
}
void free(void *memory) { ++calls, __libc_free(memory); }

static void nothing(const char *what, long before) {
    CHECK(calls == before, "%s: %ld calls of the allocator", what, calls - before);
}

static void version2(const struct given *given) {
    struct library fmu = load(given->library, RTLD_NOW | RTLD_LOCAL);
    long before = calls;
    fmi2Component c = instantiate(&fmu, given);
    CHECK(calls > before + 10, "instantiation allocates, so that the count would show it");
    start(&fmu, c, 0.0);
    fmi2FMUstate state = NULL;
    CHECK(fmu.GetFMUstate(c, &state) == fmi2OK, "%s", last_message);

    double inputs[MOST], outputs[MOST];
    fmi2Integer orders[MOST];
    before = calls;
    for (int k = 0; k < 20000; ++k) {
        double now = k * given->period;
        wave(given, now, inputs);
        set(&fmu, c, given, inputs);
        if (k % 3 == 0) {
            for (size_t i = 0; i < given->inputs; ++i) orders[i] = 1, inputs[i] = 10.0;
            CHECK(fmu.SetRealInputDerivatives(c, given->input, given->inputs, orders, inputs) ==
                      fmi2OK, "%s", last_message);
        }
        step(&fmu, c, now, given->period);
        get(&fmu, c, given, outputs);
        double last;
        fmi2Boolean ended;
        CHECK(fmu.GetRealStatus(c, fmi2LastSuccessfulTime, &last) == fmi2OK, "%s", last_message);
        CHECK(fmu.GetBooleanStatus(c, fmi2Terminated, &ended) == fmi2OK, "%s", last_message);
    }
    nothing("20000 times set, step, get", before);
    step(&fmu, c, 20000 * given->period, 1000.3 * given->period);
    nothing("one step of many periods", before);
    for (int k = 0; k < 100; ++k) {
        CHECK(fmu.GetFMUstate(c, &state) == fmi2OK, "%s", last_message);
        CHECK(fmu.SetFMUstate(c, state) == fmi2OK, "%s", last_message);
    }
    nothing("100 times saved into the same state and restored", before);
    for (int k = 0; k < 100; ++k) {
        double seed = 1.0, derivative;
        CHECK(fmu.GetDirectionalDerivative(c, given->output, 1, given->input, 1, &seed,
                                           &derivative) == fmi2OK, "%s", last_message);
    }
    nothing("100 directional derivatives", before);
    CHECK(fmu.FreeFMUstate(c, &state) == fmi2OK && calls > before, "freeing is counted");
    fmu.FreeInstance(c);
    printf("FMI 2.0: 20000 times set, derivatives, step, get: 0 calls of the allocator\n");
}

static void ignore3(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                    fmi3String message) {
    (void)environment, (void)status, (void)category;
    snprintf(last_message, sizeof last_message, "%s", message);
}

#define FUNCTION3(name)                                                                            \
    fmi3##name##TYPE *name = (fmi3##name##TYPE *)dlsym(handle, "fmi3" #name);                      \
    CHECK(name, "no fmi3" #name)

/* The two further arguments are the numbers of input and output values: arrays count each. */
static void version3(const struct given *given, size_t inputs, size_t outputs) {
    void *handle = dlopen(given->library, RTLD_NOW | RTLD_LOCAL);
    CHECK(handle, "%s", dlerror());
    FUNCTION3(InstantiateCoSimulation);
    FUNCTION3(EnterInitializationMode);
    FUNCTION3(ExitInitializationMode);
    FUNCTION3(SetFloat64);
    FUNCTION3(GetFloat64);
    FUNCTION3(DoStep);
    FUNCTION3(FreeInstance);
    long before = calls;
    fmi3Instance c = InstantiateCoSimulation("instance", given->guid, given->resources, false,
                                             false, false, false, NULL, 0, NULL, ignore3, NULL);
    CHECK(c, "%s", last_message);
    CHECK(calls > before + 10, "instantiation allocates, so that the count would show it");
    CHECK(EnterInitializationMode(c, false, 0, 0, false, 0) == fmi3OK, "%s", last_message);
    CHECK(ExitInitializationMode(c) == fmi3OK, "%s", last_message);
    double values[MOST];
    struct given flat = *given;
    flat.inputs = inputs;
    before = calls;
    for (int k = 0; k < 20000; ++k) {
        double now = k * given->period, last;
        bool event, end, early;
        wave(&flat, now, values);
        CHECK(SetFloat64(c, given->input, given->inputs, values, inputs) == fmi3OK, "%s",
              last_message);
        CHECK(DoStep(c, now, given->period, true, &event, &end, &early, &last) == fmi3OK, "%s",
              last_message);
        CHECK(GetFloat64(c, given->output, given->outputs, values, outputs) == fmi3OK, "%s",
              last_message);
    }
    nothing("20000 times set, step, get", before);
    FreeInstance(c);
    printf("FMI 3.0: 20000 times set, step, get: 0 calls of the allocator\n");
}

int main(int argc, char **argv) {
    struct given given = given_by(argc, argv);
    if (argc == 7)
        version2(&given);
    else
        version3(&given, strtoul(argv[7], NULL, 10), strtoul(argv[8], NULL, 10));
    return 0;
}
