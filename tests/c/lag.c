/* A lag whose gain is a product, FMI 2.0: tau·y' = a·b·u − y, exact over a held u; z = y² beside it, and
   a parameter that does nothing. Real variables: 0 u, 1 y, 2 a, 3 b, 4 tau, 5 idle, 6 z. It fails where
   tau is not above zero. */
#include <math.h>
#include <stdlib.h>

enum { U, Y, A, B, TAU, IDLE, Z, COUNT };
typedef struct { double v[COUNT]; } Lag;

static void start(Lag *it) { *it = (Lag){{0, 0, 1, 1, 1, 0, 0}}; }

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                      const void *callbacks, int visible, int logging) {
    Lag *it = malloc(sizeof *it);
    start(it);
    return it;
}
void fmi2FreeInstance(void *c) { free(c); }
int fmi2SetupExperiment(void *c, int td, double t, double begin, int sd, double stop) { return 0; }
int fmi2EnterInitializationMode(void *c) { return 0; }
int fmi2ExitInitializationMode(void *c) { return 0; }
int fmi2Terminate(void *c) { return 0; }
int fmi2Reset(void *c) { return start(c), 0; }
int fmi2SetReal(void *c, const unsigned vr[], size_t n, const double value[]) {
    for (size_t k = 0; k < n; k++) ((Lag *)c)->v[vr[k]] = value[k];
    return 0;
}
int fmi2GetReal(void *c, const unsigned vr[], size_t n, double value[]) {
    for (size_t k = 0; k < n; k++) value[k] = ((Lag *)c)->v[vr[k]];
    return 0;
}
int fmi2DoStep(void *c, double time, double step, int forget) {
    double *v = ((Lag *)c)->v;
    if (!(v[TAU] > 0)) return 3;
    v[Y] += (v[A] * v[B] * v[U] - v[Y]) * -expm1(-step / v[TAU]);
    v[Z] = v[Y] * v[Y];
    return 0;
}
