/* A stage in C, as somebody else's FMU: a gain and a first-order lag, whose value references are
   scattered and shared between types, and which counts its instances in a global variable. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

enum { U = 4000000000u, Y = 7, GAIN = 8, STEPS = 7, NAME = 7, FAST = 9 };

struct stage {
    double u, y, gain;
    int steps, fast, running;
    char name[64], told[80];
};

static int instances;

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String names[]) {
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *f, fmi2Boolean v, fmi2Boolean l) {
    if (type != fmi2CoSimulation || strcmp(guid, "c-stage")) return NULL;
    struct stage *it = calloc(1, sizeof *it);
    if (!it) return NULL;
    it->gain = 0.1;
    snprintf(it->name, sizeof it->name, "%s", name);
    ++instances;
    return it;
}

void fmi2FreeInstance(fmi2Component c) {
    if (c) --instances;
    free(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean td, fmi2Real t, fmi2Real start,
                               fmi2Boolean sd, fmi2Real stop) {
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    struct stage *it = c;
    it->y = it->gain * it->u;
    it->running = 1;
    return fmi2OK;
}
fmi2Status fmi2Terminate(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2Reset(fmi2Component c) {
    struct stage *it = c;
    it->u = it->y = 0;
    it->gain = 0.1;
    it->steps = it->fast = it->running = 0;
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    struct stage *it = c;
    for (size_t k = 0; k < n; ++k) {
        if (vr[k] == U) value[k] = it->u;
        else if (vr[k] == Y) value[k] = it->running ? it->y : it->gain * it->u;
        else if (vr[k] == GAIN) value[k] = it->gain;
        else return fmi2Error;
    }
    return fmi2OK;
}
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                          fmi2Integer value[]) {
    for (size_t k = 0; k < n; ++k) {
        if (vr[k] != STEPS) return fmi2Error;
        value[k] = ((struct stage *)c)->steps;
    }
    return fmi2OK;
}
fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                          fmi2Boolean value[]) {
    for (size_t k = 0; k < n; ++k) {
        if (vr[k] != FAST) return fmi2Error;
        value[k] = ((struct stage *)c)->fast;
    }
    return fmi2OK;
}
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                         fmi2String value[]) {
    struct stage *it = c;
    for (size_t k = 0; k < n; ++k) {
        if (vr[k] != NAME) return fmi2Error;
        snprintf(it->told, sizeof it->told, "I am %s", it->name);
        value[k] = it->told;
    }
    return fmi2OK;
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                       const fmi2Real value[]) {
    struct stage *it = c;
    for (size_t k = 0; k < n; ++k) {
        if (vr[k] == U) it->u = value[k];
        else if (vr[k] == GAIN) it->gain = value[k];
        else return fmi2Error;
    }
    return fmi2OK;
}
fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                          const fmi2Integer value[]) {
    return fmi2Error;
}
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                          const fmi2Boolean value[]) {
    for (size_t k = 0; k < n; ++k) {
        if (vr[k] != FAST) return fmi2Error;
        ((struct stage *)c)->fast = value[k];
    }
    return fmi2OK;
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                         const fmi2String value[]) {
    return fmi2Error;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no) {
    struct stage *it = c;
    double bandwidth = it->fast ? 2000 : 200;
    it->y += -expm1(-6.283185307179586 * bandwidth * h) * (it->gain * it->u - it->y);
    it->steps += 1;
    return fmi2OK;
}

/* What this FMU does not offer. */
#define NOT(name, ...) fmi2Status fmi2##name(__VA_ARGS__) { return fmi2Error; }
NOT(GetFMUstate, fmi2Component c, fmi2FMUstate *s)
NOT(SetFMUstate, fmi2Component c, fmi2FMUstate s)
NOT(FreeFMUstate, fmi2Component c, fmi2FMUstate *s)
NOT(SerializedFMUstateSize, fmi2Component c, fmi2FMUstate s, size_t *n)
NOT(SerializeFMUstate, fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n)
NOT(DeSerializeFMUstate, fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *s)
NOT(GetDirectionalDerivative, fmi2Component c, const fmi2ValueReference u[], size_t nu,
    const fmi2ValueReference k[], size_t nk, const fmi2Real dk[], fmi2Real du[])
NOT(SetRealInputDerivatives, fmi2Component c, const fmi2ValueReference vr[], size_t n,
    const fmi2Integer o[], const fmi2Real v[])
NOT(GetRealOutputDerivatives, fmi2Component c, const fmi2ValueReference vr[], size_t n,
    const fmi2Integer o[], fmi2Real v[])
NOT(CancelStep, fmi2Component c)
NOT(GetStatus, fmi2Component c, const fmi2StatusKind k, fmi2Status *v)
NOT(GetRealStatus, fmi2Component c, const fmi2StatusKind k, fmi2Real *v)
NOT(GetIntegerStatus, fmi2Component c, const fmi2StatusKind k, fmi2Integer *v)
NOT(GetBooleanStatus, fmi2Component c, const fmi2StatusKind k, fmi2Boolean *v)
NOT(GetStringStatus, fmi2Component c, const fmi2StatusKind k, fmi2String *v)
