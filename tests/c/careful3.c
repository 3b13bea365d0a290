/* y = 2 u in C, FMI 3.0; see careful.h. Only what edge3.c calls. */
#include "fmi3Functions.h"

#include "careful.h"

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                         fmi3Boolean v, fmi3Boolean l, fmi3Boolean e, fmi3Boolean r,
                                         const fmi3ValueReference i[], size_t n,
                                         fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    return careful_new();
}

void fmi3FreeInstance(fmi3Instance c) { free(c); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean td, fmi3Float64 t,
                                       fmi3Float64 start, fmi3Boolean sd, fmi3Float64 stop) {
    struct careful *it = c;
    it->time = it->start = start;
    it->stop = sd ? stop : INFINITY;
    it->state = INITIALIZATION;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
    ((struct careful *)c)->state = STEP;
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                          const fmi3Float64 value[], size_t values) {
    if (!c || n != values) return fmi3Error;
    return careful_set(c, __func__, vr, n, value) ? fmi3OK : fmi3Error;
}

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                          fmi3Float64 value[], size_t values) {
    if (!c || n != values) return fmi3Error;
    return careful_get(c, __func__, vr, n, value) ? fmi3OK : fmi3Error;
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 size, fmi3Boolean no_way_back,
                      fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early,
                      fmi3Float64 *last) {
    if (!c || !event || !terminate || !early || !last) return fmi3Error;
    int done = careful_step(c, __func__, time, size);
    *event = *terminate = *early = fmi3False;
    *last = ((struct careful *)c)->time;
    return done ? fmi3OK : fmi3Error;
}
