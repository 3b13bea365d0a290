/* An FMU of FMI 3.0 with event mode, clocks of every kind, a time event, a state event with early
 * return, whole numbers of 64 bits, and arrays that follow a structural parameter. It refuses every
 * call that is not allowed in its mode.
 *
 * Value references: see `events3` in tests/common/mod.rs. The declarations are the test's own. */
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } Status;
typedef void (*Logger)(void *environment, Status status, const char *category,
                       const char *message);
enum { SAMPLE = 10, ASKED, COUNTDOWN, PULSE, OUT, CHANGING };
enum { INSTANTIATED, CONFIGURATION, INITIALIZATION, EVENT, STEP, TERMINATED };

typedef struct {
    double time, u, held, y, last, x[5], in[5];
    int32_t level, seen, events, samples, askeds, countdowns, pulses, changes, kick, crossed;
    int32_t clocked, taken;
    uint64_t n;
    int64_t big, big_in;
    uint64_t huge, huge_in;
    bool active[16], out, countdown_new, crossing;
    int mode;
} State;

typedef struct {
    State state;
    Logger logger;
    void *environment;
} Slave;

#define EXPORT __attribute__((visibility("default")))
#define NEED(condition, text)                                                                      \
    if (!(condition)) return fail(slave, text)

static Status fail(Slave *slave, const char *text) {
    slave->logger(slave->environment, ERROR, "logStatus", text);
    return ERROR;
}

EXPORT const char *fmi3GetVersion(void) { return "3.0"; }

static void start(State *s) {
    memset(s, 0, sizeof *s);
    s->n = 2;
    s->x[0] = 1.0;
    s->x[1] = 2.0;
}

EXPORT void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources,
                                         bool visible, bool logging, bool event_mode,
                                         bool early_return, const uint32_t *intermediate,
                                         size_t n, void *environment, Logger logger, void *update) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)intermediate;
    (void)n, (void)update;
    if (!event_mode || !early_return) return NULL;
    Slave *slave = calloc(1, sizeof *slave);
    slave->logger = logger;
    slave->environment = environment;
    start(&slave->state);
    return slave;
}

EXPORT void fmi3FreeInstance(void *c) { free(c); }

EXPORT Status fmi3Reset(void *c) {
    start(&((Slave *)c)->state);
    return OK;
}

EXPORT Status fmi3EnterConfigurationMode(void *c) {
    Slave *slave = c;
    NEED(slave->state.mode == INSTANTIATED, "configuration mode from another mode");
    slave->state.mode = CONFIGURATION;
    return OK;
}

EXPORT Status fmi3ExitConfigurationMode(void *c) {
    Slave *slave = c;
    NEED(slave->state.mode == CONFIGURATION, "not in configuration mode");
    slave->state.mode = INSTANTIATED;
    return OK;
}

EXPORT Status fmi3EnterInitializationMode(void *c, bool tolerance_defined, double tolerance,
                                          double begin, bool stop_defined, double stop) {
    (void)tolerance_defined, (void)tolerance, (void)stop_defined, (void)stop;
    Slave *slave = c;
    NEED(slave->state.mode == INSTANTIATED, "initialization from another mode");
    slave->state.mode = INITIALIZATION;
    slave->state.time = begin;
    return OK;
}

EXPORT Status fmi3ExitInitializationMode(void *c) {
    Slave *slave = c;
    NEED(slave->state.mode == INITIALIZATION, "not in initialization mode");
    slave->state.mode = EVENT;
    return OK;
}

EXPORT Status fmi3EnterEventMode(void *c) {
    Slave *slave = c;
    NEED(slave->state.mode == STEP, "event mode from another mode");
    slave->state.mode = EVENT;
    return OK;
}

EXPORT Status fmi3EnterStepMode(void *c) {
    Slave *slave = c;
    NEED(slave->state.mode == EVENT, "step mode from another mode");
    slave->state.mode = STEP;
    return OK;
}

EXPORT Status fmi3SetClock(void *c, const uint32_t *vr, size_t n, const bool *values) {
    Slave *slave = c;
    NEED(slave->state.mode == EVENT, "a clock is set outside event mode");
    for (size_t k = 0; k < n; k++) {
        NEED(vr[k] >= SAMPLE && vr[k] <= CHANGING && vr[k] != OUT, "no such input clock");
        slave->state.active[vr[k]] = values[k];
    }
    State *s = &slave->state;
    s->out = s->active[PULSE] || (s->active[SAMPLE] && s->samples % 2 == 1);
    return OK;
}

EXPORT Status fmi3GetClock(void *c, const uint32_t *vr, size_t n, bool *values) {
    Slave *slave = c;
    NEED(slave->state.mode == EVENT, "a clock is read outside event mode");
    NEED(n == 1 && vr[0] == OUT, "no such output clock");
    values[0] = slave->state.out;
    return OK;
}

EXPORT Status fmi3GetIntervalDecimal(void *c, const uint32_t *vr, size_t n, double *intervals,
                                     int *qualifiers) {
    Slave *slave = c;
    State *s = &slave->state;
    NEED(s->mode == EVENT || s->mode == INITIALIZATION, "an interval is asked for outside events");
    NEED(n == 1, "one clock at a time");
    qualifiers[0] = 2;
    switch (vr[0]) {
    case ASKED: intervals[0] = 0.3; break;
    case CHANGING: intervals[0] = 0.1 * (s->changes + 1); break;
    case COUNTDOWN:
        intervals[0] = 0.05;
        qualifiers[0] = s->countdown_new ? 2 : 0;
        s->countdown_new = false;
        break;
    default: return fail(slave, "this clock's interval is in the description");
    }
    return OK;
}

EXPORT Status fmi3GetShiftDecimal(void *c, const uint32_t *vr, size_t n, double *shifts) {
    Slave *slave = c;
    NEED(n == 1 && vr[0] == ASKED, "this clock has no shift to ask for");
    shifts[0] = 0.0;
    return OK;
}

EXPORT Status fmi3UpdateDiscreteStates(void *c, bool *again, bool *terminate, bool *nominals,
                                       bool *states, bool *next_defined, double *next) {
    Slave *slave = c;
    State *s = &slave->state;
    NEED(s->mode == EVENT, "no event");
    s->events++;
    s->last = s->time;
    s->seen = s->level;
    if (s->active[SAMPLE]) {
        s->samples++;
        s->held = s->u;
        if (s->samples == 2) s->countdown_new = true;
    }
    if (s->active[ASKED]) s->askeds++;
    if (s->active[COUNTDOWN]) s->countdowns++;
    if (s->active[PULSE]) {
        s->pulses++;
        s->taken = s->clocked;
    }
    if (s->active[CHANGING]) s->changes++;
    if (s->time > 0.7 - 1e-9 && !s->kick) s->kick = 1;
    *again = s->crossing;
    if (s->crossing) s->crossed++;
    s->crossing = false;
    memset(s->active, 0, sizeof s->active);
    s->out = false;
    *terminate = s->level == 99;
    *nominals = *states = false;
    *next_defined = !s->kick;
    *next = 0.7;
    return OK;
}

EXPORT Status fmi3DoStep(void *c, double time, double step, bool forget, bool *event,
                         bool *terminate, bool *early, double *reached) {
    (void)forget;
    Slave *slave = c;
    State *s = &slave->state;
    NEED(s->mode == STEP, "a step outside step mode");
    NEED(time < s->time + 1e-9 && time > s->time - 1e-9, "a gap in time");
    NEED(s->kick || time + step < 0.7 + 1e-9, "a step over the time event");
    double end = time + step, y = s->y + s->u * step;
    *event = *early = *terminate = false;
    if (s->y < 1.0 - 1e-12 && y >= 1.0) { /* y reaches 1: the state event */
        end = time + (1.0 - s->y) / s->u;
        y = 1.0;
        s->crossing = *event = true;
        *early = end < time + step - 1e-12;
    }
    s->y = y;
    s->time = *reached = end;
    return OK;
}

EXPORT Status fmi3Terminate(void *c) {
    ((Slave *)c)->state.mode = TERMINATED;
    return OK;
}

EXPORT Status fmi3SetFloat64(void *c, const uint32_t *vr, size_t n, const double *values,
                             size_t m) {
    Slave *slave = c;
    State *s = &slave->state;
    if (n == 1 && vr[0] >= 41 && vr[0] <= 43) {
        NEED(m == s->n, "as many values as n, please");
        memcpy(vr[0] == 41 ? s->x : s->in, values, m * sizeof(double));
        return OK;
    }
    NEED(n == 1 && m == 1 && vr[0] == 1, "no such Float64 to set");
    s->u = values[0];
    return OK;
}

EXPORT Status fmi3GetFloat64(void *c, const uint32_t *vr, size_t n, double *values, size_t m) {
    Slave *slave = c;
    State *s = &slave->state;
    if (n == 1 && (vr[0] == 41 || vr[0] == 43 || vr[0] == 44)) {
        NEED(m == s->n, "as many values as n, please");
        for (size_t k = 0; k < m; k++) {
            values[k] = vr[0] == 41 ? s->x[k] : vr[0] == 43 ? s->in[k] : s->x[k] * s->in[k];
        }
        return OK;
    }
    NEED(n == m, "as many values as references, please");
    for (size_t k = 0; k < n; k++) {
        switch (vr[k]) {
        case 26: values[k] = s->held; break;
        case 29: values[k] = s->y; break;
        case 30: values[k] = s->last; break;
        default: return fail(slave, "no such Float64");
        }
    }
    return OK;
}

EXPORT Status fmi3SetInt32(void *c, const uint32_t *vr, size_t n, const int32_t *values, size_t m) {
    Slave *slave = c;
    NEED(slave->state.mode != STEP, "a discrete input is set outside an event");
    NEED(n == 1 && m == 1 && (vr[0] == 2 || vr[0] == 3), "no such Int32 to set");
    if (vr[0] == 3) {
        NEED(slave->state.mode == INITIALIZATION || slave->state.active[PULSE],
             "a clocked input is set without its clock");
        slave->state.clocked = values[0];
    } else {
        slave->state.level = values[0];
    }
    return OK;
}

EXPORT Status fmi3GetInt32(void *c, const uint32_t *vr, size_t n, int32_t *values, size_t m) {
    Slave *slave = c;
    State *s = &slave->state;
    NEED(n == m, "as many values as references, please");
    for (size_t k = 0; k < n; k++) {
        switch (vr[k]) {
        case 21: values[k] = s->samples; break;
        case 22: values[k] = s->askeds; break;
        case 23: values[k] = s->countdowns; break;
        case 24: values[k] = s->pulses; break;
        case 25: values[k] = s->changes; break;
        case 27: values[k] = s->seen; break;
        case 28: values[k] = s->events; break;
        case 35: values[k] = s->taken; break;
        case 45: values[k] = s->kick; break;
        case 46: values[k] = s->crossed; break;
        default: return fail(slave, "no such Int32");
        }
    }
    return OK;
}

EXPORT Status fmi3SetInt64(void *c, const uint32_t *vr, size_t n, const int64_t *values, size_t m) {
    Slave *slave = c;
    NEED(n == 1 && m == 1 && (vr[0] == 31 || vr[0] == 36), "no such Int64");
    NEED(vr[0] == 31 || slave->state.mode != STEP, "a discrete input is set outside an event");
    *(vr[0] == 31 ? &slave->state.big : &slave->state.big_in) = values[0];
    return OK;
}

EXPORT Status fmi3GetInt64(void *c, const uint32_t *vr, size_t n, int64_t *values, size_t m) {
    Slave *slave = c;
    NEED(n == m, "as many values as references, please");
    for (size_t k = 0; k < n; k++) {
        NEED(vr[k] == 31 || vr[k] == 33 || vr[k] == 36 || vr[k] == 37, "no such Int64");
        values[k] = vr[k] >= 36 ? slave->state.big_in : slave->state.big;
    }
    return OK;
}

EXPORT Status fmi3SetUInt64(void *c, const uint32_t *vr, size_t n, const uint64_t *values,
                            size_t m) {
    Slave *slave = c;
    NEED(n == 1 && m == 1, "one UInt64 at a time");
    if (vr[0] == 40) {
        NEED(slave->state.mode == CONFIGURATION, "a size is set outside configuration mode");
        slave->state.n = values[0];
        for (uint64_t k = 0; k < 5; k++) slave->state.x[k] = (double)(k + 1);
        return OK;
    }
    NEED(vr[0] == 32 || vr[0] == 34, "no such UInt64");
    NEED(vr[0] == 32 || slave->state.mode != STEP, "a discrete input is set outside an event");
    *(vr[0] == 32 ? &slave->state.huge : &slave->state.huge_in) = values[0];
    return OK;
}

EXPORT Status fmi3GetUInt64(void *c, const uint32_t *vr, size_t n, uint64_t *values, size_t m) {
    Slave *slave = c;
    State *s = &slave->state;
    NEED(n == m, "as many values as references, please");
    for (size_t k = 0; k < n; k++) {
        values[k] = vr[k] == 40 ? s->n : vr[k] == 39 || vr[k] == 34 ? s->huge_in : s->huge;
    }
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
    Slave *slave = c;
    NEED(size == sizeof(State), "the wrong number of bytes");
    memcpy(bytes, state, sizeof(State));
    return OK;
}

EXPORT Status fmi3DeserializeFMUState(void *c, const uint8_t *bytes, size_t size, void **state) {
    Slave *slave = c;
    NEED(size == sizeof(State), "these bytes are no state of mine");
    *state = malloc(sizeof(State));
    memcpy(*state, bytes, size);
    return OK;
}
