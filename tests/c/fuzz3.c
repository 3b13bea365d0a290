/* Random calls of all functions of FMI 3.0 in every state with arguments that nobody should pass:
   each is answered with a status, and after a reset the instance computes what it did at first. */
#include "fuzz.h"

#include "fmi3FunctionTypes.h"

/* Functions with values of one type, in pairs Get, Set. */
#define TYPES(X)                                                                                   \
    X(Float32) X(Float64) X(Int8) X(UInt8) X(Int16) X(UInt16) X(Int32) X(UInt32) X(Int64)          \
    X(UInt64) X(Boolean) X(String)

#define OTHERS(X)                                                                                  \
    X(GetVersion) X(SetDebugLogging) X(InstantiateModelExchange) X(InstantiateCoSimulation)        \
    X(InstantiateScheduledExecution) X(FreeInstance) X(EnterInitializationMode)                    \
    X(ExitInitializationMode) X(EnterEventMode) X(Terminate) X(Reset) X(GetBinary) X(GetClock)     \
    X(SetBinary) X(SetClock) X(GetNumberOfVariableDependencies) X(GetVariableDependencies)         \
    X(GetFMUState) X(SetFMUState) X(FreeFMUState) X(SerializedFMUStateSize) X(SerializeFMUState)   \
    X(DeserializeFMUState) X(GetDirectionalDerivative) X(GetAdjointDerivative)                     \
    X(EnterConfigurationMode) X(ExitConfigurationMode) X(GetIntervalDecimal)                       \
    X(GetIntervalFraction) X(GetShiftDecimal) X(GetShiftFraction) X(SetIntervalDecimal)            \
    X(SetIntervalFraction) X(SetShiftDecimal) X(SetShiftFraction) X(EvaluateDiscreteStates)        \
    X(UpdateDiscreteStates) X(EnterContinuousTimeMode) X(CompletedIntegratorStep) X(SetTime)       \
    X(SetContinuousStates) X(GetContinuousStateDerivatives) X(GetEventIndicators)                  \
    X(GetContinuousStates) X(GetNominalsOfContinuousStates) X(GetNumberOfEventIndicators)          \
    X(GetNumberOfContinuousStates) X(EnterStepMode) X(GetOutputDerivatives) X(DoStep)              \
    X(ActivateModelPartition)

#define X(name) static fmi3##name##TYPE *name;
OTHERS(X)
#undef X
#define X(type) static fmi3Get##type##TYPE *Get##type; static fmi3Set##type##TYPE *Set##type;
TYPES(X)
#undef X

static struct given given;
static size_t input_values, output_values;
static double now;
static long answered[6];

static void told(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                 fmi3String message) {
    (void)environment, (void)status, (void)category;
    snprintf(last_message, sizeof last_message, "%s", message);
}

static void count(const char *function, fmi3Status status) {
    CHECK(status <= fmi3Error, "%s: status %d", function, (int)status);
    ++answered[status];
}

#define CALL(name, ...) count("fmi3" #name, name(c, ##__VA_ARGS__))

static void values_of_any_type(fmi3Instance c) {
    static uint64_t room[ROOM], words[ROOM];
    static bool flags[ROOM];
    fmi3ValueReference *vr = MAYBE(references_);
    size_t n = length(), m = any(3) ? n : length();
    for (int k = 0; k < ROOM; ++k) words[k] = random_bits(&seed), flags[k] = any(2);
    switch (any(30)) {
    case 0: CALL(GetFloat32, vr, n, MAYBE((float *)room), m); break;
    case 1: CALL(SetFloat32, vr, n, MAYBE((float *)words), m); break;
    case 2: CALL(GetInt8, vr, n, MAYBE((int8_t *)room), m); break;
    case 3: CALL(SetInt8, vr, n, MAYBE((int8_t *)words), m); break;
    case 4: CALL(GetUInt8, vr, n, MAYBE((uint8_t *)room), m); break;
    case 5: CALL(SetUInt8, vr, n, MAYBE((uint8_t *)words), m); break;
    case 6: CALL(GetInt16, vr, n, MAYBE((int16_t *)room), m); break;
    case 7: CALL(SetInt16, vr, n, MAYBE((int16_t *)words), m); break;
    case 8: CALL(GetUInt16, vr, n, MAYBE((uint16_t *)room), m); break;
    case 9: CALL(SetUInt16, vr, n, MAYBE((uint16_t *)words), m); break;
    case 10: CALL(GetInt32, vr, n, MAYBE((int32_t *)room), m); break;
    case 11: CALL(SetInt32, vr, n, MAYBE((int32_t *)words), m); break;
    case 12: CALL(GetUInt32, vr, n, MAYBE((uint32_t *)room), m); break;
    case 13: CALL(SetUInt32, vr, n, MAYBE((uint32_t *)words), m); break;
    case 14: CALL(GetInt64, vr, n, MAYBE((int64_t *)room), m); break;
    case 15: CALL(SetInt64, vr, n, MAYBE((int64_t *)words), m); break;
    case 16: CALL(GetUInt64, vr, n, MAYBE(room), m); break;
    case 17: CALL(SetUInt64, vr, n, MAYBE(words), m); break;
    case 18: CALL(GetBoolean, vr, n, MAYBE((bool *)room), m); break;
    case 19: CALL(SetBoolean, vr, n, MAYBE(flags), m); break;
    case 20: CALL(GetString, vr, n, MAYBE((fmi3String *)room), m); break;
    case 21: CALL(SetString, vr, n, MAYBE(texts), m); break;
    case 22: CALL(GetBinary, vr, n, MAYBE((size_t *)words), MAYBE((fmi3Binary *)room), m); break;
    case 23: CALL(SetBinary, vr, n, (size_t *)words, (fmi3Binary *)texts, m); break;
    case 24: CALL(GetClock, vr, n, MAYBE((bool *)room)); break;
    case 25: CALL(SetClock, vr, n, MAYBE(flags)); break;
    case 26: case 27: CALL(GetFloat64, vr, n, MAYBE(results), m); break;
    default: CALL(SetFloat64, vr, n, MAYBE(numbers), m);
    }
}

/* Modes, clocks, states of the continuous time: what is not offered. */
static void not_offered(fmi3Instance c) {
    fmi3ValueReference *vr = MAYBE(references_);
    double *out = MAYBE(results), *in = MAYBE(numbers);
    static uint64_t words[ROOM];
    static fmi3IntervalQualifier qualifiers[ROOM];
    size_t n = length(), size;
    bool flag;
    switch (any(26)) {
    case 0: CALL(EnterEventMode); break;
    case 1: CALL(EnterConfigurationMode); break;
    case 2: CALL(ExitConfigurationMode); break;
    case 3: CALL(GetIntervalDecimal, vr, n, out, MAYBE(qualifiers)); break;
    case 4: CALL(GetIntervalFraction, vr, n, MAYBE(words), words, MAYBE(qualifiers)); break;
    case 5: CALL(GetShiftDecimal, vr, n, out); break;
    case 6: CALL(GetShiftFraction, vr, n, MAYBE(words), words); break;
    case 7: CALL(SetIntervalDecimal, vr, n, in); break;
    case 8: CALL(SetIntervalFraction, vr, n, MAYBE(words), words); break;
    case 9: CALL(SetShiftDecimal, vr, n, in); break;
    case 10: CALL(SetShiftFraction, vr, n, MAYBE(words), words); break;
    case 11: CALL(EvaluateDiscreteStates); break;
    case 12: CALL(UpdateDiscreteStates, MAYBE(&flag), &flag, &flag, &flag, &flag, out); break;
    case 13: CALL(EnterContinuousTimeMode); break;
    case 14: CALL(CompletedIntegratorStep, any(2), MAYBE(&flag), MAYBE(&flag)); break;
    case 15: CALL(SetTime, number()); break;
    case 16: CALL(SetContinuousStates, in, n); break;
    case 17: CALL(GetContinuousStateDerivatives, out, n); break;
    case 18: CALL(GetEventIndicators, out, n); break;
    case 19: CALL(GetContinuousStates, out, n); break;
    case 20: CALL(GetNominalsOfContinuousStates, out, n); break;
    case 21: CALL(GetNumberOfEventIndicators, MAYBE(&size)); break;
    case 22: CALL(GetNumberOfContinuousStates, MAYBE(&size)); break;
    case 23: CALL(EnterStepMode); break;
    case 24: CALL(ActivateModelPartition, reference(), number()); break;
    default: CALL(GetOutputDerivatives, vr, n, MAYBE(integers), out, length());
    }
}

static void states_and_derivatives(fmi3Instance c) {
    void **state = rarely() ? NULL : states + any(STATES);
    static uint8_t bytes[256];
    static size_t sizes[ROOM];
    static fmi3DependencyKind kinds[ROOM];
    fmi3ValueReference *vr = MAYBE(references_);
    size_t n = length(), size = 0;
    switch (any(10)) {
    case 0: CALL(GetFMUState, state); break;
    case 1: CALL(SetFMUState, state ? *state : NULL); break;
    case 2: CALL(FreeFMUState, state); break;
    case 3: CALL(SerializedFMUStateSize, state ? *state : NULL, MAYBE(&size)); break;
    case 4: CALL(SerializeFMUState, state ? *state : NULL, MAYBE(bytes), any(256)); break;
    case 5: CALL(DeserializeFMUState, MAYBE(bytes), rarely() ? SIZE_MAX : any(256), state); break;
    case 6: CALL(GetDirectionalDerivative, vr, n, MAYBE(references_), length(), MAYBE(numbers),
                 length(), MAYBE(results), length()); break;
    case 7: CALL(GetAdjointDerivative, vr, n, MAYBE(references_), length(), MAYBE(numbers),
                 length(), MAYBE(results), length()); break;
    case 8: CALL(GetNumberOfVariableDependencies, reference(), MAYBE(&size)); break;
    default: CALL(GetVariableDependencies, reference(), MAYBE(sizes), MAYBE(references_), sizes,
                  MAYBE(kinds), length());
    }
}

static void call(fmi3Instance c) {
    fill();
    bool event, end, early;
    double last = NAN, time = rarely() ? number() : now;
    switch (any(12)) {
    case 0: CALL(SetDebugLogging, any(2), length(), any(3) ? texts : NULL); break;
    case 1:
        CALL(EnterInitializationMode, any(2), number(), rarely() ? number() : 0.0, rarely(),
             number());
        break;
    case 2: CALL(ExitInitializationMode); break;
    case 3: if (rarely()) CALL(Terminate); break;
    case 4: case 5: case 6: values_of_any_type(c); break;
    case 7: not_offered(c); break;
    case 8: states_and_derivatives(c); break;
    default:
        CALL(DoStep, time, size_of_step(given.period), any(2), MAYBE(&event), MAYBE(&end),
             MAYBE(&early), MAYBE(&last));
        if (!isnan(last)) now = last;
    }
}

static fmi3Instance instance(void) {
    return InstantiateCoSimulation("x", given.guid, given.resources, false, false, false, true,
                                   NULL, 0, NULL, told, NULL);
}

static void reference_run(fmi3Instance c, double *outputs) {
    double values[MOST];
    struct given flat = given;
    flat.inputs = input_values;
    CHECK(Reset(c) == fmi3OK, "%s", last_message);
    CHECK(EnterInitializationMode(c, false, 0, 0, false, 0) == fmi3OK, "%s", last_message);
    CHECK(ExitInitializationMode(c) == fmi3OK, "%s", last_message);
    for (int k = 0; k < 50; ++k) {
        bool event, end, early;
        double last, time = k * given.period;
        wave(&flat, time, values);
        CHECK(SetFloat64(c, given.input, given.inputs, values, input_values) == fmi3OK, "%s",
              last_message);
        CHECK(DoStep(c, time, given.period, true, &event, &end, &early, &last) == fmi3OK, "%s",
              last_message);
        CHECK(!event && !end && !early && last == time + given.period, "answers of the step");
    }
    CHECK(GetFloat64(c, given.output, given.outputs, outputs, output_values) == fmi3OK, "%s",
          last_message);
}

static void recover(fmi3Instance c) {
    CALL(Reset);
    now = 0.0;
    if (!any(4)) return;
    CHECK(EnterInitializationMode(c, false, 0, 0, false, 0) == fmi3OK, "%s", last_message);
    if (any(4)) CHECK(ExitInitializationMode(c) == fmi3OK, "%s", last_message);
}

static void without_instance(void) {
    for (int k = 0; k < 5000; ++k) call(NULL);
    CHECK(!answered[fmi3OK] && !answered[fmi3Warning], "success without an instance");
    FreeInstance(NULL);
    CHECK(!strcmp(GetVersion(), "3.0"), "the version");
    for (int k = 0; k < 500; ++k) {
        CHECK(!InstantiateModelExchange(text(), text(), text(), any(2), any(2), NULL,
                                        any(2) ? told : NULL), "model exchange");
        CHECK(!InstantiateScheduledExecution(text(), given.guid, given.resources, any(2), any(2),
                                             NULL, any(2) ? told : NULL, NULL, NULL, NULL),
              "scheduled execution");
        CHECK(!InstantiateCoSimulation(text(), text(), text(), any(2), any(2), any(2), any(2),
                                       NULL, length(), NULL, any(2) ? told : NULL, NULL),
              "no text of these is the token");
    }
}

int main(int argc, char **argv) {
    given = given_by(argc, argv);
    CHECK(argc == 12, "give the number of variables, a seed, rounds, input and output values");
    variables = (uint32_t)strtoul(argv[7], NULL, 10);
    seed = strtoull(argv[8], NULL, 10);
    input_values = strtoul(argv[10], NULL, 10), output_values = strtoul(argv[11], NULL, 10);
    void *library = dlopen(given.library, RTLD_NOW | RTLD_LOCAL);
    CHECK(library, "%s", dlerror());
#define LOAD(name)                                                                                 \
    name = (fmi3##name##TYPE *)dlsym(library, "fmi3" #name);                                       \
    CHECK(name, "no fmi3" #name);
    OTHERS(LOAD)
#define X(type) LOAD(Get##type) LOAD(Set##type)
    TYPES(X)
    without_instance();
    double wanted[MOST], outputs[MOST];
    fmi3Instance c = instance();
    CHECK(c, "%s", last_message);
    reference_run(c, wanted);
    memset(answered, 0, sizeof answered);
    for (long round = 0, rounds = strtol(argv[9], NULL, 10); round < rounds; ++round) {
        recover(c);
        for (uint64_t k = any(100); k > 0; --k) {
            long errors = answered[fmi3Error];
            call(c);
            if (answered[fmi3Error] > errors && any(3)) recover(c);
        }
        reference_run(c, outputs);
        CHECK(same_bits(outputs, wanted, output_values), "round %ld: another result", round);
    }
    for (int k = 0; k < STATES; ++k) CALL(FreeFMUState, states + k);
    FreeInstance(c);
    CHECK(answered[fmi3OK] && answered[fmi3Error], "both happen");
    printf("seed %s: %ld ok, %ld warning, %ld discard, %ld error; as new after each reset\n",
           argv[8], answered[0], answered[1], answered[2], answered[3]);
    return 0;
}
