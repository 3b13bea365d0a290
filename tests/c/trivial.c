/* y = 2 u in C as short as a C FMU usually is: it checks pointer, state,
   references, values and times, says nothing and knows no units. careful.c does what ours do. */
#include <math.h>
#include <stdlib.h>

#include "fmi2Functions.h"

struct trivial {
    int state;
    double time, period, u, y;
    long hits;
};

enum { INSTANTIATED = 1, INITIALIZATION = 2, STEP = 4, FAILED = 16 };

static fmi2Status failed(struct trivial *it) {
    it->state = FAILED;
    return fmi2Error;
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *f, fmi2Boolean v, fmi2Boolean l) {
    struct trivial *it = calloc(1, sizeof *it);
    if (it) it->state = INSTANTIATED, it->period = 1e-3;
    return it;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean td, fmi2Real t, fmi2Real start,
                               fmi2Boolean sd, fmi2Real stop) {
    ((struct trivial *)c)->time = start;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    ((struct trivial *)c)->state = INITIALIZATION;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    ((struct trivial *)c)->state = STEP;
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                       const fmi2Real value[]) {
    struct trivial *it = c;
    if (!it) return fmi2Error;
    if (!(it->state & (INSTANTIATED | INITIALIZATION | STEP)) || (n && (!vr || !value)))
        return failed(it);
    for (size_t k = 0; k < n; ++k) {
        if (vr[k] != 0 || !isfinite(value[k])) return failed(it);
        it->u = value[k];
    }
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    struct trivial *it = c;
    if (!it) return fmi2Error;
    if (!(it->state & (INITIALIZATION | STEP)) || (n && (!vr || !value))) return failed(it);
    for (size_t k = 0; k < n; ++k) {
        if (vr[k] > 1) return failed(it);
        value[k] = vr[k] ? it->y : it->u;
    }
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real size, fmi2Boolean no_way_back) {
    struct trivial *it = c;
    if (!it) return fmi2Error;
    if (it->state != STEP || !(size > 0) || !isfinite(size)) return failed(it);
    double near = 1e-9 * fabs(it->time) + 1e-5 * size, end = time + size;
    if (!(fabs(time - it->time) <= near)) return failed(it);
    while ((double)(it->hits + 1) * it->period <= end + 1e-9 * it->period) {
        it->y = 2.0 * it->u;
        ++it->hits;
    }
    it->time = end;
    return fmi2OK;
}

#define NOT_OFFERED(name, ...)                                                                     \
    fmi2Status fmi2##name(fmi2Component c, ##__VA_ARGS__) { return fmi2Error; }
#define VR const fmi2ValueReference vr[], size_t n
NOT_OFFERED(SetDebugLogging, fmi2Boolean on, size_t n, const fmi2String categories[])
NOT_OFFERED(Terminate)
NOT_OFFERED(Reset)
NOT_OFFERED(GetInteger, VR, fmi2Integer value[])
NOT_OFFERED(GetBoolean, VR, fmi2Boolean value[])
NOT_OFFERED(GetString, VR, fmi2String value[])
NOT_OFFERED(SetInteger, VR, const fmi2Integer value[])
NOT_OFFERED(SetBoolean, VR, const fmi2Boolean value[])
NOT_OFFERED(SetString, VR, const fmi2String value[])
NOT_OFFERED(GetFMUstate, fmi2FMUstate *s)
NOT_OFFERED(SetFMUstate, fmi2FMUstate s)
NOT_OFFERED(FreeFMUstate, fmi2FMUstate *s)
NOT_OFFERED(SerializedFMUstateSize, fmi2FMUstate s, size_t *n)
NOT_OFFERED(SerializeFMUstate, fmi2FMUstate s, fmi2Byte b[], size_t n)
NOT_OFFERED(DeSerializeFMUstate, const fmi2Byte b[], size_t n, fmi2FMUstate *s)
NOT_OFFERED(GetDirectionalDerivative, VR, const fmi2ValueReference k[], size_t nk,
            const fmi2Real dk[], fmi2Real du[])
NOT_OFFERED(EnterEventMode)
NOT_OFFERED(NewDiscreteStates, fmi2EventInfo *i)
NOT_OFFERED(EnterContinuousTimeMode)
NOT_OFFERED(CompletedIntegratorStep, fmi2Boolean p, fmi2Boolean *e, fmi2Boolean *t)
NOT_OFFERED(SetTime, fmi2Real t)
NOT_OFFERED(SetContinuousStates, const fmi2Real x[], size_t n)
NOT_OFFERED(GetDerivatives, fmi2Real x[], size_t n)
NOT_OFFERED(GetEventIndicators, fmi2Real x[], size_t n)
NOT_OFFERED(GetContinuousStates, fmi2Real x[], size_t n)
NOT_OFFERED(GetNominalsOfContinuousStates, fmi2Real x[], size_t n)
NOT_OFFERED(SetRealInputDerivatives, VR, const fmi2Integer o[], const fmi2Real value[])
NOT_OFFERED(GetRealOutputDerivatives, VR, const fmi2Integer o[], fmi2Real value[])
NOT_OFFERED(CancelStep)
NOT_OFFERED(GetStatus, const fmi2StatusKind s, fmi2Status *value)
NOT_OFFERED(GetRealStatus, const fmi2StatusKind s, fmi2Real *value)
NOT_OFFERED(GetIntegerStatus, const fmi2StatusKind s, fmi2Integer *value)
NOT_OFFERED(GetBooleanStatus, const fmi2StatusKind s, fmi2Boolean *value)
NOT_OFFERED(GetStringStatus, const fmi2StatusKind s, fmi2String *value)
