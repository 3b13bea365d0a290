/* y = 2 u in C, FMI 2.0; see careful.h. */
#include "fmi2Functions.h"

#include "careful.h"

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

static void tell(void *callback, void *environment, const char *message) {
    ((fmi2CallbackLogger)callback)(environment, "careful", fmi2Error, "logStatusError", message);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *f, fmi2Boolean v, fmi2Boolean l) {
    struct careful *it = careful_new();
    if (it && f && f->logger) {
        it->tell = tell;
        it->callback = (void *)f->logger;
        it->environment = f->componentEnvironment;
    }
    return it;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean td, fmi2Real t, fmi2Real start,
                               fmi2Boolean sd, fmi2Real stop) {
    struct careful *it = c;
    it->time = it->start = start;
    it->stop = sd ? stop : INFINITY;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    ((struct careful *)c)->state = INITIALIZATION;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    ((struct careful *)c)->state = STEP;
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                       const fmi2Real value[]) {
    if (!c) return fmi2Error;
    return careful_set(c, __func__, vr, n, value) ? fmi2OK : fmi2Error;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    if (!c) return fmi2Error;
    return careful_get(c, __func__, vr, n, value) ? fmi2OK : fmi2Error;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real size, fmi2Boolean no_way_back) {
    if (!c) return fmi2Error;
    return careful_step(c, __func__, time, size) ? fmi2OK : fmi2Error;
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
