/* A whole life in FMI 3.0. `write`: initialises, runs, saves, serialises to a file, runs on, comes
   back from an error, the end and a reset, runs on again. `read`: another process goes on from the
   file. Both print the outputs at the end. */
#include "host.h"

#include "fmi3FunctionTypes.h"

enum { BEFORE = 300, AFTER = 400 };

#define FUNCTIONS(X)                                                                               \
    X(InstantiateCoSimulation) X(FreeInstance) X(SetDebugLogging) X(EnterInitializationMode)       \
    X(ExitInitializationMode) X(Terminate) X(Reset) X(GetFloat64) X(SetFloat64) X(GetFMUState)     \
    X(SetFMUState) X(FreeFMUState) X(SerializedFMUStateSize) X(SerializeFMUState)                  \
    X(DeserializeFMUState) X(GetDirectionalDerivative) X(DoStep)

#define X(name) static fmi3##name##TYPE *name;
FUNCTIONS(X)
#undef X

static struct given given, flat;
static size_t output_values;

static void told(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                 fmi3String message) {
    CHECK(environment == &given, "the environment is the importer's");
    (void)status, (void)category;
    snprintf(last_message, sizeof last_message, "%s", message);
}

static void check(fmi3Status status, fmi3Status wanted) {
    CHECK(status == wanted, "status %d, not %d: %s", (int)status, (int)wanted, last_message);
}

static fmi3Instance instance(void) {
    fmi3Instance c =
        InstantiateCoSimulation("life", given.guid, given.resources, false, true, false, true, NULL,
                                0, &given, told, NULL);
    CHECK(c, "%s", last_message);
    return c;
}

static void start3(fmi3Instance c) {
    check(EnterInitializationMode(c, true, 1e-6, 0.0, false, 0.0), fmi3OK);
    check(ExitInitializationMode(c), fmi3OK);
}

static void get3(fmi3Instance c, double *outputs) {
    check(GetFloat64(c, given.output, given.outputs, outputs, output_values), fmi3OK);
}

static void run3(fmi3Instance c, int from, int steps, double *outputs) {
    double values[MOST], last;
    bool event, end, early;
    for (int k = from; k < from + steps; ++k) {
        wave(&flat, k * given.period, values);
        check(SetFloat64(c, given.input, given.inputs, values, flat.inputs), fmi3OK);
        check(DoStep(c, k * given.period, given.period, true, &event, &end, &early, &last), fmi3OK);
        CHECK(!event && !end && !early, "the step goes to its end");
    }
    get3(c, outputs);
}

static void derivatives(fmi3Instance c) {
    double seed[MOST], sensitivity[MOST];
    for (size_t i = 0; i < flat.inputs; ++i) seed[i] = 1.0;
    check(GetDirectionalDerivative(c, given.output, 1, given.input, given.inputs, seed,
                                   flat.inputs, sensitivity, output_values / given.outputs),
          fmi3OK);
}

/* To a file, and back from bytes to the same bytes. */
static void write_state(fmi3Instance c, fmi3FMUState state, const char *path) {
    size_t size = 0;
    check(SerializedFMUStateSize(c, state, &size), fmi3OK);
    fmi3Byte *bytes = malloc(size), *again = malloc(size);
    CHECK(bytes && again, "room");
    check(SerializeFMUState(c, state, bytes, size), fmi3OK);
    fmi3FMUState copy = NULL;
    check(DeserializeFMUState(c, bytes, size, &copy), fmi3OK);
    check(SerializeFMUState(c, copy, again, size), fmi3OK);
    CHECK(!memcmp(bytes, again, size), "serialised, read and serialised again: other bytes");
    check(FreeFMUState(c, &copy), fmi3OK);
    CHECK(!copy, "freeing sets the pointer to null");
    FILE *file = fopen(path, "wb");
    CHECK(file && fwrite(bytes, 1, size, file) == size && !fclose(file), "%s", path);
    free(bytes), free(again);
}

static void write_life(const char *path) {
    double first[MOST], second[MOST], at[MOST], back[MOST], nothing;
    fmi3FMUState state = NULL;
    fmi3Instance c = instance();
    check(SetDebugLogging(c, true, 0, NULL), fmi3OK);
    start3(c);
    run3(c, 0, BEFORE, at);
    derivatives(c);
    check(GetFMUState(c, &state), fmi3OK);
    write_state(c, state, path);
    run3(c, BEFORE, AFTER, first);
    CHECK(!same_bits(at, first, output_values), "the run goes on");
    for (int round = 0; round < 4; ++round) {
        if (round == 1) check(GetFloat64(c, given.output, given.outputs, &nothing, 0), fmi3Error);
        if (round == 2) check(Terminate(c), fmi3OK);
        if (round == 3) check(Reset(c), fmi3OK);
        check(SetFMUState(c, state), fmi3OK);
        get3(c, back);
        CHECK(same_bits(at, back, output_values), "the outputs are those of the saved point");
        run3(c, BEFORE, AFTER, second);
        CHECK(same_bits(first, second, output_values), "round %d differs", round);
    }
    check(GetFMUState(c, &state), fmi3OK);
    check(Reset(c), fmi3OK);
    start3(c);
    run3(c, 0, BEFORE, second);
    CHECK(same_bits(at, second, output_values), "a reset instance is as new");
    print_bits(first, output_values);
    check(Terminate(c), fmi3OK);
    check(FreeFMUState(c, &state), fmi3OK);
    FreeInstance(c);
}

static void read_life(const char *path) {
    FILE *file = fopen(path, "rb");
    CHECK(file, "%s", path);
    static fmi3Byte bytes[1 << 20];
    size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    fmi3FMUState state = NULL;
    double outputs[MOST];
    fmi3Instance c = instance();
    for (size_t cut = 0; cut < size; cut += 97) {
        check(DeserializeFMUState(c, bytes, cut, &state), fmi3Error);
        CHECK(!state, "no state comes of garbage");
    }
    check(Reset(c), fmi3OK);
    check(DeserializeFMUState(c, bytes, size, &state), fmi3OK);
    check(SetFMUState(c, state), fmi3OK);
    run3(c, BEFORE, AFTER, outputs);
    print_bits(outputs, output_values);
    /* The state is not freed: the instance does that. */
    FreeInstance(c);
}

int main(int argc, char **argv) {
    given = flat = given_by(argc, argv);
    CHECK(argc == 11, "give the numbers of input and output values, write or read, and the file");
    flat.inputs = strtoul(argv[7], NULL, 10), output_values = strtoul(argv[8], NULL, 10);
    void *library = dlopen(given.library, RTLD_NOW | RTLD_LOCAL);
    CHECK(library, "%s", dlerror());
#define X(name)                                                                                    \
    name = (fmi3##name##TYPE *)dlsym(library, "fmi3" #name);                                       \
    CHECK(name, "no fmi3" #name);
    FUNCTIONS(X)
#undef X
    if (!strcmp(argv[9], "write"))
        write_life(argv[10]);
    else
        read_life(argv[10]);
    return 0;
}
