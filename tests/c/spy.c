/* A co-simulation FMU (y = gain * u) that records every call of its importer, with its arguments,
   in the file that the environment variable SPY_RECORD names: one line per call, JSON. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

struct spy {
    double u, y, gain;
};

static void put(const char *text) {
    const char *path = getenv("SPY_RECORD");
    FILE *file = path ? fopen(path, "a") : NULL;
    if (!file) return;
    fprintf(file, "%s\n", text);
    fclose(file);
}

/* A text as JSON, null for a null pointer; up to four in one call. */
static const char *json(const char *text) {
    static char rooms[4][2000];
    static int next;
    char *room = rooms[next++ % 4], *at = room;
    if (!text) return "null";
    *at++ = '"';
    for (; *text && at < room + 1980; ++text) {
        if (*text == '"' || *text == '\\') *at++ = '\\';
        *at++ = *text >= 0 && *text < ' ' ? ' ' : *text;
    }
    *at++ = '"', *at = 0;
    return room;
}

/* A number as JSON, exact; what JSON has no number for as text. */
static const char *exact(double value) {
    static char rooms[4][40];
    static int next;
    char *room = rooms[next++ % 4];
    snprintf(room, 40, isfinite(value) ? "%.17g" : "\"%g\"", value);
    return room;
}

static void say(const char *function, const char *format, ...) {
    char text[8000];
    int used = snprintf(text, sizeof text, "{\"call\": \"%s\"", function);
    va_list values;
    va_start(values, format);
    used += vsnprintf(text + used, sizeof text - (size_t)used, format, values);
    va_end(values);
    snprintf(text + used, sizeof text - (size_t)used, "}");
    put(text);
}

/* Values with their references: {"call": …, "values": {"0": 1.5}}. */
static void say_values(const char *function, const fmi2ValueReference *vr, size_t count,
                       const double *values) {
    char text[4000] = "";
    size_t used = 0;
    for (size_t k = 0; k < count && used < 3900; ++k)
        used += (size_t)snprintf(text + used, sizeof text - used, "%s\"%u\": %s", k ? ", " : "",
                                 vr[k], exact(values[k]));
    say(function, ", \"values\": {%s}", text);
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count,
                               const fmi2String categories[]) {
    say("SetDebugLogging", ", \"on\": %d, \"categories\": %zu", on, count);
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *f, fmi2Boolean visible,
                              fmi2Boolean logging) {
    say("Instantiate",
        ", \"name\": %s, \"type\": %d, \"resources\": %s, \"callbacks\": %d, \"logger\": %d, "
        "\"allocate\": %d, \"free\": %d, \"stepFinished\": %d, \"environment\": %d, "
        "\"visible\": %d, \"logging\": %d, \"guid\": %s",
        json(name), (int)type, json(resources), f != NULL, f && f->logger, f && f->allocateMemory,
        f && f->freeMemory, f && f->stepFinished, f && f->componentEnvironment, visible, logging,
        json(guid));
    struct spy *spy = calloc(1, sizeof *spy);
    if (spy) spy->gain = 2.0;
    return spy;
}

void fmi2FreeInstance(fmi2Component c) {
    say("FreeInstance", "");
    free(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop) {
    say("SetupExperiment", ", \"tolerance\": %s, \"start\": %s, \"stop\": %s",
        tolerance_defined ? exact(tolerance) : "null", exact(start),
        stop_defined ? exact(stop) : "null");
    return fmi2OK;
}

#define SIMPLE(name)                                                                               \
    fmi2Status fmi2##name(fmi2Component c) {                                                       \
        say(#name, "");                                                                            \
        return fmi2OK;                                                                             \
    }
SIMPLE(EnterInitializationMode)
SIMPLE(Terminate)
SIMPLE(Reset)

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    struct spy *spy = c;
    say("ExitInitializationMode", "");
    spy->y = spy->gain * spy->u;
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                       fmi2Real value[]) {
    struct spy *spy = c;
    for (size_t k = 0; k < count; ++k)
        value[k] = vr[k] == 0 ? spy->u : vr[k] == 1 ? spy->y : spy->gain;
    say_values("GetReal", vr, count, value);
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                       const fmi2Real value[]) {
    struct spy *spy = c;
    say_values("SetReal", vr, count, value);
    for (size_t k = 0; k < count; ++k) {
        if (vr[k] == 0) spy->u = value[k];
        if (vr[k] == 2) spy->gain = value[k];
    }
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real size, fmi2Boolean no_way_back) {
    struct spy *spy = c;
    say("DoStep", ", \"time\": %s, \"size\": %s, \"noSetFMUStatePrior\": %d", exact(time),
        exact(size), no_way_back);
    spy->y = spy->gain * spy->u;
    return fmi2OK;
}

/* What this FMU does not offer is recorded and refused. */
#define REFUSED(name, ...)                                                                         \
    fmi2Status fmi2##name(fmi2Component c, ##__VA_ARGS__) {                                        \
        say(#name, "");                                                                            \
        return fmi2Error;                                                                          \
    }
#define REFUSED_UNLESS_EMPTY(name, count, ...)                                                     \
    fmi2Status fmi2##name(fmi2Component c, const fmi2ValueReference vr[], size_t count,            \
                          __VA_ARGS__) {                                                           \
        say(#name, ", \"count\": %zu", count);                                                     \
        return count ? fmi2Error : fmi2OK;                                                         \
    }
REFUSED_UNLESS_EMPTY(GetInteger, count, fmi2Integer value[])
REFUSED_UNLESS_EMPTY(GetBoolean, count, fmi2Boolean value[])
REFUSED_UNLESS_EMPTY(GetString, count, fmi2String value[])
REFUSED_UNLESS_EMPTY(SetInteger, count, const fmi2Integer value[])
REFUSED_UNLESS_EMPTY(SetBoolean, count, const fmi2Boolean value[])
REFUSED_UNLESS_EMPTY(SetString, count, const fmi2String value[])
REFUSED_UNLESS_EMPTY(SetRealInputDerivatives, count, const fmi2Integer order[], const fmi2Real v[])
REFUSED_UNLESS_EMPTY(GetRealOutputDerivatives, count, const fmi2Integer order[], fmi2Real value[])
REFUSED(GetFMUstate, fmi2FMUstate *state)
REFUSED(SetFMUstate, fmi2FMUstate state)
REFUSED(FreeFMUstate, fmi2FMUstate *state)
REFUSED(SerializedFMUstateSize, fmi2FMUstate state, size_t *size)
REFUSED(SerializeFMUstate, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
REFUSED(DeSerializeFMUstate, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
REFUSED(GetDirectionalDerivative, const fmi2ValueReference unknown[], size_t unknowns,
        const fmi2ValueReference known[], size_t knowns, const fmi2Real dk[], fmi2Real du[])
REFUSED(EnterEventMode)
REFUSED(NewDiscreteStates, fmi2EventInfo *info)
REFUSED(EnterContinuousTimeMode)
REFUSED(CompletedIntegratorStep, fmi2Boolean prior, fmi2Boolean *enter, fmi2Boolean *terminate)
REFUSED(SetTime, fmi2Real time)
REFUSED(SetContinuousStates, const fmi2Real x[], size_t count)
REFUSED(GetDerivatives, fmi2Real derivatives[], size_t count)
REFUSED(GetEventIndicators, fmi2Real indicators[], size_t count)
REFUSED(GetContinuousStates, fmi2Real x[], size_t count)
REFUSED(GetNominalsOfContinuousStates, fmi2Real nominals[], size_t count)
REFUSED(CancelStep)
REFUSED(GetStatus, const fmi2StatusKind kind, fmi2Status *value)
REFUSED(GetRealStatus, const fmi2StatusKind kind, fmi2Real *value)
REFUSED(GetIntegerStatus, const fmi2StatusKind kind, fmi2Integer *value)
REFUSED(GetBooleanStatus, const fmi2StatusKind kind, fmi2Boolean *value)
REFUSED(GetStringStatus, const fmi2StatusKind kind, fmi2String *value)
