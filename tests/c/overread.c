/* Says that an array is longer than it is: what the sanitizer must see, if it sees anything in the
   library. */
#include "host.h"

int main(int argc, char **argv) {
    struct given given = given_by(argc, argv);
    struct library fmu = load(given.library, RTLD_NOW | RTLD_LOCAL);
    fmi2Component c = started(&fmu, &given, 0.0);
    double *short_array = malloc(sizeof *short_array);
    *short_array = 1.0;
    const fmi2ValueReference both[] = {given.input[0], given.input[1]};
    fmi2Status status = fmu.SetReal(c, both, 2, short_array);
    printf("nobody saw it: status %d\n", (int)status);
    free(short_array);
    fmu.FreeInstance(c);
    return 0;
}
