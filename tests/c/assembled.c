/* y = 2 u in C, FMI 2.0, with the duties of careful.h, but put together at run time as our models are:
   nodes in a table, each with its step as a pointer, a switch, and the places of its coefficients,
   state and signals in one block; wires with units for inputs and outputs; and what derivatives need
   of the step before is kept. No index is checked. */
#include <stddef.h>
#include <stdlib.h>

struct span {
    size_t start, length;
};

struct node {
    void (*step)(const double *coefficients, double *state, double period, const double *inputs,
                 double *outputs);
    long enabled;
    struct span coefficients, state, outputs;
    size_t inputs[8], input_count;
};

struct wire {
    size_t variable, signal;
    double factor, offset;
};

struct assembled {
    double *cells;
    struct node *nodes;
    struct wire *inputs, *outputs;
    size_t node_count, input_count, output_count;
    struct span state;
    /* The step before. */
    long hits;
    double from, *old_inputs, *old_outputs, *old_state;
};

struct careful;
static struct assembled *assembled_new(void);
static double assembled_hits(struct careful *it, double limit, double y);
#define CAREFUL_MODEL() assembled_new()
#define CAREFUL_HITS(it, limit, y) y = assembled_hits(it, limit, y);
#include "careful.c"

static void gain(const double *coefficients, double *state, double period, const double *inputs,
                 double *outputs) {
    outputs[0] = coefficients[0] * inputs[0] + coefficients[1];
}

/* Cells: u, y, gain and offset as set; gain and offset in SI; signals zero, u, y. */
static struct assembled *assembled_new(void) {
    struct assembled *it = calloc(1, sizeof *it);
    if (!it) return NULL;
    it->cells = calloc(16, sizeof *it->cells);
    it->old_inputs = calloc(16, sizeof *it->old_inputs);
    it->old_outputs = it->old_inputs + 1;
    it->old_state = it->old_inputs + 2;
    it->nodes = calloc(1, sizeof *it->nodes);
    it->inputs = calloc(2, sizeof *it->inputs);
    it->outputs = it->inputs + 1;
    it->node_count = it->input_count = it->output_count = 1;
    it->state = (struct span){6, 0};
    it->cells[4] = 2e-6;
    it->inputs[0] = (struct wire){0, 7, VOLT, 0.0};
    it->outputs[0] = (struct wire){1, 8, MICROMETRE, 0.0};
    it->nodes[0] = (struct node){gain, -1, {4, 2}, {6, 0}, {8, 1}, {7}, 1};
    return it;
}

static double assembled_hits(struct careful *careful, double limit, double y) {
    struct assembled *it = careful->model;
    double *cells = it->cells, next = careful->start + (double)(careful->hits + 1) * careful->period;
    if (!(next <= limit)) return y;
    cells[0] = careful->value[INPUT];
    it->hits = careful->hits;
    it->from = careful->time;
    for (size_t i = 0; i < it->state.length; ++i) it->old_state[i] = cells[it->state.start + i];
    for (size_t i = 0; i < it->input_count; ++i) {
        const struct wire *wire = &it->inputs[i];
        it->old_inputs[i] = cells[wire->variable];
        cells[wire->signal] = cells[wire->variable] * wire->factor + wire->offset;
    }
    do {
        for (size_t n = 0; n < it->node_count; ++n) {
            const struct node *node = &it->nodes[n];
            if (node->enabled >= 0 && cells[node->enabled] == 0.0) {
                cells[node->outputs.start] = cells[node->inputs[0]];
                continue;
            }
            double inputs[8];
            for (size_t i = 0; i < node->input_count; ++i) inputs[i] = cells[node->inputs[i]];
            node->step(cells + node->coefficients.start, cells + node->state.start, careful->period,
                       inputs, cells + node->outputs.start);
        }
        ++careful->hits;
        next = careful->start + (double)(careful->hits + 1) * careful->period;
    } while (next <= limit);
    for (size_t i = 0; i < it->output_count; ++i) {
        const struct wire *wire = &it->outputs[i];
        it->old_outputs[i] = cells[wire->variable];
        cells[wire->variable] = (cells[wire->signal] - wire->offset) / wire->factor;
    }
    return cells[1];
}
