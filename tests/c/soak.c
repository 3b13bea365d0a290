/* A plant and its controller in a closed loop for as many steps as are given, with a reference that
   repeats: the time that both say is that of the step counter to the bit, and a period after any
   number of steps is the first one up to the last bits, which the loop carries on. Arguments: those of the plant, those of the controller, its `enable`, steps. */
#include "host.h"

/* Steps of one period of the reference, and periods until the loop repeats. */
enum { PERIOD = 1000, SETTLED = 1000 };

/* Some units in the last place of 100 V. */
static const double LAST_BITS = 1e-13;

static struct library plant, controller;
static struct given of_plant, of_controller;
static fmi2Component machine, control;
static double reference[PERIOD][2], position[2], command[MOST];

/* Step `k` of both; the controller reads what the plant's sensors said last. */
static void both(long k) {
    double now = (double)k * of_plant.period;
    double read[4] = {reference[k % PERIOD][0], reference[k % PERIOD][1], position[0], position[1]};
    set(&controller, control, &of_controller, read);
    step(&controller, control, now, of_plant.period);
    get(&controller, control, &of_controller, command);
    set(&plant, machine, &of_plant, command);
    step(&plant, machine, now, of_plant.period);
    get(&plant, machine, &of_plant, position);
}

static void time_is(const struct library *fmu, fmi2Component c, double wanted) {
    double last;
    CHECK(fmu->GetRealStatus(c, fmi2LastSuccessfulTime, &last) == fmi2OK, "%s", last_message);
    CHECK(last == wanted, "%.17g, not %.17g s", last, wanted);
}

/* Runs one period from step `k` on, and keeps commands and positions. */
static void one_period(long k, double kept[PERIOD][4]) {
    for (int i = 0; i < PERIOD; ++i) {
        both(k + i);
        memcpy(kept[i], command, 2 * sizeof *command);
        memcpy(kept[i] + 2, position, sizeof position);
    }
    /* As the importer computes it: the last point and the step's size. */
    double end = (double)(k + PERIOD - 1) * of_plant.period + of_plant.period;
    time_is(&plant, machine, end);
    time_is(&controller, control, end);
}

int main(int argc, char **argv) {
    CHECK(argc == 15, "give plant, controller, enable, steps");
    of_plant = given_by(argc, argv);
    of_controller = given_by(argc - 6, argv + 6);
    CHECK(of_plant.period == of_controller.period, "two periods");
    CHECK(of_plant.inputs == 2 && of_plant.outputs == 2 && of_controller.inputs == 4, "axes");
    fmi2ValueReference enable = (fmi2ValueReference)strtoul(argv[13], NULL, 10);
    long steps = strtol(argv[14], NULL, 10);
    CHECK(steps > 4 * SETTLED * PERIOD && steps % PERIOD == 0, "%ld steps", steps);
    plant = load(of_plant.library, RTLD_NOW | RTLD_LOCAL);
    controller = load(of_controller.library, RTLD_NOW | RTLD_LOCAL);
    for (int i = 0; i < PERIOD; ++i)
        for (int axis = 0; axis < 2; ++axis)
            reference[i][axis] = 3.0 + swing(6.283185307179586 * i / PERIOD + axis);
    machine = started(&plant, &of_plant, 0.0);
    control = started(&controller, &of_controller, 0.0);
    fmi2Boolean on = fmi2True;
    CHECK(controller.SetBoolean(control, &enable, 1, &on) == fmi2OK, "%s", last_message);
    get(&plant, machine, &of_plant, position);

    long k = 0;
    while (k < (long)SETTLED * PERIOD) both(k++);
    static double first[PERIOD][4], last[PERIOD][4];
    one_period(k, first);
    k += PERIOD;
    double lowest = INFINITY, highest = -INFINITY;
    for (int i = 0; i < PERIOD; ++i) {
        lowest = fmin(lowest, first[i][2]);
        highest = fmax(highest, first[i][2]);
    }
    CHECK(highest - lowest > 1.0, "the machine moves by %g", highest - lowest);

    long memory = resident(), different = 0;
    double farthest = 0.0;
    for (int part = 1; part <= 10; ++part) {
        long end = (steps / 10 * part) / PERIOD * PERIOD - PERIOD;
        while (k < end) both(k++);
        one_period(k, last);
        k += PERIOD;
        for (int i = 0; i < PERIOD; ++i)
            for (int column = 0; column < 4; ++column) {
                different += !same_bits(&first[i][column], &last[i][column], 1);
                farthest = fmax(farthest, fabs(first[i][column] - last[i][column]));
            }
    }
    CHECK(resident() - memory < 1 << 20, "%ld bytes more", resident() - memory);
    CHECK(messages == 0, "%s", last_message);
    printf("%ld steps of both, %.17g s, travel %.3g um: %ld numbers of 10 periods differ, by %g\n",
           k, (double)k * of_plant.period, highest - lowest, different, farthest);
    CHECK(farthest <= LAST_BITS, "drift of %g", farthest);
    controller.FreeInstance(control);
    plant.FreeInstance(machine);
    return 0;
}
