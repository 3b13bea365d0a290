/* An FMU of FMI 2.0 and 3.0 that calls the logger with environment pointers that it was not given:
 * at instantiation, in steps, gets and initialization, from a thread of its own, and after it is
 * freed. y = 2·u.
 *
 * value references: 0 u, 1 y */
#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef void (*Logger2)(void *environment, const char *instance, int status, const char *category,
                        const char *message, ...);
typedef void (*Logger3)(void *environment, int status, const char *category, const char *message);
typedef struct {
    Logger2 logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

typedef struct {
    double u, y;
    const Callbacks *callbacks; /* kept by address, as FMUs for the first releases of 2.0 do */
    Logger3 logger;
    void *environment;
    char name[64];
} Slave;

#define EXPORT __attribute__((visibility("default")))

static void say(Slave *s, void *environment, const char *text) {
    if (s->callbacks)
        s->callbacks->logger(environment, s->name, 1, NULL, "%s", text);
    else
        s->logger(environment, 1, NULL, text);
}

static void *gone;

/* With every kind of wrong pointer, then with the right one. */
static void say_all(Slave *s, const char *text) {
    void *wrong[] = {NULL, (void *)1, s, s->name, &gone, (void *)~(uintptr_t)0, gone,
                     (void *)(uintptr_t)0x7fff12345678, (char *)s->environment + 8, (void *)s->callbacks};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) say(s, wrong[i], text);
    say(s, s->environment, "by its own pointer");
}

static void *elsewhere(void *s) {
    say_all(s, "from a thread");
    return NULL;
}

static void *late(void *argument) {
    Slave *s = argument;
    struct timespec wait = {0, 30000000};
    nanosleep(&wait, NULL);
    say(s, s->environment, "after the end");
    say(s, (void *)3, "after the end");
    free(s);
    return NULL;
}

static Slave *made(const char *name) {
    if (!gone) {
        gone = malloc(4000000);
        free(gone); /* an address that is no longer mapped */
    }
    Slave *s = calloc(1, sizeof *s);
    strncpy(s->name, name, sizeof s->name - 1);
    return s;
}

static int step(Slave *s) {
    pthread_t thread;
    s->y = 2.0 * s->u;
    say_all(s, "in a step");
    if (pthread_create(&thread, NULL, elsewhere, s) == 0) pthread_join(thread, NULL);
    return 0;
}

static void ended(Slave *s) {
    pthread_t thread;
    say_all(s, "at the end");
    if (pthread_create(&thread, NULL, late, s) == 0) pthread_detach(thread);
}

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }
EXPORT const char *fmi3GetVersion(void) { return "3.0"; }

EXPORT void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                             const Callbacks *callbacks, int visible, int logging) {
    (void)type, (void)guid, (void)resources, (void)visible, (void)logging;
    Slave *s = made(name);
    s->callbacks = callbacks;
    s->environment = callbacks->environment;
    say_all(s, "before it is made");
    return s;
}

EXPORT void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources,
                                         bool visible, bool logging, bool event_mode,
                                         bool early_return, const uint32_t *intermediate,
                                         size_t n, void *environment, Logger3 logger, void *update) {
    (void)token, (void)resources, (void)visible, (void)logging, (void)event_mode;
    (void)early_return, (void)intermediate, (void)n, (void)update;
    Slave *s = made(name);
    s->logger = logger;
    s->environment = environment;
    say_all(s, "before it is made");
    return s;
}

EXPORT void fmi2FreeInstance(void *c) { ended(c); }
EXPORT void fmi3FreeInstance(void *c) { ended(c); }

EXPORT int fmi2SetupExperiment(void *c, int d, double t, double start, int e, double stop) {
    (void)c, (void)d, (void)t, (void)start, (void)e, (void)stop;
    return 0;
}
EXPORT int fmi2EnterInitializationMode(void *c) { return (void)c, 0; }
EXPORT int fmi2ExitInitializationMode(void *c) { return say_all(c, "at initialization"), 0; }
EXPORT int fmi3EnterInitializationMode(void *c, bool d, double t, double start, bool e, double stop) {
    (void)c, (void)d, (void)t, (void)start, (void)e, (void)stop;
    return 0;
}
EXPORT int fmi3ExitInitializationMode(void *c) { return say_all(c, "at initialization"), 0; }

static int get(Slave *s, const unsigned *references, size_t n, double *values) {
    for (size_t k = 0; k < n; k++) values[k] = references[k] ? s->y : s->u;
    say_all(s, "in a get");
    return 0;
}
static int set(Slave *s, const unsigned *references, size_t n, const double *values) {
    for (size_t k = 0; k < n; k++)
        if (references[k] == 0) s->u = values[k];
    return 0;
}
EXPORT int fmi2GetReal(void *c, const unsigned *r, size_t n, double *v) { return get(c, r, n, v); }
EXPORT int fmi2SetReal(void *c, const unsigned *r, size_t n, const double *v) { return set(c, r, n, v); }
EXPORT int fmi3GetFloat64(void *c, const unsigned *r, size_t n, double *v, size_t m) {
    return (void)m, get(c, r, n, v);
}
EXPORT int fmi3SetFloat64(void *c, const unsigned *r, size_t n, const double *v, size_t m) {
    return (void)m, set(c, r, n, v);
}
EXPORT int fmi2DoStep(void *c, double time, double h, int forget) {
    (void)time, (void)h, (void)forget;
    return step(c);
}
EXPORT int fmi3DoStep(void *c, double time, double h, bool forget, bool *event, bool *terminate,
                      bool *early, double *reached) {
    (void)forget;
    *event = *terminate = *early = false;
    *reached = time + h;
    return step(c);
}
EXPORT int fmi2Terminate(void *c) { return (void)c, 0; }
EXPORT int fmi3Terminate(void *c) { return (void)c, 0; }
