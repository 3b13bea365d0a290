/* Random calls of all functions of FMI 2.0 in every state with arguments that nobody should pass:
   each is answered with a status, and after a reset the instance computes what it did at first. */
#include "fuzz.h"

static struct given given;
static struct library fmu;
static double now;
static int whole[ROOM];
static long answered[6];

static void count(const char *function, fmi2Status status) {
    CHECK(status <= fmi2Error, "%s: status %d", function, (int)status);
    ++answered[status];
}

#define CALL(name, ...) count("fmi2" #name, fmu.name(c, ##__VA_ARGS__))

/* One call, of any function but the first two and those that make and free an instance. */
static void call(fmi2Component c) {
    fill();
    size_t n = length();
    void **state = rarely() ? NULL : states + any(STATES);
    double size = size_of_step(given.period);
    double time = rarely() ? number() : now;
    double *in = MAYBE(numbers), *out = MAYBE(results);
    fmi2ValueReference *vr = MAYBE(references_);
    int *orders = MAYBE(integers), *to = MAYBE(whole);
    fmi2StatusKind kind = (fmi2StatusKind)any(6);
    static fmi2Byte bytes[256];
    static fmi2EventInfo event;
    fmi2Status last;
    switch (any(48)) {
    case 0: CALL(SetDebugLogging, (int)any(2), n, any(3) ? texts : NULL); break;
    case 1: CALL(SetupExperiment, (int)any(2), number(), number(), rarely(), number()); now = 0; break;
    case 2: case 3: CALL(EnterInitializationMode); break;
    case 4: case 5: CALL(ExitInitializationMode); break;
    case 6: if (rarely()) CALL(Terminate); break;
    case 7: if (rarely()) CALL(Reset); break;
    case 8: case 9: CALL(GetReal, vr, n, out); break;
    case 10: CALL(GetInteger, vr, n, to); break;
    case 11: CALL(GetBoolean, vr, n, to); break;
    case 12: CALL(GetString, vr, n, MAYBE(texts)); break;
    case 13: case 14: CALL(SetReal, vr, n, in); break;
    case 15: CALL(SetInteger, vr, n, orders); break;
    case 16: CALL(SetBoolean, vr, n, orders); break;
    case 17: CALL(SetString, vr, n, MAYBE(texts)); break;
    case 18: CALL(GetFMUstate, state); break;
    case 19: CALL(SetFMUstate, state ? *state : NULL); break;
    case 20: CALL(FreeFMUstate, state); break;
    case 21: CALL(SerializedFMUstateSize, state ? *state : NULL, rarely() ? NULL : &n); break;
    case 22: CALL(SerializeFMUstate, state ? *state : NULL, MAYBE(bytes), any(256)); break;
    case 23: CALL(DeSerializeFMUstate, MAYBE(bytes), rarely() ? SIZE_MAX : any(256), state); break;
    case 24: CALL(GetDirectionalDerivative, vr, n, MAYBE(references_), length(), in, out); break;
    case 25: CALL(EnterEventMode); break;
    case 26: CALL(NewDiscreteStates, MAYBE(&event)); break;
    case 27: CALL(EnterContinuousTimeMode); break;
    case 28: CALL(CompletedIntegratorStep, 1, to, to); break;
    case 29: CALL(SetTime, number()); break;
    case 30: CALL(SetContinuousStates, in, n); break;
    case 31: CALL(GetDerivatives, out, n); break;
    case 32: CALL(GetEventIndicators, out, n); break;
    case 33: CALL(GetContinuousStates, out, n); break;
    case 34: CALL(GetNominalsOfContinuousStates, out, n); break;
    case 35: CALL(SetRealInputDerivatives, vr, n, orders, in); break;
    case 36: CALL(GetRealOutputDerivatives, vr, n, orders, out); break;
    case 37: CALL(CancelStep); break;
    case 38: CALL(GetStatus, kind, rarely() ? NULL : &last); break;
    case 39: CALL(GetRealStatus, kind, out); break;
    case 40: CALL(GetIntegerStatus, kind, to); break;
    case 41: CALL(GetBooleanStatus, kind, to); break;
    case 42: CALL(GetStringStatus, kind, MAYBE(texts)); break;
    default: CALL(DoStep, time, size, (int)any(2));
    }
    double at;
    if (fmu.GetRealStatus(c, fmi2LastSuccessfulTime, &at) == fmi2OK) now = at;
}

/* All functions without an instance. */
static void without_instance(void) {
    for (int k = 0; k < 5000; ++k) {
        call(NULL);
        CHECK(!answered[fmi2OK] && !answered[fmi2Warning], "success without an instance");
    }
    fmu.FreeInstance(NULL);
    CHECK(!strcmp(fmu.GetVersion(), "2.0") && !strcmp(fmu.GetTypesPlatform(), "default"), "texts");
}

static void refused_instances(void) {
    const fmi2CallbackFunctions none = {NULL, NULL, NULL, NULL, NULL};
    for (int k = 0; k < 500; ++k) {
        const fmi2CallbackFunctions *told = any(3) ? callbacks() : any(2) ? &none : NULL;
        fmi2Component c = fmu.Instantiate(text(), (fmi2Type)any(3), text(), text(), told,
                                          (int)any(2), (int)any(2));
        CHECK(!c, "no text of these is the GUID");
    }
}

/* To a state in which more than the freeing of the instance is allowed. */
static void recover(fmi2Component c) {
    CALL(Reset);
    now = 0.0;
    if (!any(4)) return;
    CHECK(fmu.EnterInitializationMode(c) <= fmi2Warning, "%s", last_message);
    if (any(4)) CHECK(fmu.ExitInitializationMode(c) == fmi2OK, "%s", last_message);
}

int main(int argc, char **argv) {
    given = given_by(argc, argv);
    CHECK(argc == 10, "give the number of variables, a seed and the number of rounds");
    variables = (uint32_t)strtoul(argv[7], NULL, 10);
    seed = strtoull(argv[8], NULL, 10);
    fmu = load(given.library, RTLD_NOW | RTLD_LOCAL);
    without_instance();
    refused_instances();
    double wanted[MOST], outputs[MOST];
    fmi2Component c = started(&fmu, &given, 0.0);
    run(&fmu, c, &given, 0.0, 50, wanted);
    long rounds = strtol(argv[9], NULL, 10);
    memset(answered, 0, sizeof answered);
    for (long round = 0; round < rounds; ++round) {
        for (uint64_t k = any(100); k > 0; --k) {
            long errors = answered[fmi2Error];
            call(c);
            if (answered[fmi2Error] > errors && any(3)) recover(c);
        }
        CHECK(fmu.Reset(c) == fmi2OK, "%s", last_message);
        start(&fmu, c, 0.0);
        run(&fmu, c, &given, 0.0, 50, outputs);
        CHECK(same_bits(outputs, wanted, given.outputs), "round %ld: another result", round);
    }
    for (int k = 0; k < STATES; ++k) CALL(FreeFMUstate, states + k);
    fmu.FreeInstance(c);
    for (int status = fmi2OK; status <= fmi2Error; ++status)
        CHECK(answered[status], "status %d never came", status);
    printf("seed %s: %ld ok, %ld warning, %ld discard, %ld error; as new after each reset\n",
           argv[8], answered[0], answered[1], answered[2], answered[3]);
    return 0;
}
