/* What the C hosts of the tests share: an FMU's library loaded by name, its arguments, checks.
   Compiled against the standard's own headers. */
#ifndef HOST_H
#define HOST_H

#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
/* The little of dlfcn.h that the hosts for all machines need. */
enum { RTLD_NOW, RTLD_LOCAL };
static inline void *dlopen(const char *path, int flags) {
    (void)flags;
    return (void *)LoadLibraryA(path);
}
static inline void *dlsym(void *handle, const char *name) {
    return (void *)(intptr_t)GetProcAddress((HMODULE)handle, name);
}
static inline const char *dlerror(void) { return "the library does not load"; }
#else
#include <dlfcn.h>
#endif

#include "fmi2FunctionTypes.h"

/* Ends the host with a line that says what was wrong. */
#define CHECK(condition, ...)                                                                      \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            fprintf(stderr, "%s:%d: not so: %s: ", __FILE__, __LINE__, #condition);                \
            fprintf(stderr, __VA_ARGS__);                                                          \
            fprintf(stderr, "\n");                                                                 \
            exit(1);                                                                               \
        }                                                                                          \
    } while (0)

/* All functions of FMI 2.0, in the order of the header. */
#define FMI2_FUNCTIONS(X)                                                                          \
    X(GetTypesPlatform) X(GetVersion) X(SetDebugLogging) X(Instantiate) X(FreeInstance)            \
    X(SetupExperiment) X(EnterInitializationMode) X(ExitInitializationMode) X(Terminate) X(Reset)  \
    X(GetReal) X(GetInteger) X(GetBoolean) X(GetString)                                            \
    X(SetReal) X(SetInteger) X(SetBoolean) X(SetString)                                            \
    X(GetFMUstate) X(SetFMUstate) X(FreeFMUstate)                                                  \
    X(SerializedFMUstateSize) X(SerializeFMUstate) X(DeSerializeFMUstate)                          \
    X(GetDirectionalDerivative) X(EnterEventMode) X(NewDiscreteStates) X(EnterContinuousTimeMode)  \
    X(CompletedIntegratorStep) X(SetTime) X(SetContinuousStates) X(GetDerivatives)                 \
    X(GetEventIndicators) X(GetContinuousStates) X(GetNominalsOfContinuousStates)                  \
    X(SetRealInputDerivatives) X(GetRealOutputDerivatives) X(DoStep) X(CancelStep)                 \
    X(GetStatus) X(GetRealStatus) X(GetIntegerStatus) X(GetBooleanStatus) X(GetStringStatus)

#define MOST 16

/* The arguments of every host: library GUID resources period inputs outputs […], references as
   numbers with commas between. */
struct given {
    const char *library, *guid, *resources;
    double period;
    size_t inputs, outputs;
    fmi2ValueReference input[MOST], output[MOST];
};

/* A loaded library and its functions. */
struct library {
    void *handle;
#define X(name) fmi2##name##TYPE *name;
    FMI2_FUNCTIONS(X)
#undef X
};

static inline size_t references(const char *text, fmi2ValueReference *into) {
    size_t count = 0;
    while (*text) {
        char *end;
        CHECK(count < MOST, "too many references: %s", text);
        into[count++] = (fmi2ValueReference)strtoul(text, &end, 10);
        text = *end == ',' ? end + 1 : end;
    }
    return count;
}

static inline struct given given_by(int argc, char **argv) {
    CHECK(argc >= 7, "give library, GUID, resources, period, inputs, outputs");
    struct given given = {argv[1], argv[2], argv[3], strtod(argv[4], NULL), 0, 0, {0}, {0}};
    given.inputs = references(argv[5], given.input);
    given.outputs = references(argv[6], given.output);
    return given;
}

static inline struct library load(const char *path, int flags) {
    struct library library;
    library.handle = dlopen(path, flags);
    CHECK(library.handle, "%s", dlerror());
#define X(name)                                                                                    \
    library.name = (fmi2##name##TYPE *)dlsym(library.handle, "fmi2" #name);                        \
    CHECK(library.name, "%s has no fmi2" #name, path);
    FMI2_FUNCTIONS(X)
#undef X
    return library;
}

/* The last message of any instance, for what a test wants to know about it. */
static char last_message[1000];
static int messages;

static inline void remember(fmi2ComponentEnvironment environment, fmi2String instance,
                            fmi2Status status, fmi2String category, fmi2String message, ...) {
    (void)environment, (void)instance, (void)status, (void)category;
    va_list values;
    va_start(values, message);
    vsnprintf(last_message, sizeof last_message, message, values);
    va_end(values);
    ++messages;
}

static inline const fmi2CallbackFunctions *callbacks(void) {
    static const fmi2CallbackFunctions all = {remember, calloc, free, NULL, NULL};
    return &all;
}

static inline fmi2Component instantiate(const struct library *fmu, const struct given *given) {
    fmi2Component c = fmu->Instantiate("instance", fmi2CoSimulation, given->guid, given->resources,
                                       callbacks(), fmi2False, fmi2False);
    CHECK(c, "%s", last_message);
    return c;
}

static inline void start(const struct library *fmu, fmi2Component c, double time) {
    CHECK(fmu->SetupExperiment(c, fmi2False, 0, time, fmi2False, 0) == fmi2OK, "%s", last_message);
    CHECK(fmu->EnterInitializationMode(c) == fmi2OK, "%s", last_message);
    CHECK(fmu->ExitInitializationMode(c) == fmi2OK, "%s", last_message);
}

static inline fmi2Component started(const struct library *fmu, const struct given *given,
                                    double time) {
    fmi2Component c = instantiate(fmu, given);
    start(fmu, c, time);
    return c;
}

static inline void get(const struct library *fmu, fmi2Component c, const struct given *given,
                       double *values) {
    fmi2Status status = fmu->GetReal(c, given->output, given->outputs, values);
    CHECK(status == fmi2OK, "%s", last_message);
}

static inline void set(const struct library *fmu, fmi2Component c, const struct given *given,
                       const double *values) {
    fmi2Status status = fmu->SetReal(c, given->input, given->inputs, values);
    CHECK(status == fmi2OK, "%s", last_message);
}

static inline void step(const struct library *fmu, fmi2Component c, double time, double size) {
    CHECK(fmu->DoStep(c, time, size, fmi2True) == fmi2OK, "%s", last_message);
}

/* Nearly the sine, of which the C libraries of different machines compute different bits. */
static inline double swing(double phase) {
    double turn = phase / 6.283185307179586;
    turn -= floor(turn);
    return turn < 0.5 ? 16.0 * turn * (0.5 - turn) : -16.0 * (turn - 0.5) * (1.0 - turn);
}

/* Inputs that move every state, in the units of plant and controller alike. */
static inline void wave(const struct given *given, double time, double *values) {
    for (size_t i = 0; i < given->inputs; ++i)
        values[i] = 2.0 + (1.5 + 0.1 * (double)i) * swing(700.0 * time + (double)i) +
                    0.4 * swing(5000.0 * time);
}

/* The time at which the wave begins. */
static double wave_begin = 0.0;

/* Runs the wave for some steps of the internal period and ends with the outputs. */
static inline void run(const struct library *fmu, fmi2Component c, const struct given *given,
                       double time, int steps, double *outputs) {
    double inputs[MOST];
    for (int k = 0; k < steps; ++k) {
        double now = time + k * given->period;
        wave(given, (time - wave_begin) + k * given->period, inputs);
        set(fmu, c, given, inputs);
        step(fmu, c, now, given->period);
    }
    get(fmu, c, given, outputs);
}

static inline int same_bits(const double *a, const double *b, size_t count) {
    return memcmp(a, b, count * sizeof *a) == 0;
}

static inline void print_bits(const double *values, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        uint64_t bits;
        memcpy(&bits, values + i, sizeof bits);
        printf("%016llx%c", (unsigned long long)bits, i + 1 < count ? ' ' : '\n');
    }
}

/* Random numbers (splitmix64): the same sequence everywhere from the same seed. */
static inline uint64_t random_bits(uint64_t *seed) {
    uint64_t z = (*seed += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

/* In [0, 1). */
static inline double random_unit(uint64_t *seed) {
    return (double)(random_bits(seed) >> 11) * 0x1p-53;
}

/* The process's resident memory in bytes. */
static inline long resident(void) {
    long pages = 0, resident = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    CHECK(file && fscanf(file, "%ld %ld", &pages, &resident) == 2, "no /proc/self/statm");
    fclose(file);
    return resident * 4096;
}

#endif
