/* What nine importers were seen to pass, each replayed: the callbacks and environment, the spelling
   of the resources' location, the experiment, when values are set and read, the jitter of time.
   Every one of them must get the same bits. */
#include "host.h"

enum { STEPS = 400, PARAMETERS = 256 };

/* When inputs get their first values. */
enum first { BEFORE_SETUP, BEFORE_INITIALIZATION, IN_INITIALIZATION, AT_THE_FIRST_STEP };

struct importer {
    const char *name;
    int memory_functions, environment, logger;
    /* A format for the absolute path, percent-encoded; NULL: a null pointer is passed. */
    const char *resources;
    int stop_defined, tolerance_defined, visible, logging;
    enum first first_inputs;
    /* Reads every parameter in Initialization Mode; sets one to its value there. */
    int reads_parameters, sets_parameter;
    /* Reads each output twice; reads parameters and inputs after each step. */
    int reads_twice, reads_all;
    /* Adds up the steps, so that time jitters by what is lost; states an odd last step. */
    int adds_up;
    int may_go_back;
};

static const struct importer all[] = {
    {.name = "fmpy", .memory_functions = 1, .logger = 1, .resources = "file://%s",
     .stop_defined = 1, .first_inputs = BEFORE_INITIALIZATION, .adds_up = 1, .may_go_back = 0},
    {.name = "fmusim", .environment = 1, .logger = 1, .resources = "file://%s/",
     .first_inputs = BEFORE_SETUP, .reads_twice = 1, .may_go_back = 1},
    {.name = "fmusim, no resources folder", .environment = 1, .logger = 1, .resources = NULL,
     .first_inputs = BEFORE_SETUP, .reads_twice = 1, .may_go_back = 1},
    {.name = "fmuCheck", .memory_functions = 1, .environment = 1, .logger = 1,
     .resources = "file://%s", .logging = 1, .first_inputs = AT_THE_FIRST_STEP, .reads_all = 1},
    {.name = "OMSimulator", .memory_functions = 1, .logger = 1, .resources = "file:///%s",
     .tolerance_defined = 1, .visible = 1, .logging = 1, .first_inputs = IN_INITIALIZATION},
    {.name = "ecos", .memory_functions = 1, .logger = 1, .resources = "file:///%s",
     .first_inputs = IN_INITIALIZATION, .sets_parameter = 1, .adds_up = 1},
    {.name = "PyFMI", .memory_functions = 1, .environment = 1, .logger = 1,
     .resources = "file://%s", .tolerance_defined = 1, .logging = 1,
     .first_inputs = BEFORE_INITIALIZATION},
    {.name = "libcosim", .memory_functions = 1, .logger = 1, .resources = "file://%s",
     .first_inputs = IN_INITIALIZATION, .reads_parameters = 1},
    {.name = "fmucontainer", .memory_functions = 1, .environment = 1, .logger = 1,
     .resources = "file:///%s", .first_inputs = IN_INITIALIZATION, .adds_up = 1},
    {.name = "fmi-sim", .memory_functions = 1, .logger = 1, .resources = "file://%s",
     .stop_defined = 1, .visible = 1, .logging = 1, .first_inputs = BEFORE_INITIALIZATION},
    {.name = "nobody: no callback at all", .resources = "file://localhost%s",
     .first_inputs = AT_THE_FIRST_STEP},
};

static struct given given;
static struct library fmu;
static size_t reals, booleans;
static fmi2ValueReference real[PARAMETERS], boolean[PARAMETERS];

/* What the logger was called with. */
static fmi2ComponentEnvironment seen_environment;
static char seen_instance[200], seen_category[100], seen_format[1000];
static fmi2Status seen_status;
static int seen;

static void logger(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                   fmi2String category, fmi2String message, ...) {
    seen_environment = environment;
    seen_status = status;
    snprintf(seen_instance, sizeof seen_instance, "%s", instance);
    snprintf(seen_category, sizeof seen_category, "%s", category);
    snprintf(seen_format, sizeof seen_format, "%s", message);
    ++seen;
}

static size_t list(const char *text, fmi2ValueReference *into) {
    size_t count = 0;
    while (*text && *text != '-') {
        char *end;
        CHECK(count < PARAMETERS, "too many parameters");
        into[count++] = (fmi2ValueReference)strtoul(text, &end, 10);
        text = *end == ',' ? end + 1 : end;
    }
    return count;
}

/* Inputs that begin at their start value, 0: some importers set them before the initialization,
   others at the first step. */
static void inputs_at(int k, double *values) {
    wave(&given, k * given.period, values);
    for (size_t i = 0; i < given.inputs; ++i) values[i] *= k / (k + 50.0);
}

#define OK(call) CHECK((call) == fmi2OK, "%s: %s", who->name, seen_format)

static void read_parameters(const struct importer *who, fmi2Component c) {
    for (size_t k = 0; k < reals; ++k) {
        double value = NAN;
        OK(fmu.GetReal(c, real + k, 1, &value));
        CHECK(isfinite(value), "%s: parameter %u", who->name, real[k]);
    }
    for (size_t k = 0; k < booleans; ++k) {
        fmi2Boolean value = -1;
        OK(fmu.GetBoolean(c, boolean + k, 1, &value));
        CHECK(value == fmi2True || value == fmi2False, "%s: %d", who->name, value);
    }
    /* Importers ask for each type, also where there is no variable of it. */
    OK(fmu.GetString(c, NULL, 0, NULL));
    OK(fmu.GetInteger(c, NULL, 0, NULL));
}

static void first_inputs(const struct importer *who, fmi2Component c, enum first now) {
    double inputs[MOST];
    inputs_at(0, inputs);
    if (who->first_inputs == now) OK(fmu.SetReal(c, given.input, given.inputs, inputs));
}

static void initialise(const struct importer *who, fmi2Component c, double stop) {
    double value;
    first_inputs(who, c, BEFORE_SETUP);
    OK(fmu.SetupExperiment(c, who->tolerance_defined, 1e-4, 0.0, who->stop_defined, stop));
    first_inputs(who, c, BEFORE_INITIALIZATION);
    OK(fmu.EnterInitializationMode(c));
    first_inputs(who, c, IN_INITIALIZATION);
    if (who->reads_parameters) read_parameters(who, c);
    if (who->sets_parameter) {
        OK(fmu.GetReal(c, real, 1, &value));
        OK(fmu.SetReal(c, real, 1, &value));
    }
    OK(fmu.ExitInitializationMode(c));
}

static void simulate(const struct importer *who, fmi2Component c, double *outputs) {
    double inputs[MOST], again[MOST], now = 0.0, stop = STEPS * given.period;
    for (int k = 0; k < STEPS; ++k) {
        double time = who->adds_up ? now : k * given.period;
        double size = who->adds_up && k + 1 == STEPS ? stop - time : given.period;
        inputs_at(k, inputs);
        OK(fmu.SetReal(c, given.input, given.inputs, inputs));
        OK(fmu.DoStep(c, time, size, !who->may_go_back));
        OK(fmu.GetReal(c, given.output, given.outputs, outputs));
        if (who->reads_twice) {
            OK(fmu.GetReal(c, given.output, given.outputs, again));
            CHECK(same_bits(outputs, again, given.outputs), "%s: read twice", who->name);
        }
        if (who->reads_all) {
            read_parameters(who, c);
            OK(fmu.GetReal(c, given.input, given.inputs, again));
            CHECK(same_bits(inputs, again, given.inputs), "%s: inputs read back", who->name);
        }
        now += size;
    }
}

/* An error at the end: who is told, with what. */
static void told(const struct importer *who, fmi2Component c, void *environment,
                 const char *instance) {
    double value;
    fmi2ValueReference unknown = 4000000000u;
    int before = seen;
    CHECK(fmu.GetReal(c, &unknown, 1, &value) == fmi2Error, "%s: unknown reference", who->name);
    if (!who->logger) return;
    CHECK(seen == before + 1 && seen_status == fmi2Error, "%s: one message", who->name);
    CHECK(seen_environment == environment, "%s: another environment", who->name);
    CHECK(!strcmp(seen_instance, instance), "%s: instance %s", who->name, seen_instance);
    CHECK(!strcmp(seen_category, "logStatusError"), "%s: %s", who->name, seen_category);
    CHECK(strstr(seen_format, "4000000000"), "%s: %s", who->name, seen_format);
}

static void play(const struct importer *who, double *outputs) {
    char location[4000], instance[4000], environment[1];
    fmi2CallbackFunctions functions = {
        who->logger ? logger : NULL, who->memory_functions ? calloc : NULL,
        who->memory_functions ? free : NULL, NULL, who->environment ? environment : NULL};
    snprintf(location, sizeof location, who->resources ? who->resources : "%s", given.resources);
    /* ecos names the instance by the FMU's file. */
    snprintf(instance, sizeof instance, "%s",
             strcmp(who->name, "ecos") ? "instance" : "/home/user/loop/plant 1.fmu");
    char guid[100];
    snprintf(guid, sizeof guid, "%s", given.guid);
    fmi2Component c = fmu.Instantiate(instance, fmi2CoSimulation, guid,
                                      who->resources ? location : NULL, &functions, who->visible,
                                      who->logging);
    CHECK(c, "%s: %s", who->name, seen_format);
    /* Structure and texts are only good during the call: what the FMU needs, it has copied. */
    char kept[4000];
    memcpy(kept, instance, sizeof kept);
    memset(&functions, 0x5a, sizeof functions);
    memset(instance, 'z', sizeof instance - 1);
    memset(location, 'z', sizeof location - 1);
    initialise(who, c, STEPS * given.period);
    simulate(who, c, outputs);
    OK(fmu.Terminate(c));
    told(who, c, who->environment ? environment : NULL, kept);
    fmu.FreeInstance(c);
}

int main(int argc, char **argv) {
    given = given_by(argc, argv);
    CHECK(argc == 9, "give real and Boolean parameters");
    reals = list(argv[7], real), booleans = list(argv[8], boolean);
    CHECK(reals > 0, "parameters");
    fmu = load(given.library, RTLD_NOW | RTLD_LOCAL);
    double wanted[MOST], outputs[MOST];
    play(all, wanted);
    print_bits(wanted, given.outputs);
    for (size_t k = 0; k < sizeof all / sizeof *all; ++k) {
        play(all + k, outputs);
        CHECK(same_bits(outputs, wanted, given.outputs), "%s: another result: %.17g, not %.17g",
              all[k].name, outputs[0], wanted[0]);
        printf("%s: the same bits\n", all[k].name);
    }
    return 0;
}
