/* A co-simulation FMU with one fault, chosen when it is compiled by -DFAULT=NAME. Without a fault
   y = gain·u, one step later. Faults of a step strike at t = 0.5 s. The declarations are the test's
   own: a faulty FMU is rarely built with care.

   references: 0 u, 1 y, 2 gain; as a controller (-DCONTROLLER) 0 reference, 1 measured, 2 command */
#include <fenv.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

enum {
    SOUND, CRASH_LOAD, CRASH_INSTANTIATE, CRASH_STEP, CRASH_FREE, EXIT_STEP, HANG_INSTANTIATE, HANG_STEP, HANG_FREE,
    ERROR_STEP, FATAL_STEP, DISCARD_STEP, LEAK, PRINT, ROUNDING, FOLDER, FOLDER_ERROR, NO_NUMBER, INFINITE, MANY, ROUNDING_GET,
    CRASH_TUNED, ERROR_TUNED, ERROR_HIGH, ERROR_SOMETIMES,
    CRASH_SOMETIMES, LEAK_MUCH, END, END_UNTOLD, WARN, TALK, FLOOD, EXIT_FREE, EXIT_GET, SIGPIPE_STEP, QUICK_EXIT_STEP,
    EXIT_LOAD, AT_ONCE_STEP, AT_ONCE_LOAD, AT_ONCE_CHILD, EXIT_ONE_STEP, ABORT_STEP, TRAP_STEP, OVERFLOW_STEP, CRASH_GET,
    CRASH_CHILD, CRASH_END
};
/* Time that it says it has reached when it ends the run. */
#ifndef REACHED
#define REACHED 0.5
#endif
/* Bytes per step. */
#ifndef LEAKED
#define LEAKED (1 << 20)
#endif
#ifndef FAULT
#define FAULT SOUND
#endif

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } Status;
typedef void (*Logger)(void *, const char *, Status, const char *, const char *, ...);
struct callbacks { Logger logger; void *allocate, *release, *finished, *environment; };
struct faulty { double real[3], next, time; int stepping; struct callbacks callbacks; };

static int never = 0, runs = 0;

static void hang(void) { while (!*(volatile int *)&never) usleep(1000); }
/* Writes where nothing is; the compiler does not see that it does. */
static void crash(void) {
    int *nowhere = NULL;
    __asm__ volatile("" : "+r"(nowhere));
    *nowhere = 1;
}
/* Until the stack is full. */
static int deeper(volatile char *above) {
    volatile char here[4096];
    here[0] = *above;
    return deeper(here) + here[0];
}
static void say(struct faulty *it, Status status, const char *text) {
    it->callbacks.logger(it->callbacks.environment, "faulty", status, "logStatus", text);
}

__attribute__((constructor)) static void loaded(void) {
    if (FAULT == CRASH_LOAD) crash();
    if (FAULT == EXIT_LOAD) exit(0);
    if (FAULT == AT_ONCE_LOAD) _Exit(0);
}

__attribute__((destructor)) static void unloaded(void) {
    if (FAULT == CRASH_END) crash();
}

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                      const struct callbacks *callbacks, int visible, int logging) {
    if (FAULT == CRASH_INSTANTIATE) crash();
    if (FAULT == HANG_INSTANTIATE) hang();
    if (FAULT == FOLDER) (void)!chdir("/");
    if (FAULT == PRINT) { printf("faulty: %s is made\n", name); fflush(stdout); }
    if (strcmp(guid, "faulty")) {
        callbacks->logger(callbacks->environment, name, ERROR, "logStatus", "this GUID is not mine");
        return NULL;
    }
    struct faulty *it = calloc(1, sizeof *it);
    it->real[2] = 2;
    it->callbacks = *callbacks;
    return it;
}
void fmi2FreeInstance(void *c) {
    if (FAULT == CRASH_FREE) crash();
    if (FAULT == EXIT_FREE) exit(0);
    if (FAULT == HANG_FREE) hang();
    free(c);
}
Status fmi2SetupExperiment(void *c, int td, double t, double start, int sd, double stop) {
    ((struct faulty *)c)->time = start;
    __atomic_add_fetch(&runs, 1, __ATOMIC_RELAXED);
    return OK;
}
Status fmi2EnterInitializationMode(void *c) { return OK; }
Status fmi2ExitInitializationMode(void *c) { return OK; }
Status fmi2Terminate(void *c) { return OK; }
Status fmi2Reset(void *c) {
    struct faulty *it = c;
    memset(it->real, 0, sizeof it->real);
    it->real[2] = 2;
    return OK;
}
Status fmi2SetDebugLogging(void *c, int on, size_t n, const char *const categories[]) { return OK; }

Status fmi2SetReal(void *c, const unsigned vr[], size_t n, const double value[]) {
    for (size_t k = 0; k < n; k++) {
        if (vr[k] > 2) return ERROR;
        ((struct faulty *)c)->real[vr[k]] = value[k];
    }
    return OK;
}
Status fmi2GetReal(void *c, const unsigned vr[], size_t n, double value[]) {
    for (size_t k = 0; k < n; k++) {
        if (vr[k] > 2) { say(c, ERROR, "there is no such variable"); return ERROR; }
        value[k] = ((struct faulty *)c)->real[vr[k]];
    }
    if (FAULT == CRASH_GET && ((struct faulty *)c)->time > 0.55) crash();
    if (FAULT == EXIT_GET && ((struct faulty *)c)->time > 0.55) exit(0);
    if (FAULT == ROUNDING_GET) fesetround(FE_UPWARD);
    /* As one that writes all its outputs, whatever it is asked for. */
    if (FAULT == MANY && ((struct faulty *)c)->time > 0.55)
        for (size_t k = n; k < n + 20; k++) value[k] = 7;
    return OK;
}
#define NONE(name, type) Status fmi2##name(void *c, const unsigned vr[], size_t n, type v[]) { return n ? ERROR : OK; }
NONE(GetInteger, int)
NONE(SetInteger, const int)
NONE(GetBoolean, int)
NONE(SetBoolean, const int)
NONE(GetString, const char *)
NONE(SetString, const char *const)

#ifndef NO_STEP
static Status strike(struct faulty *it) {
    switch (FAULT) {
    case CRASH_STEP: crash(); break;
    case ABORT_STEP: abort();
    case TRAP_STEP: raise(SIGFPE); break;
    case OVERFLOW_STEP: deeper(&(volatile char){0}); break;
    case CRASH_CHILD: {
        pid_t child = fork();
        if (!child) crash();
        waitpid(child, NULL, 0);
        break;
    }
    case EXIT_STEP: exit(0);
    case EXIT_ONE_STEP: exit(1);
    case AT_ONCE_STEP: _exit(0);
    case AT_ONCE_CHILD: {
        /* A child may end as it likes. */
        int status = 1;
        pid_t child = fork();
        if (child == 0) _exit(0);
        if (waitpid(child, &status, 0) != child || status != 0) return ERROR;
        break;
    }
    case QUICK_EXIT_STEP: quick_exit(0);
    case SIGPIPE_STEP: signal(SIGPIPE, SIG_DFL); raise(SIGPIPE); break;
    case HANG_STEP: hang(); break;
    case FOLDER_ERROR: (void)!chdir("/"); /* fall through */
    case ERROR_STEP: say(it, ERROR, "the bearing is worn"); return ERROR;
    case FATAL_STEP: say(it, FATAL, "the bearing is gone"); return FATAL;
    case DISCARD_STEP: case END: case END_UNTOLD: return DISCARD;
    case FLOOD:
        for (;;) say(it, WARNING, "and on and on");
    case NO_NUMBER: it->real[1] = 0.0 / *(volatile double *)&(double){0}; break;
    case INFINITE: it->real[1] = 1.0 / *(volatile double *)&(double){0}; break;
    default: break;
    }
    return OK;
}

/* Memory that nobody frees, written so that it is really there; the compiler must not see through it. */
static void take(size_t bytes) {
    static char *volatile last;
    last = malloc(bytes);
    for (size_t i = 0; i < bytes; i += 4096) last[i] = 1;
}

Status fmi2DoStep(void *c, double time, double step, int forget) {
    struct faulty *it = c;
    it->time = time + step;
#ifdef CONTROLLER
    it->real[2] = 0.25 * (it->real[0] - it->real[1]);
    return OK;
#endif
    it->real[1] = it->real[2] * it->real[0];
    if (FAULT == PRINT) { printf("faulty: t = %g\n", time); (void)!write(1, "raw\n", 4); }
    if (FAULT == LEAK) take(LEAKED);
    if (FAULT == LEAK_MUCH && time > 0.45) take(1 << 30);
    if (FAULT == ROUNDING) fesetround(FE_UPWARD);
    if (FAULT == FOLDER) (void)!chdir("/");
    if (FAULT == CRASH_TUNED && it->real[2] != 2) crash();
    if (FAULT == CRASH_SOMETIMES && runs % 40 == 39) crash();
    if (FAULT == ERROR_SOMETIMES && runs % 40 == 39) { say(it, ERROR, "not now"); return ERROR; }
    if (FAULT == ERROR_TUNED && it->real[2] != 2) { say(it, ERROR, "the gain is not 2"); return ERROR; }
    if (FAULT == ERROR_HIGH && it->real[2] > 2.002) { say(it, ERROR, "the gain is too high"); return ERROR; }
    if (FAULT == WARN) return WARNING;
    if (FAULT == TALK) {
        Logger log = it->callbacks.logger;
        void *own = it->callbacks.environment;
        log(own, "faulty", WARNING, NULL, "#r0# is %d%% of %s, ##%4.1f", 93, "full scale", 2.5);
        log(own, "faulty", WARNING, "slip", "at %g s #r1# slips\n", time);
        log(own, "faulty", OK, "chat", "\033[31mall is well");
    }
    return time > 0.499 ? strike(it) : OK;
}
#endif

Status fmi2GetBooleanStatus(void *c, int kind, int *value) {
    *value = FAULT == END || FAULT == END_UNTOLD;
    return kind == 3 ? OK : DISCARD;
}
Status fmi2GetRealStatus(void *c, int kind, double *value) {
    if (kind != 2 || FAULT != END) return DISCARD;
    *value = REACHED;
    return OK;
}

#ifdef ALL /* the functions that nobody calls */
#define STUB(name) Status fmi2##name(void) { return DISCARD; }
STUB(GetFMUstate)
STUB(SetFMUstate)
STUB(FreeFMUstate)
STUB(SerializedFMUstateSize)
STUB(SerializeFMUstate)
STUB(DeSerializeFMUstate)
STUB(GetDirectionalDerivative)
STUB(SetRealInputDerivatives)
STUB(GetRealOutputDerivatives)
STUB(CancelStep)
STUB(GetStatus)
STUB(GetIntegerStatus)
STUB(GetStringStatus)
#endif
