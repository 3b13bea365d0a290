/* An FMU in C whose step calls its own fmi2SetReal by name. Linked plainly, that call reaches a
   function of the same name in the host; with -Bsymbolic it reaches its own. */
#include "fmi2Functions.h"

#undef fmi2DoStep
#define fmi2DoStep step_of_trivial
FMI2_Export fmi2DoStepTYPE step_of_trivial;
#include "trivial.c"
#undef fmi2DoStep

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_way_back) {
    fmi2Status status = fmi2SetReal(c, NULL, 0, NULL);
    return status == fmi2OK ? step_of_trivial(c, time, step, no_way_back) : status;
}
