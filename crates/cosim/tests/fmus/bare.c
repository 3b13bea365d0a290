/* An FMU with the fewest functions that can run: y = 2·u. */
#define BARE
#define GUID "bare"
#include "slave.h"

static void model_start(State *state) { (void)state; }

static Status model_step(Slave *slave, double step) {
    (void)step;
    slave->state.reals[1] = 2.0 * slave->state.reals[0];
    return OK;
}
