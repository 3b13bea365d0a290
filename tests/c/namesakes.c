/* A host that exports functions with the names of the standard itself, and loads two FMUs with
   RTLD_GLOBAL: each library must reach its own functions. Prints the outputs of both. */
#include "host.h"

#define X(name)                                                                                    \
    int fmi2##name(void);                                                                          \
    int fmi2##name(void) {                                                                         \
        fprintf(stderr, "the host's fmi2" #name " was reached\n");                                 \
        exit(2);                                                                                   \
    }
FMI2_FUNCTIONS(X)
#undef X

int main(int argc, char **argv) {
    CHECK(argc == 13, "give two FMUs");
    struct given plant = given_by(argc, argv), controller = given_by(argc - 6, argv + 6);
    struct library first = load(plant.library, RTLD_NOW | RTLD_GLOBAL);
    struct library second = load(controller.library, RTLD_NOW | RTLD_GLOBAL);
    CHECK((void *)first.DoStep != (void *)second.DoStep, "each library has its own functions");
    fmi2Component a = started(&first, &plant, 0.0), b = started(&second, &controller, 0.0);
    double outputs[MOST];
    run(&first, a, &plant, 0.0, 500, outputs);
    print_bits(outputs, plant.outputs);
    run(&second, b, &controller, 0.0, 500, outputs);
    print_bits(outputs, controller.outputs);
    CHECK(first.DoStep(a, -1.0, 1.0, fmi2True) == fmi2Error, "a wrong time is refused");
    CHECK(strstr(last_message, "fmi2DoStep"), "%s", last_message);
    first.FreeInstance(a);
    second.FreeInstance(b);
    return 0;
}
