/* What the test FMUs have in common: the functions of FMI 2.0 co-simulation around a small struct.
 *
 * A model is a file that includes this one and defines GUID and `static fmi2Status model_step`.
 * Value references are indices into the arrays of `Slave`. The declarations are the test's own;
 * only what is needed is here. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL, PENDING } Status;
typedef void (*Logger)(void *environment, const char *instance, Status status,
                       const char *category, const char *message, ...);
typedef struct {
    Logger logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, Status);
    void *environment;
} Callbacks;

#define REALS 8
#define INTEGERS 4
#define BOOLEANS 4

typedef struct {
    double reals[REALS];
    int integers[INTEGERS];
    int booleans[BOOLEANS];
    double time;
    double stop;
    int phase; /* 0 instantiated, 1 initialization, 2 stepping, 3 terminated, 4 error */
} State;

typedef struct {
    State state;
    State start;
    Callbacks callbacks;
    char name[64];
    char label[64];
    char history[256]; /* one letter per call, for tests of the order of calls */
    size_t noted;
    double reached;
} Slave;

#define EXPORT __attribute__((visibility("default")))

/* Status of a step; message through say(). */
static Status model_step(Slave *slave, double step);
static void model_start(State *state);

static void say(Slave *slave, Status status, const char *text) {
    if (slave->callbacks.logger)
        slave->callbacks.logger(slave->callbacks.environment, slave->name, status, "logStatus",
                                text);
}

static void note(Slave *slave, char letter) {
    if (slave->noted + 1 < sizeof slave->history) slave->history[slave->noted++] = letter;
}

static Status fail(Slave *slave, const char *text) {
    slave->state.phase = 4;
    say(slave, ERROR, text);
    return ERROR;
}

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

EXPORT void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                             const Callbacks *callbacks, int visible, int logging) {
    (void)visible;
    (void)logging;
    if (!name || !*name || type != 1 || !resources) return NULL;
    if (strcmp(guid, GUID) != 0) {
        callbacks->logger(callbacks->environment, name, ERROR, "logStatus",
                          "the GUID is not 100%% mine");
        return NULL;
    }
    Slave *slave = calloc(1, sizeof *slave);
    slave->callbacks = *callbacks;
    strncpy(slave->name, name, sizeof slave->name - 1);
    model_start(&slave->state);
    slave->start = slave->state;
    return slave;
}

EXPORT void fmi2FreeInstance(void *c) { free(c); }

EXPORT Status fmi2SetupExperiment(void *c, int tolerance_defined, double tolerance, double start,
                                  int stop_defined, double stop) {
    (void)tolerance_defined;
    (void)tolerance;
    Slave *slave = c;
    note(slave, 's');
    slave->state.time = start;
    slave->state.stop = stop_defined ? stop : 1e300;
    return OK;
}

EXPORT Status fmi2EnterInitializationMode(void *c) {
    Slave *slave = c;
    note(slave, 'e');
    if (slave->state.phase != 0) return fail(slave, "initialization begins twice");
    slave->state.phase = 1;
    return OK;
}

EXPORT Status fmi2ExitInitializationMode(void *c) {
    Slave *slave = c;
    note(slave, 'x');
    if (slave->state.phase != 1) return fail(slave, "initialization has not begun");
    slave->state.phase = 2;
    return OK;
}

EXPORT Status fmi2DoStep(void *c, double time, double step, int forget) {
    (void)forget;
    Slave *slave = c;
    if (slave->state.phase != 2) return fail(slave, "step outside step mode");
    note(slave, 'd');
    if (time > slave->state.time + 1e-9 || time < slave->state.time - 1e-9)
        return fail(slave, "the step does not begin where the last one ended");
    Status status = model_step(slave, step);
    if (status == OK || status == WARNING) slave->state.time = time + step;
    if (status == ERROR) slave->state.phase = 4;
    return status;
}

EXPORT Status fmi2GetReal(void *c, const unsigned *references, size_t n, double *values) {
    Slave *slave = c;
    note(slave, 'g');
    for (size_t k = 0; k < n; k++) {
        if (references[k] >= REALS) return fail(slave, "no such real variable");
        values[k] = slave->state.reals[references[k]];
    }
    return OK;
}

EXPORT Status fmi2SetReal(void *c, const unsigned *references, size_t n, const double *values) {
    Slave *slave = c;
    note(slave, 'r');
    for (size_t k = 0; k < n; k++) {
        if (references[k] >= REALS) return fail(slave, "no such real variable");
        slave->state.reals[references[k]] = values[k];
    }
    return OK;
}

#ifndef BARE
EXPORT Status fmi2SetDebugLogging(void *c, int on, size_t n, const char *const categories[]) {
    (void)c, (void)on, (void)n, (void)categories;
    return OK;
}

EXPORT Status fmi2Terminate(void *c) {
    Slave *slave = c;
    note(slave, 't');
    slave->state.phase = 3;
    return OK;
}

EXPORT Status fmi2Reset(void *c) {
    Slave *slave = c;
    slave->state = slave->start;
    memset(slave->history, 0, sizeof slave->history);
    slave->noted = 0;
    note(slave, 'R');
    return OK;
}

EXPORT Status fmi2GetInteger(void *c, const unsigned *references, size_t n, int *values) {
    Slave *slave = c;
    for (size_t k = 0; k < n; k++) {
        if (references[k] >= INTEGERS) return fail(slave, "no such integer variable");
        values[k] = slave->state.integers[references[k]];
    }
    return OK;
}

EXPORT Status fmi2SetInteger(void *c, const unsigned *references, size_t n, const int *values) {
    Slave *slave = c;
    for (size_t k = 0; k < n; k++) {
        if (references[k] >= INTEGERS) return fail(slave, "no such integer variable");
        slave->state.integers[references[k]] = values[k];
    }
    return OK;
}

EXPORT Status fmi2GetBoolean(void *c, const unsigned *references, size_t n, int *values) {
    Slave *slave = c;
    for (size_t k = 0; k < n; k++) {
        if (references[k] >= BOOLEANS) return fail(slave, "no such boolean variable");
        values[k] = slave->state.booleans[references[k]];
    }
    return OK;
}

EXPORT Status fmi2SetBoolean(void *c, const unsigned *references, size_t n, const int *values) {
    Slave *slave = c;
    for (size_t k = 0; k < n; k++) {
        if (references[k] >= BOOLEANS) return fail(slave, "no such boolean variable");
        slave->state.booleans[references[k]] = values[k];
    }
    return OK;
}

EXPORT Status fmi2GetString(void *c, const unsigned *references, size_t n, const char **values) {
    Slave *slave = c;
    for (size_t k = 0; k < n; k++) {
        if (references[k] > 1) return fail(slave, "no such string variable");
        values[k] = references[k] == 0 ? slave->label : slave->history;
    }
    return OK;
}

EXPORT Status fmi2SetString(void *c, const unsigned *references, size_t n,
                            const char *const *values) {
    Slave *slave = c;
    for (size_t k = 0; k < n; k++) {
        if (references[k] != 0) return fail(slave, "no such string variable");
        strncpy(slave->label, values[k], sizeof slave->label - 1);
    }
    return OK;
}

EXPORT Status fmi2GetFMUstate(void *c, void **state) {
    Slave *slave = c;
    if (!*state) *state = malloc(sizeof(State));
    memcpy(*state, &slave->state, sizeof(State));
    return OK;
}

EXPORT Status fmi2SetFMUstate(void *c, void *state) {
    memcpy(&((Slave *)c)->state, state, sizeof(State));
    return OK;
}

EXPORT Status fmi2FreeFMUstate(void *c, void **state) {
    (void)c;
    free(*state);
    *state = NULL;
    return OK;
}

EXPORT Status fmi2SerializedFMUstateSize(void *c, void *state, size_t *size) {
    (void)c, (void)state;
    *size = sizeof(State);
    return OK;
}

EXPORT Status fmi2SerializeFMUstate(void *c, void *state, char *bytes, size_t size) {
    if (size < sizeof(State)) return fail(c, "too few bytes");
    memcpy(bytes, state, sizeof(State));
    return OK;
}

EXPORT Status fmi2DeSerializeFMUstate(void *c, const char *bytes, size_t size, void **state) {
    if (size != sizeof(State)) return fail(c, "these bytes are no state of mine");
    *state = malloc(sizeof(State));
    memcpy(*state, bytes, sizeof(State));
    return OK;
}

EXPORT Status fmi2GetRealStatus(void *c, int kind, double *value) {
    Slave *slave = c;
    if (kind != 2) return DISCARD;
    *value = slave->reached;
    return OK;
}

EXPORT Status fmi2GetBooleanStatus(void *c, int kind, int *value) {
    Slave *slave = c;
    if (kind != 3) return DISCARD;
    *value = slave->state.booleans[1];
    return OK;
}

/* Not offered, but fmpy wants every function of the standard to be there. */
EXPORT Status fmi2GetDirectionalDerivative(void *c) { return fail(c, "not offered"); }
EXPORT Status fmi2SetRealInputDerivatives(void *c) { return fail(c, "not offered"); }
EXPORT Status fmi2GetRealOutputDerivatives(void *c) { return fail(c, "not offered"); }
EXPORT Status fmi2CancelStep(void *c) { return fail(c, "no step is pending"); }
EXPORT Status fmi2GetStatus(void *c) { (void)c; return DISCARD; }
EXPORT Status fmi2GetIntegerStatus(void *c) { (void)c; return DISCARD; }
EXPORT Status fmi2GetStringStatus(void *c) { (void)c; return DISCARD; }
#endif
