/* Steps models through the functions of FMI 2.0 and writes what they gave: bits.c CASES [ANSWERS].
 * CASES is what bits.rs wrote: per model the bytes, the token, the period, the inputs and the outputs. A line per
 * model goes out, with a hash over the bits of all outputs and the time of a step; ANSWERS takes the outputs. */
#include "runtime.h"
static unsigned char model_bytes[1 << 21];
static unsigned model_size;
static char model_token[40];
#define PIEZOLOOP_PREFIX
#define PIEZOLOOP_PAGES 4
#define PIEZOLOOP_VALUES 1000
#define PIEZOLOOP_MODEL model_bytes
#define PIEZOLOOP_MODEL_SIZE model_size
#define PIEZOLOOP_TOKEN model_token
#define FMI2_FUNCTION_PREFIX
#include "core.h"
#include "fmi2.h"

#include <stdio.h>
#include <time.h>

typedef struct {
  fmi2ValueReference reference;
  uint32_t type;
  double low, high;
} Port;
static Port inputs[64], outputs[256];
static unsigned long allocations;

static void* allocate(size_t count, size_t size) {
  allocations++;
  return calloc(count, size);
}
static void log_message(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                        fmi2String message, ...) {
  (void)environment, (void)category;
  printf("%s: status %d: %s\n", name, (int)status, message);
}
static uint32_t word(FILE* file) {
  uint32_t value = 0;
  return fread(&value, 4, 1, file) == 1 ? value : 0;
}
static double number(FILE* file) {
  double value = 0;
  return fread(&value, 8, 1, file) == 1 ? value : 0;
}
static void ports(FILE* file, Port* list, uint32_t count) {
  for (uint32_t i = 0; i < count; i++) {
    list[i].reference = word(file);
    list[i].type = word(file);
    list[i].low = number(file);
    list[i].high = number(file);
  }
}
#define MUST(call) \
  if ((call) > fmi2Warning) return printf("%s failed in model %u at step %ld\n", #call, model, k), 1

int main(int count, char** arguments) {
  FILE* file = count > 1 ? fopen(arguments[1], "rb") : 0;
  FILE* answers = count > 2 ? fopen(arguments[2], "wb") : 0;
  uint32_t models, steps;
  if (!file) return puts("no cases"), 1;
  models = word(file);
  steps = word(file);
  for (uint32_t model = 0; model < models; model++) {
    uint32_t input_count, output_count, state_at = steps / 2;
    uint64_t hash = 0xcbf29ce484222325u;
    double period;
    long k = -1;
    clock_t begun;
    fmi2CallbackFunctions functions = {log_message, allocate, free, 0, 0};
    fmi2Component c;
    fmi2FMUstate state = 0;
    unsigned long made;
    model_size = word(file);
    if (model_size > sizeof model_bytes || fread(model_bytes, 1, model_size, file) != model_size) return puts("cut"), 1;
    if (fread(model_token, 1, 32, file) != 32) return puts("cut"), 1;
    period = number(file);
    input_count = word(file);
    ports(file, inputs, input_count);
    output_count = word(file);
    ports(file, outputs, output_count);
    allocations = 0;
    c = fmi2Instantiate("model", fmi2CoSimulation, model_token, 0, &functions, 0, 0);
    if (!c) return printf("model %u cannot be instantiated\n", model), 1;
    made = allocations;
    MUST(fmi2SetupExperiment(c, 0, 0, 0, 0, 0));
    MUST(fmi2EnterInitializationMode(c));
    MUST(fmi2ExitInitializationMode(c));
    begun = clock();
    for (k = 0; k < (long)steps; k++) {
      if (k == (long)state_at && !answers) {
        /* Through a saved state and back, which changes nothing. */
        MUST(fmi2GetFMUstate(c, &state));
        MUST(fmi2DoStep(c, (double)k * period, period, 0));
        MUST(fmi2SetFMUstate(c, state));
        MUST(fmi2FreeFMUstate(c, &state));
        made++;
      }
      for (uint32_t i = 0; i < input_count; i++) {
        const Port* port = inputs + i;
        if (port->type) {
          int on = k % 5000 < 4500;
          MUST(fmi2SetBoolean(c, &port->reference, 1, &on));
        } else {
          long phase = k * (3 + (long)i) % 2000;
          double share = (double)(phase < 1000 ? phase : 2000 - phase) / 1000.0;
          double value = (port->high - port->low) * share;
          value = value + port->low;
          MUST(fmi2SetReal(c, &port->reference, 1, &value));
        }
      }
      MUST(fmi2DoStep(c, (double)k * period, period, 0));
      for (uint32_t i = 0; i < output_count; i++) {
        const Port* port = outputs + i;
        double value = 0;
        uint64_t bits;
        int on = 0;
        if (port->type == 1) MUST(fmi2GetBoolean(c, &port->reference, 1, &on));
        if (port->type == 2) MUST(fmi2GetInteger(c, &port->reference, 1, &on));
        if (port->type == 0) MUST(fmi2GetReal(c, &port->reference, 1, &value));
        if (port->type) value = on;
        memcpy(&bits, &value, 8);
        hash = (hash ^ bits) * 0x100000001b3u;
        if (answers) fwrite(&value, 8, 1, answers);
      }
    }
    begun = clock() - begun;
    printf("%u %08lx%08lx %.0f ns, %lu allocations, %lu after instantiation, %lu KiB, %u bytes\n", model,
           (unsigned long)(hash >> 32), (unsigned long)(hash & 0xffffffffu), 1e9 * (double)begun / CLOCKS_PER_SEC / steps,
           made, allocations - made, (unsigned long)(((Instance*)c)->core.w2c_memory.pages * 64), model_size);
    fflush(stdout);
    fmi2FreeInstance(c);
  }
  return 0;
}
