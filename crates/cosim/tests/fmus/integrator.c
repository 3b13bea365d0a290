/* A plant: y' = k·u while enabled; u is held over a step, so every step is exact.
 *
 * reals: 0 u, 1 y, 2 k, 3 limit of |y|, 4 time at which it wants to end
 * integers: 0 number of steps, 1 misbehaviour of the next step (see model_step)
 * booleans: 0 enabled, 1 wants to end the run */
#define GUID "integrator"
#include "slave.h"

static void model_start(State *state) {
    state->reals[2] = 1.0;
    state->reals[3] = 1e300;
    state->reals[4] = 1e300;
    state->booleans[0] = 1;
}

static Status model_step(Slave *slave, double step) {
    State *s = &slave->state;
    char text[128];
    slave->reached = s->time;
    switch (s->integers[1]) {
    case 1: say(slave, FATAL, "out of memory"); return FATAL;
    case 2: return DISCARD;
    case 3: say(slave, WARNING, "this is odd"); break;
    case 4: return PENDING;
    case 5: return 17;
    case 8: abort();
    case 9: for (;;) step += 1e-9 * (volatile double){1.0};
    case 6:
        slave->callbacks.logger(slave->callbacks.environment, slave->name, WARNING, "logStatus",
                                "%s: %d of %5.2f at %g s, %lu%%, %c %x %e %s", slave->name, -3,
                                2.5, s->time, 123456789012ul, 'c', 255, 1e-3, "end");
        break;
    case 7:
        slave->callbacks.logger(slave->callbacks.environment, slave->name, WARNING, NULL,
                                "100% too large, by %s and more");
        break;
    }
    if (s->time + step > s->reals[4] + 1e-9) {
        s->booleans[1] = 1;
        s->reals[1] += s->reals[2] * s->reals[0] * (s->reals[4] - s->time);
        slave->reached = s->reals[4];
        return DISCARD;
    }
    if (s->booleans[0]) s->reals[1] += s->reals[2] * s->reals[0] * step;
    s->integers[0]++;
    if (s->reals[1] > s->reals[3] || s->reals[1] < -s->reals[3]) {
        snprintf(text, sizeof text, "y = %g is beyond its limit %g", s->reals[1], s->reals[3]);
        say(slave, ERROR, text);
        return ERROR;
    }
    return s->integers[1] == 3 ? WARNING : OK;
}
