/* A sampled controller: at each step u = k·(r − y).
 *
 * reals: 0 r, 1 y, 2 u, 3 k */
#define GUID "controller"
#include "slave.h"

static void model_start(State *state) { state->reals[3] = 1.0; }

static Status model_step(Slave *slave, double step) {
    double *reals = slave->state.reals;
    (void)step;
    reals[2] = reals[3] * (reals[0] - reals[1]);
    return OK;
}
