/* Arguments that no importer should pass, and some that it should. */
#ifndef FUZZ_H
#define FUZZ_H

#include "host.h"

enum { ROOM = 64 };

static uint64_t seed;
/* Number of variables: references from here on are unknown. */
static uint32_t variables;

static uint64_t any(uint64_t count) { return random_bits(&seed) % count; }
static int rarely(void) { return any(12) == 0; }

static double number(void) {
    static const double odd[] = {0.0, -0.0, NAN, INFINITY, -INFINITY, 1e308, -1e308, 5e-324, -1.0};
    return rarely() ? odd[any(sizeof odd / sizeof *odd)] : 5.0 * random_unit(&seed);
}

static uint32_t reference(void) {
    return rarely() ? (any(2) ? (uint32_t)random_bits(&seed) : variables) : (uint32_t)any(variables);
}

/* A length: of the room at most, or longer than any memory. */
static size_t length(void) {
    static const size_t huge[] = {SIZE_MAX, SIZE_MAX / 2 + 1, SIZE_MAX / 2, (size_t)1 << 62};
    return rarely() ? huge[any(4)] : rarely() ? ROOM : any(4);
}

/* The array, seldom a null pointer. */
#define MAYBE(array) (rarely() ? NULL : (array))

static const char *text(void) {
    static char endless[100001];
    static const char *const odd[] = {NULL, "", " ", "%s%n%d", "#1#", "\xff\xfe\x80", endless};
    if (!*endless) memset(endless, 'x', sizeof endless - 1);
    return odd[any(sizeof odd / sizeof *odd)];
}

/* Room for results and values, filled anew before each call. */
static uint32_t references_[ROOM];
static double numbers[ROOM], results[ROOM];
static int integers[ROOM];
static const char *texts[ROOM];

static void fill(void) {
    for (int k = 0; k < ROOM; ++k) {
        references_[k] = reference();
        numbers[k] = number();
        integers[k] = rarely() ? (int)random_bits(&seed) : (int)any(2);
        texts[k] = text();
    }
}

/* A time that is near the right one, or not; sizes that take long to compute are left out. */
static double size_of_step(double period) {
    static const double odd[] = {0.0, -1e-3, NAN, INFINITY, -INFINITY, 1e300, 5e-324, 1e-300};
    return rarely() ? odd[any(sizeof odd / sizeof *odd)] : period * 3.0 * random_unit(&seed);
}

/* FMU states of the instance that are not freed. */
enum { STATES = 3 };
static void *states[STATES];

#endif
