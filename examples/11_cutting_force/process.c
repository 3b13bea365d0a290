/* A cutting process as an FMU of FMI 2.0 for co-simulation, of nobody's make: chip thickness from the tool's tip,
   force back on it.

     h = max(0, z - surface)                                           chip thickness
     force_y = pressure*width*h*(1 + tanh((speed - v_y)/smooth))/2     against the cut, while the tool runs into it
     force_z = -thrust*force_y                                         away from the workpiece
     power   = force_y*(speed - v_y)                                   that the cut takes

   z grows into the workpiece; the tool cuts while it moves against y, and the workpiece comes with `speed` along y. */
#include <math.h>
#include <stdlib.h>

enum { Y, Z, VY, VZ, FY, FZ, POWER, SURFACE, WIDTH, PRESSURE, THRUST, SPEED, SMOOTH, COUNT };
typedef struct { double v[COUNT]; } Process;

static void begin(Process *it) {
    *it = (Process){{0, 0, 0, 0, 0, 0, 0, 6e-6, 2e-4, 2e9, 0.4, 1e-4, 1e-4}};
}

static void work(double *v) {
    double h = fmax(0, v[Z] - v[SURFACE]), runs = v[SPEED] - v[VY];
    v[FY] = v[PRESSURE] * v[WIDTH] * h * 0.5 * (1 + tanh(runs / v[SMOOTH]));
    v[FZ] = -v[THRUST] * v[FY];
    v[POWER] = v[FY] * runs;
}

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const void *callbacks,
                      int visible, int logging) {
    Process *it = malloc(sizeof *it);
    if (it) begin(it);
    return it;
}
void fmi2FreeInstance(void *c) { free(c); }
int fmi2SetDebugLogging(void *c, int on, size_t n, const char *const categories[]) { return 0; }
int fmi2SetupExperiment(void *c, int td, double t, double start, int sd, double stop) { return 0; }
int fmi2EnterInitializationMode(void *c) { return 0; }
int fmi2ExitInitializationMode(void *c) { return work(((Process *)c)->v), 0; }
int fmi2Terminate(void *c) { return 0; }
int fmi2Reset(void *c) { return begin(c), 0; }
int fmi2SetReal(void *c, const unsigned vr[], size_t n, const double value[]) {
    for (size_t k = 0; k < n; k++) {
        if (vr[k] >= COUNT || (vr[k] >= FY && vr[k] <= POWER)) return 3;
        ((Process *)c)->v[vr[k]] = value[k];
    }
    return 0;
}
int fmi2GetReal(void *c, const unsigned vr[], size_t n, double value[]) {
    for (size_t k = 0; k < n; k++) {
        if (vr[k] >= COUNT) return 3;
        value[k] = ((Process *)c)->v[vr[k]];
    }
    return 0;
}
int fmi2DoStep(void *c, double time, double step, int forget) { return work(((Process *)c)->v), 0; }

/* What this process has none of. */
#define NONE(kind, type) \
    int fmi2Get##kind(void *c, const unsigned vr[], size_t n, type value[]) { return n ? 3 : 0; } \
    int fmi2Set##kind(void *c, const unsigned vr[], size_t n, const type value[]) { return n ? 3 : 0; }
NONE(Integer, int)
NONE(Boolean, int)
NONE(String, char *)
int fmi2GetFMUstate(void *c, void **s) { return 3; }
int fmi2SetFMUstate(void *c, void *s) { return 3; }
int fmi2FreeFMUstate(void *c, void **s) { return 3; }
int fmi2SerializedFMUstateSize(void *c, void *s, size_t *n) { return 3; }
int fmi2SerializeFMUstate(void *c, void *s, char b[], size_t n) { return 3; }
int fmi2DeSerializeFMUstate(void *c, const char b[], size_t n, void **s) { return 3; }
int fmi2GetDirectionalDerivative(void *c, const unsigned u[], size_t n, const unsigned k[], size_t m, const double d[],
                                 double r[]) { return 3; }
int fmi2SetRealInputDerivatives(void *c, const unsigned vr[], size_t n, const int o[], const double value[]) { return 3; }
int fmi2GetRealOutputDerivatives(void *c, const unsigned vr[], size_t n, const int o[], double value[]) { return 3; }
int fmi2CancelStep(void *c) { return 3; }
int fmi2GetStatus(void *c, int kind, int *value) { return 3; }
int fmi2GetRealStatus(void *c, int kind, double *value) { return 3; }
int fmi2GetIntegerStatus(void *c, int kind, int *value) { return 3; }
int fmi2GetBooleanStatus(void *c, int kind, int *value) { return 3; }
int fmi2GetStringStatus(void *c, int kind, const char **value) { return 3; }
