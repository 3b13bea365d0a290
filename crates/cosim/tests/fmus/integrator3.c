/* A plant of FMI 3.0: y' = k·u, and one variable of every type that is only kept.
 *
 * value references: 1 u, 2 y, 3 k, 4 label, 10… one of each type (see the model description)
 * The declarations are the test's own; only what is needed is here. */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } Status;
typedef void (*Logger)(void *environment, Status status, const char *category,
                       const char *message);

typedef struct {
    double reals[4];
    double time;
    double u[3], y[3]; /* arrays, value references 30 and 31: y' = u */
    float f32;
    int8_t i8;
    uint8_t u8;
    int16_t i16;
    uint16_t u16;
    int32_t i32;
    uint32_t u32;
    int64_t i64;
    uint64_t u64;
    bool boolean;
} State;

typedef struct {
    State state;
    Logger logger;
    void *environment;
    char label[64];
} Slave;

#define EXPORT __attribute__((visibility("default")))

static Status fail(Slave *slave, const char *text) {
    slave->logger(slave->environment, ERROR, "logStatus", text);
    return ERROR;
}

EXPORT const char *fmi3GetVersion(void) { return "3.0.2"; }

EXPORT void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources,
                                         bool visible, bool logging, bool event_mode,
                                         bool early_return, const uint32_t *intermediate,
                                         size_t n, void *environment, Logger logger, void *update) {
    (void)visible, (void)logging, (void)intermediate, (void)n, (void)update;
    size_t length = resources ? strlen(resources) : 0;
    if (!name || event_mode || early_return || !length || resources[length - 1] != '/') return NULL;
    if (strcmp(token, "integrator3") != 0) {
        logger(environment, ERROR, "logStatus", "this token is not mine: 100%");
        return NULL;
    }
    Slave *slave = calloc(1, sizeof *slave);
    slave->state.reals[3] = 1.0;
    for (int i = 0; i < 3; i++) slave->state.u[i] = i + 1;
    slave->logger = logger;
    slave->environment = environment;
    return slave;
}

EXPORT void fmi3FreeInstance(void *c) { free(c); }

EXPORT Status fmi3EnterInitializationMode(void *c, bool tolerance_defined, double tolerance,
                                          double start, bool stop_defined, double stop) {
    (void)tolerance_defined, (void)tolerance, (void)stop_defined, (void)stop;
    ((Slave *)c)->state.time = start;
    return OK;
}

EXPORT Status fmi3ExitInitializationMode(void *c) {
    (void)c;
    return OK;
}

EXPORT Status fmi3DoStep(void *c, double time, double step, bool forget, bool *event,
                         bool *terminate, bool *early, double *reached) {
    (void)forget;
    Slave *slave = c;
    State *s = &slave->state;
    if (time > s->time + 1e-9 || time < s->time - 1e-9) return fail(slave, "a gap in time");
    *event = false;
    *early = false;
    *terminate = s->i32 == 99;
    *reached = *terminate ? time + 0.5 * step : time + step;
    s->reals[2] += s->reals[3] * s->reals[1] * (*reached - time);
    for (int i = 0; i < 3; i++) s->y[i] += s->u[i] * (*reached - time);
    s->time = *reached;
    return OK;
}

EXPORT Status fmi3Terminate(void *c) {
    (void)c;
    return OK;
}

/* The array that one reference and three values mean, if they do. */
static double *array(Slave *slave, const uint32_t *vr, size_t n, size_t m) {
    if (n != 1 || m != 3) return NULL;
    return vr[0] == 30 ? slave->state.u : vr[0] == 31 ? slave->state.y : NULL;
}

EXPORT Status fmi3GetFloat64(void *c, const uint32_t *vr, size_t n, double *values, size_t m) {
    Slave *slave = c;
    if (array(slave, vr, n, m)) {
        memcpy(values, array(slave, vr, n, m), 3 * sizeof(double));
        if (slave->state.reals[3] == -77.0) values[3] = 1.0; /* one too many */
        return OK;
    }
    if (n != m) return fail(slave, "as many values as references, please");
    for (size_t k = 0; k < n; k++) {
        if (vr[k] < 1 || vr[k] > 3) return fail(slave, "no such Float64");
        values[k] = slave->state.reals[vr[k]];
    }
    return OK;
}

EXPORT Status fmi3SetFloat64(void *c, const uint32_t *vr, size_t n, const double *values,
                             size_t m) {
    Slave *slave = c;
    if (array(slave, vr, n, m)) {
        memcpy(array(slave, vr, n, m), values, 3 * sizeof(double));
        return OK;
    }
    if (n != m) return fail(slave, "as many values as references, please");
    for (size_t k = 0; k < n; k++) {
        if (vr[k] < 1 || vr[k] > 3) return fail(slave, "no such Float64");
        slave->state.reals[vr[k]] = values[k];
    }
    return OK;
}

/* One variable of each other type. */
#define ONE(Name, type, field, reference)                                                          \
    EXPORT Status fmi3Get##Name(void *c, const uint32_t *vr, size_t n, type *values, size_t m) {    \
        if (n != 1 || m != 1 || vr[0] != reference) return fail(c, "no such " #Name);              \
        values[0] = ((Slave *)c)->state.field;                                                     \
        return OK;                                                                                 \
    }                                                                                              \
    EXPORT Status fmi3Set##Name(void *c, const uint32_t *vr, size_t n, const type *values,          \
                                size_t m) {                                                        \
        if (n != 1 || m != 1 || vr[0] != reference) return fail(c, "no such " #Name);              \
        ((Slave *)c)->state.field = values[0];                                                     \
        return OK;                                                                                 \
    }

ONE(Float32, float, f32, 10)
ONE(Int8, int8_t, i8, 11)
ONE(UInt8, uint8_t, u8, 12)
ONE(Int16, int16_t, i16, 13)
ONE(UInt16, uint16_t, u16, 14)
ONE(Int32, int32_t, i32, 15)
ONE(UInt32, uint32_t, u32, 16)
ONE(Int64, int64_t, i64, 17)
ONE(UInt64, uint64_t, u64, 18)
ONE(Boolean, bool, boolean, 19)

EXPORT Status fmi3GetString(void *c, const uint32_t *vr, size_t n, const char **values, size_t m) {
    if (n != 1 || m != 1 || vr[0] != 4) return fail(c, "no such String");
    values[0] = ((Slave *)c)->label;
    return OK;
}

EXPORT Status fmi3SetString(void *c, const uint32_t *vr, size_t n, const char *const *values,
                            size_t m) {
    if (n != 1 || m != 1 || vr[0] != 4) return fail(c, "no such String");
    strncpy(((Slave *)c)->label, values[0], sizeof ((Slave *)c)->label - 1);
    return OK;
}

EXPORT Status fmi3GetFMUState(void *c, void **state) {
    if (!*state) *state = malloc(sizeof(State));
    memcpy(*state, &((Slave *)c)->state, sizeof(State));
    return OK;
}

EXPORT Status fmi3SetFMUState(void *c, void *state) {
    memcpy(&((Slave *)c)->state, state, sizeof(State));
    return OK;
}

EXPORT Status fmi3FreeFMUState(void *c, void **state) {
    (void)c;
    free(*state);
    *state = NULL;
    return OK;
}

EXPORT Status fmi3SerializedFMUStateSize(void *c, void *state, size_t *size) {
    (void)c, (void)state;
    *size = sizeof(State);
    return OK;
}

EXPORT Status fmi3SerializeFMUState(void *c, void *state, uint8_t *bytes, size_t size) {
    if (size < sizeof(State)) return fail(c, "too few bytes");
    memcpy(bytes, state, sizeof(State));
    return OK;
}

EXPORT Status fmi3DeserializeFMUState(void *c, const uint8_t *bytes, size_t size, void **state) {
    if (size != sizeof(State)) return fail(c, "these bytes are no state of mine");
    *state = malloc(sizeof(State));
    memcpy(*state, bytes, sizeof(State));
    return OK;
}
