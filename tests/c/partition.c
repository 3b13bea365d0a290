/* Steps with inputs held over a coarse interval, once in one step and many times in random
   partitions of it: at the ends of the intervals the outputs must agree in every bit. */
#include "host.h"

enum { INTERVALS = 40, PARTITIONS = 60, CUTS = 30 };

static struct given given;
static struct library fmu;

static void inputs_of(int interval, double *values) { wave(&given, 0.003 * interval, values); }

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Points inside the interval, ascending: anywhere, on a hit of the internal grid, or beside one by
   what floating point loses. */
static int cut(uint64_t *seed, double begin, double end, double *points) {
    int count = (int)(random_bits(seed) % (CUTS + 1)), kept = 0;
    for (int k = 0; k < count; ++k) {
        double point = begin + random_unit(seed) * (end - begin);
        if (random_bits(seed) % 2) {
            point = given.period * round(point / given.period);
            if (random_bits(seed) % 2)
                point = nextafter(point, random_bits(seed) % 2 ? begin : end);
        }
        points[k] = point;
    }
    qsort(points, (size_t)count, sizeof *points, ascending);
    for (int k = 0; k < count; ++k) {
        /* Steps shorter than the least the FMU can tell from rounding are no steps. */
        double last = kept ? points[kept - 1] : begin;
        if (points[k] - last > 1e-6 * given.period && end - points[k] > 1e-6 * given.period)
            points[kept++] = points[k];
    }
    return kept;
}

int main(int argc, char **argv) {
    given = given_by(argc, argv);
    CHECK(argc == 9, "give the coarse step in periods and a seed");
    double coarse = strtod(argv[7], NULL) * given.period;
    uint64_t seed = strtoull(argv[8], NULL, 10);
    fmu = load(given.library, RTLD_NOW | RTLD_LOCAL);
    double whole[INTERVALS][MOST], inputs[MOST], outputs[MOST], points[CUTS];
    fmi2Component c = started(&fmu, &given, 0.0);
    for (int k = 0; k < INTERVALS; ++k) {
        inputs_of(k, inputs);
        set(&fmu, c, &given, inputs);
        step(&fmu, c, k * coarse, coarse);
        get(&fmu, c, &given, whole[k]);
    }
    CHECK(!same_bits(whole[0], whole[1], given.outputs), "the outputs move");
    long steps = 0;
    for (int partition = 0; partition < PARTITIONS; ++partition) {
        CHECK(fmu.Reset(c) == fmi2OK, "%s", last_message);
        start(&fmu, c, 0.0);
        for (int k = 0; k < INTERVALS; ++k) {
            double time = k * coarse, end = (k + 1) * coarse;
            int count = cut(&seed, time, end, points);
            inputs_of(k, inputs);
            set(&fmu, c, &given, inputs);
            for (int at = 0; at <= count; ++at, ++steps) {
                double next = at < count ? points[at] : end;
                step(&fmu, c, time, next - time);
                time = next;
            }
            get(&fmu, c, &given, outputs);
            CHECK(same_bits(outputs, whole[k], given.outputs),
                  "partition %d, interval %d (%d cuts): %.17g, not %.17g", partition, k, count,
                  outputs[0], whole[k][0]);
        }
    }
    fmu.FreeInstance(c);
    printf("coarse step %g periods: %d partitions, %ld steps, bit-identical\n",
           coarse / given.period, PARTITIONS, steps);
    return 0;
}
