/* Instantiates with the location that is given ("(null)": a null pointer) from the start time that
   is given, runs 500 steps of a wave that begins there and prints the outputs; a refusal is printed with its message. */
#include "host.h"

int main(int argc, char **argv) {
    struct given given = given_by(argc, argv);
    double time = argc > 7 ? strtod(argv[7], NULL) : 0.0, outputs[MOST];
    struct library fmu = load(given.library, RTLD_NOW | RTLD_LOCAL);
    fmi2String resources = strcmp(given.resources, "(null)") ? given.resources : NULL;
    fmi2Component c = fmu.Instantiate("instance", fmi2CoSimulation, given.guid, resources,
                                      callbacks(), fmi2False, fmi2False);
    if (!c) {
        printf("refused: %s\n", last_message);
        return 0;
    }
    start(&fmu, c, time);
    wave_begin = time;
    run(&fmu, c, &given, time, 500, outputs);
    print_bits(outputs, given.outputs);
    CHECK(fmu.Terminate(c) == fmi2OK, "%s", last_message);
    fmu.FreeInstance(c);
    return 0;
}
