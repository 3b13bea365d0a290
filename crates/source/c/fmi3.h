/* FMI 3.0 for co-simulation. */
#ifndef FMI3_FUNCTION_PREFIX
#define FMI3_FUNCTION_PREFIX PIEZOLOOP_PREFIX
#endif
#include "fmi3Functions.h"

typedef fmi3Status Status;
#define IS_V2 0
typedef struct {
  fmi3LogMessageCallback logger;
  fmi3InstanceEnvironment environment;
  const char* name;
  bool has_event_mode;
  size_t intermediate_count;
} Importer;

static void tell_importer(const Importer* importer, int status, const char* category, const char* message) {
  if (importer->logger) importer->logger(importer->environment, (fmi3Status)status, category, message);
}

#define CORE_NEVER w2c_core_fmi3EnterEventMode
#define CORE_GET_STATE w2c_core_fmi3GetFMUState
#define CORE_SET_STATE w2c_core_fmi3SetFMUState
#define CORE_STATE_SIZE w2c_core_fmi3SerializedFMUStateSize
#define CORE_SERIALIZE w2c_core_fmi3SerializeFMUState
#define CORE_DESERIALIZE w2c_core_fmi3DeserializeFMUState

struct Instance;
static uint32_t instantiate(struct Instance* s);
#include "fmu.h"
#include "states.h"

static uint32_t instantiate(Instance* s) {
  uint32_t name, token;
  put_name_and_token(s, &name, &token);
  return w2c_core_fmi3InstantiateCoSimulation(&s->core, name, token, 0, 0, s->is_logging, s->importer.has_event_mode, 0, 0,
                                              (u32)s->importer.intermediate_count, 0, 0, 0);
}

const char* fmi3GetVersion(void) { return fmi3Version; }

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging_on, fmi3Boolean event_mode, fmi3Boolean early_return,
                                         const fmi3ValueReference intermediate[], size_t intermediate_count,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                         fmi3IntermediateUpdateCallback update) {
  Importer importer = {0, 0, 0, false, 0};
  (void)resources;
  (void)visible;
  (void)early_return;
  (void)intermediate;
  (void)update;
  importer.logger = logger;
  importer.environment = environment;
  importer.has_event_mode = event_mode;
  importer.intermediate_count = intermediate_count;
  return create(importer, default_allocate, default_release, name, token, logging_on);
}

static fmi3Instance not_offered(fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger, const char* message) {
  if (logger) logger(environment, fmi3Error, "logStatusError", message);
  return 0;
}
fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logging_on, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback logger) {
  (void)name, (void)token, (void)resources, (void)visible, (void)logging_on;
  return not_offered(environment, logger, "fmi3InstantiateModelExchange: model exchange is not offered; call "
                                          "fmi3InstantiateCoSimulation");
}
fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                               fmi3Boolean visible, fmi3Boolean logging_on,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                               fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
                                               fmi3UnlockPreemptionCallback unlock) {
  (void)name, (void)token, (void)resources, (void)visible, (void)logging_on, (void)update, (void)lock, (void)unlock;
  return not_offered(environment, logger, "fmi3InstantiateScheduledExecution: scheduled execution is not offered; call "
                                          "fmi3InstantiateCoSimulation");
}

void fmi3FreeInstance(fmi3Instance instance) {
  if (instance) destroy((Instance*)instance);
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t count, const fmi3String categories[]) {
  ENTER(instance, "fmi3SetDebugLogging");
  AT_MOST(count, MOST_TEXTS);
  s->is_logging = on;
  return (fmi3Status)w2c_core_fmi3SetDebugLogging(&s->core, s->fmu, on, (u32)count, put_texts(s, categories, count));
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean has_tolerance, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean has_stop, fmi3Float64 stop) {
  ENTER(instance, "fmi3EnterInitializationMode");
  return (fmi3Status)w2c_core_fmi3EnterInitializationMode(&s->core, s->fmu, has_tolerance, tolerance, start, has_stop, stop);
}

/* Functions that are refused get no arguments: the core says why without looking at them. */
#define CALL(name, arguments, ...)                                     \
  fmi3Status name arguments {                                          \
    ENTER(instance, #name);                                            \
    return (fmi3Status)w2c_core_##name(&s->core, s->fmu __VA_ARGS__);  \
  }
#define PLAIN(name)                                      \
  fmi3Status name(fmi3Instance instance) {               \
    ENTER(instance, #name);                              \
    return (fmi3Status)w2c_core_##name(&s->core, s->fmu); \
  }
PLAIN(fmi3ExitInitializationMode)
PLAIN(fmi3EnterEventMode)
PLAIN(fmi3Terminate)
PLAIN(fmi3EnterConfigurationMode)
PLAIN(fmi3ExitConfigurationMode)
PLAIN(fmi3EvaluateDiscreteStates)
PLAIN(fmi3EnterContinuousTimeMode)
PLAIN(fmi3EnterStepMode)

fmi3Status fmi3Reset(fmi3Instance instance) {
  ENTER_ANEW(instance, "fmi3Reset");
  return (fmi3Status)w2c_core_fmi3Reset(&s->core, s->fmu);
}

#define GET(name, type)                                                                                        \
  fmi3Status name(fmi3Instance instance, const fmi3ValueReference references[], size_t count, type results[],    \
                  size_t number) {                                                                              \
    ENTER(instance, #name);                                                                                     \
    AT_MOST(count, MOST);                                                                                             \
    AT_MOST(number, MOST);                                                                                            \
    return (fmi3Status)values(s, 0, w2c_core_##name, references, count, 0, results, number, sizeof(type));      \
  }
#define SET(name, type)                                                                                        \
  fmi3Status name(fmi3Instance instance, const fmi3ValueReference references[], size_t count,                   \
                  const type given[], size_t number) {                                                          \
    ENTER(instance, #name);                                                                                     \
    AT_MOST(count, MOST);                                                                                             \
    AT_MOST(number, MOST);                                                                                            \
    return (fmi3Status)values(s, 0, w2c_core_##name, references, count, given, 0, number, sizeof(type));        \
  }
GET(fmi3GetFloat64, fmi3Float64)
GET(fmi3GetInt32, fmi3Int32)
GET(fmi3GetBoolean, fmi3Boolean)
SET(fmi3SetFloat64, fmi3Float64)
SET(fmi3SetInt32, fmi3Int32)
SET(fmi3SetBoolean, fmi3Boolean)

/* There are no variables of this type; their values are not looked at. */
#define NONE(name, further)                                                                            \
  fmi3Status name(fmi3Instance instance, const fmi3ValueReference references[], size_t count, further) { \
    uint32_t place;                                                                                     \
    ENTER(instance, #name);                                                                             \
    AT_MOST(count, MOST);                                                                                     \
    place = room_for(s, (uint32_t)(4 * count + 8));                                                     \
    place = put(s, &place, references, 4 * count);                                                      \
    NONE_CALL(w2c_core_##name);                                                                         \
  }
#define COMMA ,
#define NONE_CALL(called) return (fmi3Status)called(&s->core, s->fmu, place, (u32)count, 0, 0)
NONE(fmi3GetFloat32, fmi3Float32 results[] COMMA size_t number)
NONE(fmi3SetFloat32, const fmi3Float32 given[] COMMA size_t number)
NONE(fmi3GetInt8, fmi3Int8 results[] COMMA size_t number)
NONE(fmi3SetInt8, const fmi3Int8 given[] COMMA size_t number)
NONE(fmi3GetUInt8, fmi3UInt8 results[] COMMA size_t number)
NONE(fmi3SetUInt8, const fmi3UInt8 given[] COMMA size_t number)
NONE(fmi3GetInt16, fmi3Int16 results[] COMMA size_t number)
NONE(fmi3SetInt16, const fmi3Int16 given[] COMMA size_t number)
NONE(fmi3GetUInt16, fmi3UInt16 results[] COMMA size_t number)
NONE(fmi3SetUInt16, const fmi3UInt16 given[] COMMA size_t number)
NONE(fmi3GetUInt32, fmi3UInt32 results[] COMMA size_t number)
NONE(fmi3SetUInt32, const fmi3UInt32 given[] COMMA size_t number)
NONE(fmi3GetInt64, fmi3Int64 results[] COMMA size_t number)
NONE(fmi3SetInt64, const fmi3Int64 given[] COMMA size_t number)
NONE(fmi3GetUInt64, fmi3UInt64 results[] COMMA size_t number)
NONE(fmi3SetUInt64, const fmi3UInt64 given[] COMMA size_t number)
NONE(fmi3GetString, fmi3String results[] COMMA size_t number)
NONE(fmi3SetString, const fmi3String given[] COMMA size_t number)
#undef NONE_CALL
#define NONE_CALL(called) return (fmi3Status)called(&s->core, s->fmu, place, (u32)count, 0, 0, 0)
NONE(fmi3GetBinary, size_t sizes[] COMMA fmi3Binary results[] COMMA size_t number)
NONE(fmi3SetBinary, const size_t sizes[] COMMA const fmi3Binary given[] COMMA size_t number)

CALL(fmi3GetClock, (fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Clock results[]), , 0, 0, 0)
CALL(fmi3SetClock, (fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3Clock given[]), , 0, 0, 0)
CALL(fmi3GetNumberOfVariableDependencies, (fmi3Instance instance, fmi3ValueReference reference, size_t* count), , reference, 0)
CALL(fmi3GetVariableDependencies,
     (fmi3Instance instance, fmi3ValueReference dependent, size_t elements[], fmi3ValueReference independents[],
      size_t independent_elements[], fmi3DependencyKind kinds[], size_t count), , dependent, 0, 0, 0, 0, 0)
CALL(fmi3GetIntervalDecimal,
     (fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Float64 intervals[],
      fmi3IntervalQualifier qualifiers[]), , 0, 0, 0, 0)
CALL(fmi3GetIntervalFraction,
     (fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3UInt64 counters[],
      fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[]), , 0, 0, 0, 0, 0)
CALL(fmi3GetShiftDecimal, (fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Float64 shifts[]), , 0, 0, 0)
CALL(fmi3GetShiftFraction,
     (fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3UInt64 counters[],
      fmi3UInt64 resolutions[]), , 0, 0, 0, 0)
CALL(fmi3SetIntervalDecimal,
     (fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3Float64 intervals[]), , 0, 0, 0)
CALL(fmi3SetIntervalFraction,
     (fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3UInt64 counters[],
      const fmi3UInt64 resolutions[]), , 0, 0, 0, 0)
CALL(fmi3SetShiftDecimal,
     (fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3Float64 shifts[]), , 0, 0, 0)
CALL(fmi3SetShiftFraction,
     (fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3UInt64 counters[],
      const fmi3UInt64 resolutions[]), , 0, 0, 0, 0)
CALL(fmi3UpdateDiscreteStates,
     (fmi3Instance instance, fmi3Boolean* need_update, fmi3Boolean* terminate, fmi3Boolean* nominals, fmi3Boolean* states,
      fmi3Boolean* has_next, fmi3Float64* next), , 0, 0, 0, 0, 0, 0)
CALL(fmi3CompletedIntegratorStep,
     (fmi3Instance instance, fmi3Boolean no_state_before, fmi3Boolean* event_mode, fmi3Boolean* terminate), , 0, 0, 0)
CALL(fmi3SetTime, (fmi3Instance instance, fmi3Float64 time), , time)
CALL(fmi3SetContinuousStates, (fmi3Instance instance, const fmi3Float64 states[], size_t count), , 0, 0)
CALL(fmi3GetContinuousStateDerivatives, (fmi3Instance instance, fmi3Float64 derivatives[], size_t count), , 0, 0)
CALL(fmi3GetEventIndicators, (fmi3Instance instance, fmi3Float64 indicators[], size_t count), , 0, 0)
CALL(fmi3GetContinuousStates, (fmi3Instance instance, fmi3Float64 states[], size_t count), , 0, 0)
CALL(fmi3GetNominalsOfContinuousStates, (fmi3Instance instance, fmi3Float64 nominals[], size_t count), , 0, 0)
CALL(fmi3GetNumberOfEventIndicators, (fmi3Instance instance, size_t* count), , 0)
CALL(fmi3GetNumberOfContinuousStates, (fmi3Instance instance, size_t* count), , 0)
CALL(fmi3ActivateModelPartition, (fmi3Instance instance, fmi3ValueReference clock, fmi3Float64 time), , clock, time)
CALL(fmi3GetAdjointDerivative,
     (fmi3Instance instance, const fmi3ValueReference unknowns[], size_t unknown_count, const fmi3ValueReference knowns[],
      size_t known_count, const fmi3Float64 seed[], size_t seed_count, fmi3Float64 result[], size_t result_count), ,
     0, 0, 0, 0, 0, 0, 0, 0)

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState* state) {
  ENTER(instance, "fmi3GetFMUState");
  return (fmi3Status)get_state(s, function, state);
}
fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state) {
  ENTER_ANEW(instance, "fmi3SetFMUState");
  return (fmi3Status)set_state(s, state);
}
fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState* state) {
  ENTER(instance, "fmi3FreeFMUState");
  return (fmi3Status)free_state(s, function, state);
}
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t* size) {
  ENTER(instance, "fmi3SerializedFMUStateSize");
  return (fmi3Status)state_size(s, state, size);
}
fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
  ENTER(instance, "fmi3SerializeFMUState");
  return (fmi3Status)serialize(s, function, state, bytes, size);
}
fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState* state) {
  ENTER(instance, "fmi3DeserializeFMUState");
  return (fmi3Status)deserialize(s, function, bytes, size, state);
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t unknown_count,
                                        const fmi3ValueReference knowns[], size_t known_count, const fmi3Float64 seed[],
                                        size_t seed_count, fmi3Float64 result[], size_t result_count) {
  uint32_t place, u, k, d, r;
  int status;
  ENTER(instance, "fmi3GetDirectionalDerivative");
  AT_MOST(unknown_count, MOST);
  AT_MOST(known_count, MOST);
  AT_MOST(seed_count, MOST);
  AT_MOST(result_count, MOST);
  place = room_for(s, (uint32_t)(4 * (unknown_count + known_count) + 8 * (seed_count + result_count) + 64));
  u = put(s, &place, unknowns, 4 * unknown_count);
  k = put(s, &place, knowns, 4 * known_count);
  d = put(s, &place, seed, 8 * seed_count);
  r = leave(&place, result, 8 * result_count);
  status = (int)w2c_core_fmi3GetDirectionalDerivative(&s->core, s->fmu, u, (u32)unknown_count, k, (u32)known_count, d,
                                                      (u32)seed_count, r, (u32)result_count);
  if (r && status <= STATUS_WARNING) memcpy(result, at(s, r), 8 * result_count);
  return (fmi3Status)status;
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                                    const fmi3Int32 orders[], fmi3Float64 results[], size_t number) {
  uint32_t place, r, o, v;
  int status;
  ENTER(instance, "fmi3GetOutputDerivatives");
  AT_MOST(count, MOST);
  AT_MOST(number, MOST);
  place = room_for(s, (uint32_t)(8 * (count + number) + 32));
  r = put(s, &place, references, 4 * count);
  o = put(s, &place, orders, 4 * count);
  v = leave(&place, results, 8 * number);
  status = (int)w2c_core_fmi3GetOutputDerivatives(&s->core, s->fmu, r, (u32)count, o, v, (u32)number);
  if (v && status <= STATUS_WARNING) memcpy(results, at(s, v), 8 * number);
  return (fmi3Status)status;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 step, fmi3Boolean no_state_before,
                      fmi3Boolean* event, fmi3Boolean* terminate, fmi3Boolean* early, fmi3Float64* last) {
  uint32_t place;
  int status;
  ENTER(instance, "fmi3DoStep");
  place = room_for(s, 16);
  /* The old time stands where the core answers nothing. */
  if (last) memcpy(at(s, place), last, 8);
  status = (int)w2c_core_fmi3DoStep(&s->core, s->fmu, time, step, no_state_before, event ? place + 8 : 0,
                                    terminate ? place + 9 : 0, early ? place + 10 : 0, last ? place : 0);
  if (event && terminate && early && last) {
    *event = *terminate = *early = false;
    memcpy(last, at(s, place), 8);
  }
  return (fmi3Status)status;
}
