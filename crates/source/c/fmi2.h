/* FMI 2.0 for co-simulation. */
#ifndef FMI2_FUNCTION_PREFIX
#define FMI2_FUNCTION_PREFIX PIEZOLOOP_PREFIX
#endif
#include "fmi2Functions.h"

typedef fmi2Status Status;
#define IS_V2 1
typedef struct {
  fmi2CallbackLogger logger;
  fmi2ComponentEnvironment environment;
  const char* name;
} Importer;

static void tell_importer(const Importer* importer, int status, const char* category, const char* message) {
  if (importer->logger)
    importer->logger(importer->environment, importer->name ? importer->name : "", (fmi2Status)status, category, message);
}

#define CORE_NEVER w2c_core_fmi2CancelStep
#define CORE_GET_STATE w2c_core_fmi2GetFMUstate
#define CORE_SET_STATE w2c_core_fmi2SetFMUstate
#define CORE_STATE_SIZE w2c_core_fmi2SerializedFMUstateSize
#define CORE_SERIALIZE w2c_core_fmi2SerializeFMUstate
#define CORE_DESERIALIZE w2c_core_fmi2DeSerializeFMUstate

struct Instance;
static uint32_t instantiate(struct Instance* s);
#include "fmu.h"
#include "states.h"

static uint32_t instantiate(Instance* s) {
  uint32_t name, token;
  put_name_and_token(s, &name, &token);
  return w2c_core_fmi2Instantiate(&s->core, name, fmi2CoSimulation, token, 0, 0, 0, s->is_logging);
}

const char* fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char* fmi2GetVersion(void) { return "2.0"; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions* functions, fmi2Boolean visible, fmi2Boolean logging_on) {
  Importer importer = {0, 0, 0};
  bool has_memory = functions && functions->allocateMemory && functions->freeMemory;
  (void)resources;
  (void)visible;
  importer.name = name;
  if (functions) importer.logger = functions->logger;
  if (functions) importer.environment = functions->componentEnvironment;
  if (type != fmi2CoSimulation) {
    tell_importer(&importer, STATUS_ERROR, "logStatusError",
                  "fmi2Instantiate: this FMU offers co-simulation only; instantiate it with fmi2CoSimulation");
    return 0;
  }
  return create(importer, has_memory ? functions->allocateMemory : default_allocate,
                has_memory ? functions->freeMemory : default_release, name, guid, logging_on != fmi2False);
}

void fmi2FreeInstance(fmi2Component c) {
  if (c) destroy((Instance*)c);
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[]) {
  ENTER(c, "fmi2SetDebugLogging");
  AT_MOST(count, MOST_TEXTS);
  s->is_logging = on != fmi2False;
  return (fmi2Status)w2c_core_fmi2SetDebugLogging(&s->core, s->fmu, (u32)on, (u32)count, put_texts(s, categories, count));
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean has_stop, fmi2Real stop) {
  ENTER(c, "fmi2SetupExperiment");
  return (fmi2Status)w2c_core_fmi2SetupExperiment(&s->core, s->fmu, (u32)has_tolerance, tolerance, start, (u32)has_stop, stop);
}

#define PLAIN(name)                                      \
  fmi2Status name(fmi2Component c) {                     \
    ENTER(c, #name);                                     \
    return (fmi2Status)w2c_core_##name(&s->core, s->fmu); \
  }
PLAIN(fmi2EnterInitializationMode)
PLAIN(fmi2ExitInitializationMode)
PLAIN(fmi2Terminate)
PLAIN(fmi2CancelStep)

fmi2Status fmi2Reset(fmi2Component c) {
  ENTER_ANEW(c, "fmi2Reset");
  return (fmi2Status)w2c_core_fmi2Reset(&s->core, s->fmu);
}

#define GET(name, type)                                                                                    \
  fmi2Status name(fmi2Component c, const fmi2ValueReference vr[], size_t count, type value[]) {             \
    ENTER(c, #name);                                                                                        \
    AT_MOST(count, MOST);                                                                                         \
    return (fmi2Status)values(s, w2c_core_##name, 0, vr, count, 0, value, count, sizeof(type));             \
  }
#define SET(name, type)                                                                                    \
  fmi2Status name(fmi2Component c, const fmi2ValueReference vr[], size_t count, const type value[]) {       \
    ENTER(c, #name);                                                                                        \
    AT_MOST(count, MOST);                                                                                         \
    return (fmi2Status)values(s, w2c_core_##name, 0, vr, count, value, 0, count, sizeof(type));             \
  }
/* There are no variables of this type; their values are not looked at. */
#define NONE(name, type)                                                                                   \
  fmi2Status name(fmi2Component c, const fmi2ValueReference vr[], size_t count, type value[]) {             \
    ENTER(c, #name);                                                                                        \
    AT_MOST(count, MOST);                                                                                         \
    (void)value;                                                                                            \
    return (fmi2Status)values(s, w2c_core_##name, 0, vr, count, 0, 0, 0, 0);                                \
  }
GET(fmi2GetReal, fmi2Real)
GET(fmi2GetInteger, fmi2Integer)
GET(fmi2GetBoolean, fmi2Boolean)
NONE(fmi2GetString, fmi2String)
SET(fmi2SetReal, fmi2Real)
SET(fmi2SetInteger, fmi2Integer)
SET(fmi2SetBoolean, fmi2Boolean)
NONE(fmi2SetString, const fmi2String)

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* state) {
  ENTER(c, "fmi2GetFMUstate");
  return (fmi2Status)get_state(s, function, state);
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
  ENTER_ANEW(c, "fmi2SetFMUstate");
  return (fmi2Status)set_state(s, state);
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate* state) {
  ENTER(c, "fmi2FreeFMUstate");
  return (fmi2Status)free_state(s, function, state);
}
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t* size) {
  ENTER(c, "fmi2SerializedFMUstateSize");
  return (fmi2Status)state_size(s, state, size);
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
  ENTER(c, "fmi2SerializeFMUstate");
  return (fmi2Status)serialize(s, function, state, bytes, size);
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate* state) {
  ENTER(c, "fmi2DeSerializeFMUstate");
  return (fmi2Status)deserialize(s, function, bytes, size, state);
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[], size_t unknown_count,
                                        const fmi2ValueReference knowns[], size_t known_count, const fmi2Real seed[],
                                        fmi2Real result[]) {
  uint32_t place, u, k, d, r;
  int status;
  ENTER(c, "fmi2GetDirectionalDerivative");
  AT_MOST(unknown_count, MOST);
  AT_MOST(known_count, MOST);
  place = room_for(s, (uint32_t)(12 * (unknown_count + known_count) + 64));
  u = put(s, &place, unknowns, 4 * unknown_count);
  k = put(s, &place, knowns, 4 * known_count);
  d = put(s, &place, seed, 8 * known_count);
  r = leave(&place, result, 8 * unknown_count);
  status = (int)w2c_core_fmi2GetDirectionalDerivative(&s->core, s->fmu, u, (u32)unknown_count, k, (u32)known_count, d, r);
  if (r && status <= STATUS_WARNING) memcpy(result, at(s, r), 8 * unknown_count);
  return (fmi2Status)status;
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                       const fmi2Integer order[], const fmi2Real value[]) {
  uint32_t place, r, o;
  ENTER(c, "fmi2SetRealInputDerivatives");
  AT_MOST(count, MOST);
  place = room_for(s, (uint32_t)(16 * count + 32));
  r = put(s, &place, vr, 4 * count);
  o = put(s, &place, order, 4 * count);
  return (fmi2Status)w2c_core_fmi2SetRealInputDerivatives(&s->core, s->fmu, r, (u32)count, o, put(s, &place, value, 8 * count));
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                        const fmi2Integer order[], fmi2Real value[]) {
  uint32_t place, r, o, v;
  int status;
  ENTER(c, "fmi2GetRealOutputDerivatives");
  AT_MOST(count, MOST);
  place = room_for(s, (uint32_t)(16 * count + 32));
  r = put(s, &place, vr, 4 * count);
  o = put(s, &place, order, 4 * count);
  v = leave(&place, value, 8 * count);
  status = (int)w2c_core_fmi2GetRealOutputDerivatives(&s->core, s->fmu, r, (u32)count, o, v);
  if (v && status <= STATUS_WARNING) memcpy(value, at(s, v), 8 * count);
  return (fmi2Status)status;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_state_before) {
  ENTER(c, "fmi2DoStep");
  return (fmi2Status)w2c_core_fmi2DoStep(&s->core, s->fmu, time, step, (u32)no_state_before);
}

#define ASK(name, type)                                                              \
  fmi2Status name(fmi2Component c, const fmi2StatusKind kind, type* value) {          \
    uint32_t place;                                                                   \
    int status;                                                                       \
    ENTER(c, #name);                                                                  \
    place = room_for(s, 16);                                                          \
    status = (int)w2c_core_##name(&s->core, s->fmu, (u32)kind, value ? place : 0);    \
    if (value && status <= STATUS_WARNING) memcpy(value, at(s, place), sizeof *value); \
    return (fmi2Status)status;                                                        \
  }
ASK(fmi2GetStatus, fmi2Status)
ASK(fmi2GetRealStatus, fmi2Real)
ASK(fmi2GetIntegerStatus, fmi2Integer)
ASK(fmi2GetBooleanStatus, fmi2Boolean)

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String* value) {
  ENTER(c, "fmi2GetStringStatus");
  (void)value;
  return (fmi2Status)w2c_core_fmi2GetStringStatus(&s->core, s->fmu, (u32)kind, 0);
}

/* Of model exchange, which is not offered: the core says why without looking at arguments. */
#define NEVER(name, arguments, ...)                                     \
  fmi2Status name arguments {                                           \
    ENTER(c, #name);                                                    \
    return (fmi2Status)w2c_core_##name(&s->core, s->fmu __VA_ARGS__);   \
  }
PLAIN(fmi2EnterEventMode)
PLAIN(fmi2EnterContinuousTimeMode)
NEVER(fmi2NewDiscreteStates, (fmi2Component c, fmi2EventInfo* info), , 0)
NEVER(fmi2CompletedIntegratorStep,
      (fmi2Component c, fmi2Boolean no_state_before, fmi2Boolean* event_mode, fmi2Boolean* terminate), , 0, 0, 0)
NEVER(fmi2SetTime, (fmi2Component c, fmi2Real time), , time)
NEVER(fmi2SetContinuousStates, (fmi2Component c, const fmi2Real states[], size_t count), , 0, 0)
NEVER(fmi2GetDerivatives, (fmi2Component c, fmi2Real derivatives[], size_t count), , 0, 0)
NEVER(fmi2GetEventIndicators, (fmi2Component c, fmi2Real indicators[], size_t count), , 0, 0)
NEVER(fmi2GetContinuousStates, (fmi2Component c, fmi2Real states[], size_t count), , 0, 0)
NEVER(fmi2GetNominalsOfContinuousStates, (fmi2Component c, fmi2Real nominals[], size_t count), , 0, 0)
