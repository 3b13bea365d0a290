/* Instances of a plant and a controller that are made, stepped and freed, as many as are given: memory does
   not grow, and each life is the first one to the bit. Every tenth saves, serialises and frees a state too.
   Arguments: those of the plant, those of the controller, lives. */
#include "host.h"

enum { STEPS = 5 };

static void life(const struct library *fmu, const struct given *given, int saves, double *outputs) {
    fmi2Component c = started(fmu, given, 0.0);
    run(fmu, c, given, 0.0, STEPS, outputs);
    if (saves) {
        fmi2FMUstate state = NULL, again = NULL;
        size_t size = 0;
        CHECK(fmu->GetFMUstate(c, &state) == fmi2OK, "%s", last_message);
        CHECK(fmu->SerializedFMUstateSize(c, state, &size) == fmi2OK, "%s", last_message);
        fmi2Byte *bytes = malloc(size);
        CHECK(fmu->SerializeFMUstate(c, state, bytes, size) == fmi2OK, "%s", last_message);
        CHECK(fmu->DeSerializeFMUstate(c, bytes, size, &again) == fmi2OK, "%s", last_message);
        CHECK(fmu->SetFMUstate(c, again) == fmi2OK, "%s", last_message);
        CHECK(fmu->FreeFMUstate(c, &state) == fmi2OK, "%s", last_message);
        CHECK(fmu->FreeFMUstate(c, &again) == fmi2OK, "%s", last_message);
        free(bytes);
    }
    fmu->FreeInstance(c);
}

int main(int argc, char **argv) {
    CHECK(argc == 14, "give plant, controller, lives");
    struct given given[2] = {given_by(argc, argv), given_by(argc - 6, argv + 6)};
    long lives = strtol(argv[13], NULL, 10), memory = 0, most = 0;
    struct library fmu[2];
    double first[2][MOST], outputs[MOST];
    for (int which = 0; which < 2; ++which) {
        fmu[which] = load(given[which].library, RTLD_NOW | RTLD_LOCAL);
        life(&fmu[which], &given[which], 1, first[which]);
    }
    for (long k = 0; k < lives; ++k) {
        for (int which = 0; which < 2; ++which) {
            life(&fmu[which], &given[which], k % 10 == 0, outputs);
            CHECK(same_bits(first[which], outputs, given[which].outputs), "life %ld", k);
        }
        /* What the allocator keeps is there after some lives. */
        if (k == lives / 100) memory = resident();
        if (k > lives / 100 && resident() - memory > most) most = resident() - memory;
    }
    printf("%ld lives of each: at most %ld bytes more\n", lives, most);
    CHECK(most < 1 << 18, "%ld bytes more", most);
    CHECK(messages == 0, "%s", last_message);
    return 0;
}
