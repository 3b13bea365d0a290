/* Lives of many instances: side by side in threads, and one after the other with the library
   loaded and unloaded and an error in each. */
#include "host.h"

#include <pthread.h>

enum { THREADS = 8, ROUNDS = 20, STEPS = 300 };

static struct given given;
static struct library fmu;
static double alone[THREADS][MOST];

/* The instance of this thread, with a start time of its own. */
static void one(int thread, double *outputs) {
    double time = 0.25 * thread;
    fmi2Component c = started(&fmu, &given, time);
    run(&fmu, c, &given, time, STEPS, outputs);
    CHECK(fmu.Terminate(c) == fmi2OK, "thread %d", thread);
    fmu.FreeInstance(c);
}

static void *thread(void *argument) {
    int number = (int)(intptr_t)argument;
    double outputs[MOST];
    for (int round = 0; round < ROUNDS; ++round) {
        one(number, outputs);
        CHECK(same_bits(outputs, alone[number], given.outputs), "thread %d differs", number);
    }
    return NULL;
}

static void threads(void) {
    pthread_t all[THREADS];
    fmu = load(given.library, RTLD_NOW | RTLD_LOCAL);
    for (int k = 0; k < THREADS; ++k) one(k, alone[k]);
    CHECK(!same_bits(alone[0], alone[1], given.outputs), "the threads have different tasks");
    for (intptr_t k = 0; k < THREADS; ++k)
        CHECK(!pthread_create(all + k, NULL, thread, (void *)k), "a thread");
    for (int k = 0; k < THREADS; ++k) pthread_join(all[k], NULL);
    printf("%d threads, %d instances each: every instance as alone\n", THREADS, ROUNDS);
}

static void cycle(void) {
    double outputs[MOST];
    fmi2FMUstate state = NULL;
    struct library here = load(given.library, RTLD_NOW | RTLD_LOCAL);
    fmi2Component c = started(&here, &given, 0.0);
    run(&here, c, &given, 0.0, 5, outputs);
    CHECK(here.GetFMUstate(c, &state) == fmi2OK, "%s", last_message);
    int before = messages;
    CHECK(here.DoStep(c, NAN, given.period, fmi2True) == fmi2Error, "an error is forced");
    CHECK(messages == before + 1, "and told");
    CHECK(!here.Instantiate("x", fmi2CoSimulation, "no GUID", given.resources, callbacks(),
                            fmi2False, fmi2True), "a wrong GUID is refused");
    /* The state is not freed: the instance does that. */
    here.FreeInstance(c);
    CHECK(!dlclose(here.handle), "%s", dlerror());
    CHECK(!dlopen(given.library, RTLD_NOW | RTLD_NOLOAD), "the library stays loaded");
}

static void cycles(int count) {
    for (int k = 0; k < 50; ++k) cycle();
    long before = resident();
    for (int k = 0; k < count; ++k) cycle();
    long grown = resident() - before;
    printf("%d times loaded, failed, unloaded: resident memory grew by %ld kB\n", count,
           grown / 1024);
    CHECK(grown < 1 << 20, "memory is lost: %ld B per cycle", grown / count);
}

int main(int argc, char **argv) {
    given = given_by(argc, argv);
    CHECK(argc == 8, "say threads or a number of cycles");
    if (!strcmp(argv[7], "threads"))
        threads();
    else
        cycles(atoi(argv[7]));
    return 0;
}
