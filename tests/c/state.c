/* FMU states. `write`: runs, saves, runs on, restores, runs on again, and writes the state to a
   file. `read`: another process goes on from the file. Both print the outputs at the end. */
#include "host.h"

enum { BEFORE = 700, AFTER = 900 };

static struct given given;
static struct library fmu;

static void check(fmi2Status status, fmi2Status wanted) {
    CHECK(status == wanted, "status %d, not %d: %s", (int)status, (int)wanted, last_message);
}

static void write_state(fmi2Component c, fmi2FMUstate state, const char *path) {
    size_t size = 0;
    check(fmu.SerializedFMUstateSize(c, state, &size), fmi2OK);
    fmi2Byte *bytes = malloc(size), *again = malloc(size);
    CHECK(bytes && again, "room");
    check(fmu.SerializeFMUstate(c, state, bytes, size), fmi2OK);
    /* Back and forth gives the same bytes. */
    fmi2FMUstate copy = NULL;
    check(fmu.DeSerializeFMUstate(c, bytes, size, &copy), fmi2OK);
    check(fmu.SerializeFMUstate(c, copy, again, size), fmi2OK);
    CHECK(!memcmp(bytes, again, size), "serialised, read and serialised again: other bytes");
    check(fmu.FreeFMUstate(c, &copy), fmi2OK);
    CHECK(!copy, "freeing sets the pointer to null");
    check(fmu.FreeFMUstate(c, &copy), fmi2OK);
    FILE *file = fopen(path, "wb");
    CHECK(file && fwrite(bytes, 1, size, file) == size && !fclose(file), "%s", path);
    free(bytes), free(again);
}

static void write(const char *path) {
    double first[MOST], second[MOST], at[MOST], back[MOST], time = BEFORE * given.period;
    fmi2FMUstate state = NULL;
    fmi2Component c = started(&fmu, &given, 0.0);
    run(&fmu, c, &given, 0.0, BEFORE, at);
    check(fmu.GetFMUstate(c, &state), fmi2OK);
    write_state(c, state, path);
    run(&fmu, c, &given, time, AFTER, first);
    CHECK(!same_bits(at, first, given.outputs), "the run goes on");
    for (int round = 0; round < 3; ++round) {
        /* From every state of the instance: after a step, after an error, after the end. */
        if (round == 1) check(fmu.DoStep(c, -1.0, 1.0, fmi2False), fmi2Error);
        if (round == 2) check(fmu.Terminate(c), fmi2OK);
        check(fmu.SetFMUstate(c, state), fmi2OK);
        get(&fmu, c, &given, back);
        CHECK(same_bits(at, back, given.outputs), "the outputs are those of the saved point");
        run(&fmu, c, &given, time, AFTER, second);
        CHECK(same_bits(first, second, given.outputs), "round %d differs", round);
    }
    /* A reset instance and another instance go on from it as well. */
    check(fmu.Reset(c), fmi2OK);
    check(fmu.SetFMUstate(c, state), fmi2OK);
    run(&fmu, c, &given, time, AFTER, second);
    CHECK(same_bits(first, second, given.outputs), "after a reset");
    fmi2Component other = instantiate(&fmu, &given);
    check(fmu.SetFMUstate(other, state), fmi2OK);
    run(&fmu, other, &given, time, AFTER, second);
    CHECK(same_bits(first, second, given.outputs), "in another instance");
    fmu.FreeInstance(other);
    print_bits(first, given.outputs);
    check(fmu.FreeFMUstate(c, &state), fmi2OK);
    fmu.FreeInstance(c);
}

/* Damaged bytes must be refused, whatever was done to them, and leave the instance as it was. */
static void refuse_garbage(const fmi2Byte *bytes, size_t size, uint64_t seed) {
    fmi2Component c = started(&fmu, &given, 0.0);
    fmi2Byte *wrong = malloc(size + 64);
    double outputs[MOST], wanted[MOST];
    CHECK(wrong, "room");
    run(&fmu, c, &given, 0.0, 50, wanted);
    for (int k = 0; k < 3000; ++k) {
        size_t length = size;
        memcpy(wrong, bytes, size);
        memset(wrong + size, 0, 64);
        switch (k % 4) {
        case 0: wrong[random_bits(&seed) % size] ^= (fmi2Byte)(1 + random_bits(&seed) % 255); break;
        case 1: length = random_bits(&seed) % size; break;
        case 2:
            for (size_t i = 0; i < size; ++i) wrong[i] = (fmi2Byte)random_bits(&seed);
            break;
        default:
            length = random_bits(&seed) % 64;
            for (size_t i = 0; i < length; ++i) wrong[i] = (fmi2Byte)random_bits(&seed);
        }
        fmi2FMUstate state = NULL;
        check(fmu.DeSerializeFMUstate(c, wrong, length, &state), fmi2Error);
        CHECK(!state, "no state comes of garbage");
        check(fmu.Reset(c), fmi2OK);
    }
    start(&fmu, c, 0.0);
    run(&fmu, c, &given, 0.0, 50, outputs);
    CHECK(same_bits(outputs, wanted, given.outputs), "the instance is as before");
    free(wrong);
    fmu.FreeInstance(c);
}

static void read(const char *path, uint64_t seed) {
    FILE *file = fopen(path, "rb");
    CHECK(file, "%s", path);
    static fmi2Byte bytes[1 << 20];
    size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    fmi2FMUstate state = NULL;
    double outputs[MOST];
    fmi2Component c = instantiate(&fmu, &given);
    check(fmu.DeSerializeFMUstate(c, bytes, size, &state), fmi2OK);
    check(fmu.SetFMUstate(c, state), fmi2OK);
    run(&fmu, c, &given, BEFORE * given.period, AFTER, outputs);
    print_bits(outputs, given.outputs);
    refuse_garbage(bytes, size, seed);
    fmu.FreeInstance(c);
}

int main(int argc, char **argv) {
    given = given_by(argc, argv);
    CHECK(argc == 10, "say write or read, the file and a seed");
    fmu = load(given.library, RTLD_NOW | RTLD_LOCAL);
    if (!strcmp(argv[7], "write"))
        write(argv[8]);
    else
        read(argv[8], strtoull(argv[9], NULL, 10));
    return 0;
}
