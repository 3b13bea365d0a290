/* Two FMUs of sources, two instances of each, in one program: the first FMU is part of this file, the second is
 * linked. One instance is broken on purpose, by a panic and by wild addresses; the others go on, and it works again after
 * a reset. */
#include "fmu.c"

#include <stdio.h>

fmi3Instance p885_fmi3InstantiateCoSimulation(fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean, fmi3Boolean,
                                              fmi3Boolean, const fmi3ValueReference[], size_t, fmi3InstanceEnvironment,
                                              fmi3LogMessageCallback, fmi3IntermediateUpdateCallback);
fmi3Status p885_fmi3EnterInitializationMode(fmi3Instance, fmi3Boolean, fmi3Float64, fmi3Float64, fmi3Boolean, fmi3Float64);
fmi3Status p885_fmi3ExitInitializationMode(fmi3Instance);
fmi3Status p885_fmi3DoStep(fmi3Instance, fmi3Float64, fmi3Float64, fmi3Boolean, fmi3Boolean*, fmi3Boolean*, fmi3Boolean*,
                           fmi3Float64*);
void p885_fmi3FreeInstance(fmi3Instance);

static void print_message(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message) {
  (void)category;
  printf("%s: status %d: %s\n", (const char*)environment, (int)status, message);
}

/* Asks the core for more memory than there is numbers for: its own check of that panics. */
static fmi3Status break_it(fmi3Instance instance) {
  ENTER(instance, "break_it");
  room_for(s, 0xfffffff0u);
  return fmi3OK;
}

#define MUST(call) \
  if ((call) != fmi3OK) return printf("%s failed\n", #call), 1

static int start(fmi3Instance instance) {
  MUST(fmi3EnterInitializationMode(instance, false, 0, 0, false, 0));
  MUST(fmi3ExitInitializationMode(instance));
  return 0;
}

/* The sum over the outputs of these steps. */
static int run(fmi3Instance instance, int from, int to, double* sum) {
  const fmi3ValueReference command = 0, position = 2;
  for (int k = from; k < to; k++) {
    double u[2], y[2], last;
    fmi3Boolean event, terminate, early;
    u[0] = 40.0 + k % 97;
    u[1] = 90.0 - k % 41;
    MUST(fmi3SetFloat64(instance, &command, 1, u, 2));
    MUST(fmi3DoStep(instance, k * 2e-5, 2e-5, false, &event, &terminate, &early, &last));
    MUST(fmi3GetFloat64(instance, &position, 1, y, 2));
    *sum = *sum + y[0];
    *sum = *sum + y[1];
  }
  return 0;
}

int main(void) {
  fmi3Instance a[2], b[2];
  const fmi3ValueReference position = 2;
  double sum[2] = {0, 0}, again = 0, last;
  fmi3Boolean event, terminate, early;
  const char* names[2] = {"first", "second"};
  for (int i = 0; i < 2; i++) {
    a[i] = fmi3InstantiateCoSimulation(names[i], PIEZOLOOP_TOKEN, 0, false, true, false, false, 0, 0, (void*)names[i],
                                       print_message, 0);
    if (!a[i] || start(a[i])) return puts("no instance"), 1;
  }
  /* With the token of another model there is none, and the message says which it should be. */
  if (p885_fmi3InstantiateCoSimulation("b", PIEZOLOOP_TOKEN, 0, false, true, false, false, 0, 0, (void*)"b", print_message, 0))
    return puts("an instance with another model's token"), 1;
  for (int i = 0; i < 2; i++) {
    b[i] = p885_fmi3InstantiateCoSimulation("b", SECOND_TOKEN, 0, false, true, false, false, 0, 0, (void*)"b", print_message, 0);
    if (!b[i]) return puts("no instance of the second"), 1;
    MUST(p885_fmi3EnterInitializationMode(b[i], false, 0, 0, false, 0));
    MUST(p885_fmi3ExitInitializationMode(b[i]));
    MUST(p885_fmi3DoStep(b[i], 0, 5e-3, false, &event, &terminate, &early, &last));
  }
  for (int i = 0; i < 2; i++)
    if (run(a[i], 0, 500, &sum[i])) return 1;
  if (sum[0] != sum[1]) return puts("two instances differ"), 1;
  if (break_it(a[0]) != fmi3Error) return puts("a panic is an error"), 1;
  if (fmi3DoStep(a[0], 500 * 2e-5, 2e-5, false, &event, &terminate, &early, &last) != fmi3Error)
    return puts("a broken instance says so"), 1;
  if (run(a[1], 500, 1000, &sum[1])) return 1;
  MUST(fmi3Reset(a[0]));
  if (start(a[0]) || run(a[0], 0, 1000, &again)) return 1;
  if (again != sum[1]) return puts("a reset instance differs"), 1;
  for (int shift = 0; shift < 28; shift++) {
    uint32_t kept = ((Instance*)a[0])->fmu;
    double y[2];
    ((Instance*)a[0])->fmu = 0xfffffff8u << shift;
    fmi3DoStep(a[0], 1000 * 2e-5, 2e-5, false, &event, &terminate, &early, &last);
    fmi3GetFloat64(a[0], &position, 1, y, 2);
    ((Instance*)a[0])->fmu = kept;
    /* What it read was its own: the other goes on, and a reset makes it well. */
    if (run(a[1], 1000 + shift, 1001 + shift, &sum[1])) return 1;
    MUST(fmi3Reset(a[0]));
    again = 0;
    if (start(a[0]) || run(a[0], 0, 500, &again)) return 1;
    if (again != sum[0]) return puts("an instance with a wild address differs after its reset"), 1;
  }
  fmi3FreeInstance(a[0]);
  fmi3FreeInstance(a[1]);
  p885_fmi3FreeInstance(b[0]);
  p885_fmi3FreeInstance(b[1]);
  puts("well");
  return 0;
}
