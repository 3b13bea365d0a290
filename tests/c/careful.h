/* y = 2 u in C with all that our FMUs do at a call of the same kind: the state, pointers, references
   and values are checked; a step checks its size, its begin and its end against the stop time and
   against what double precision resolves, walks a fixed internal grid, converts V to SI and SI to um,
   and checks the result. A refusal says why. What C can leave out: tables, because its one component,
   its two variables and its units are known when it is compiled, and a guard against unwinding.
   Includes of the standard come before. */
#ifndef CAREFUL_H
#define CAREFUL_H
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { INSTANTIATED = 1, INITIALIZATION = 2, STEP = 4, TERMINATED = 8, FAILED = 16 };
enum { INPUT = 0, OUTPUT = 1, VARIABLES = 2 };
enum { REAL = 1 };
#define VOLT 1.0
#define MICROMETRE 1e-6

/* What a variable admits; nothing can be set that is not between the two. */
static const struct gate {
    int type;
    double least, greatest;
} gates[VARIABLES] = {{REAL, -1.7976931348623157e308, 1.7976931348623157e308},
                      {REAL, INFINITY, -INFINITY}};

struct careful {
    int state, sloped;
    double start, time, stop, period;
    double value[VARIABLES], gain;
    long hits;
    /* The step before. */
    long old_hits;
    double from, old[VARIABLES];
    void (*tell)(void *callback, void *environment, const char *message);
    void *callback, *environment;
    struct assembled *model;
};

/* What assembled.c does in another way: making the model, and the hits up to a time. */
#ifndef CAREFUL_MODEL
#define CAREFUL_MODEL() NULL
#define CAREFUL_HITS(it, limit, y)                                                                 \
    while ((it)->start + (double)((it)->hits + 1) * (it)->period <= (limit)) {                     \
        y = (it)->gain * ((it)->value[INPUT] * VOLT) / MICROMETRE;                                 \
        ++(it)->hits;                                                                              \
    }
#endif

static struct careful *careful_new(void) {
    struct careful *it = calloc(1, sizeof *it);
    if (it) {
        it->state = INSTANTIATED;
        it->period = 1e-3;
        it->stop = INFINITY;
        it->gain = 2e-6;
        it->model = CAREFUL_MODEL();
    }
    return it;
}

/* False, for the caller to return. */
__attribute__((cold, noinline)) static int refused(struct careful *it, const char *call,
                                                   const char *why, double value) {
    char message[200];
    snprintf(message, sizeof message, "%s: %s: %g", call, why, value);
    it->state = FAILED;
    if (it->tell) it->tell(it->callback, it->environment, message);
    return 0;
}

static inline int careful_set(struct careful *it, const char *call, const unsigned vr[], size_t n,
                              const double value[]) {
    if (!(it->state & (INSTANTIATED | INITIALIZATION | STEP)))
        return refused(it, call, "not allowed in state", it->state);
    if (n && (!vr || !value)) return refused(it, call, "null pointer", 0);
    for (size_t k = 0; k < n; ++k) {
        if (vr[k] >= VARIABLES || gates[vr[k]].type != REAL)
            return refused(it, call, "unknown reference", vr[k]);
        if (!(gates[vr[k]].least <= value[k] && value[k] <= gates[vr[k]].greatest))
            return refused(it, call, "no input, or no finite number", value[k]);
    }
    for (size_t k = 0; k < n; ++k) it->value[vr[k]] = value[k];
    return 1;
}

static inline int careful_get(struct careful *it, const char *call, const unsigned vr[], size_t n,
                              double value[]) {
    if (!(it->state & (INITIALIZATION | STEP | TERMINATED | FAILED)))
        return refused(it, call, "not allowed in state", it->state);
    if (n && (!vr || !value)) return refused(it, call, "null pointer", 0);
    for (size_t k = 0; k < n; ++k)
        if (vr[k] >= VARIABLES || gates[vr[k]].type != REAL)
            return refused(it, call, "unknown reference", vr[k]);
    for (size_t k = 0; k < n; ++k) value[k] = it->value[vr[k]];
    return 1;
}

static inline int careful_step(struct careful *it, const char *call, double time, double size) {
    if (it->state != STEP) return refused(it, call, "not allowed in state", it->state);
    if (!(size > 0) || !isfinite(size)) return refused(it, call, "step size", size);
    double near = 1e-9 * fabs(it->time) + 1e-5 * size, end = time + size;
    if (!(fabs(time - it->time) <= near)) return refused(it, call, "communication point", time);
    if (end > it->stop + near) return refused(it, call, "past the stop time", end);
    if (2.3e-16 * fabs(end) > 0.01 * it->period) return refused(it, call, "resolution", end);
    if (it->sloped) return refused(it, call, "slopes are not offered", it->sloped);
    double y = it->value[OUTPUT], limit = end + fmax(1e-9 * it->period, 8.9e-16 * fabs(end));
    long before = it->hits;
    CAREFUL_HITS(it, limit, y)
    if (it->hits != before) {
        it->old_hits = before;
        it->from = time;
        it->old[INPUT] = it->value[INPUT];
        it->old[OUTPUT] = it->value[OUTPUT];
        if (!isfinite(y)) return refused(it, call, "output", y);
        it->value[OUTPUT] = y;
    }
    it->time = end;
    return 1;
}
#endif
