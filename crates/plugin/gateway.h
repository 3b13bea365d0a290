/* gateway.h: your driver as the machine of `piezoloop bench run`. Version 1.
 *
 * A shared library with the six functions below is a gateway:
 *
 *     cc -shared -fPIC -O2 -o libmycard.so mycard.c
 *     piezoloop bench run controller.fmu --gateway 'plugin://./libmycard.so?options' --rate 1k ...
 *
 * All are called from one thread of their own, not from the cycle: they may block and allocate. open, describe and close are called
 * once, exchange once per cycle. No exception may leave them; a library that crashes takes the program with it (its journal stays:
 * `piezoloop bench recover`).
 */
#ifndef PIEZOLOOP_GATEWAY_H
#define PIEZOLOOP_GATEWAY_H

#include <stdint.h>

#define PIEZOLOOP_GATEWAY_VERSION 1u

#if defined(_WIN32)
#define PIEZOLOOP_GATEWAY_EXPORT __declspec(dllexport)
#else
#define PIEZOLOOP_GATEWAY_EXPORT __attribute__((visibility("default")))
#endif

/* What exchange returns. */
#define PIEZOLOOP_GATEWAY_GOOD 0
#define PIEZOLOOP_GATEWAY_NO_SAMPLE 1 /* nothing was measured this time: counted as lost */
/* anything else: an error; its text is asked for, the sample is not valid, the run goes to its safe state */

/* Bits of the status of a sample. Without POWERED the runner waits, or ends with "power lost". */
#define PIEZOLOOP_GATEWAY_VALID 1u
#define PIEZOLOOP_GATEWAY_POWERED 2u

#ifdef __cplusplus
extern "C" {
#endif

/* PIEZOLOOP_GATEWAY_VERSION of the header it was built with. Called first. */
PIEZOLOOP_GATEWAY_EXPORT uint32_t piezoloop_gateway_version(void);

/* Opens the card. options: what stands behind `?`, or "". channels: commands and positions per exchange, 1 to 128. period: of a
 * cycle, s. *card: yours, handed to all others; NULL is allowed. 0: good; else last_error(NULL) says why, and close is not called. */
PIEZOLOOP_GATEWAY_EXPORT int32_t piezoloop_gateway_open(const char *options, uint32_t channels, double period, void **card);

/* Writes a sentence on what was opened (model, serial number, ranges), at most size bytes with its zero. It is shown and recorded. 0: good. */
PIEZOLOOP_GATEWAY_EXPORT int32_t piezoloop_gateway_describe(void *card, char *text, uint32_t size);

/* Commands out, positions in, in the units of the FMU's variables. enable 0: the runner does not drive; commands are then those of the
 * safe state, and outputs should rest there (or be switched off). The same comes after 0.1 s without a cycle, and last of all.
 * All `channels` positions must be written, and *count set to how many were; *status: the bits above. */
PIEZOLOOP_GATEWAY_EXPORT int32_t piezoloop_gateway_exchange(void *card, uint32_t enable, const double *commands, double *positions,
                                                            uint32_t *count, uint32_t *status);

/* A sentence on the newest error; NULL or "" if there is none. It must stay until the next call. card is NULL after a failed open. */
PIEZOLOOP_GATEWAY_EXPORT const char *piezoloop_gateway_last_error(void *card);

/* Leaves the outputs safe and releases everything. */
PIEZOLOOP_GATEWAY_EXPORT void piezoloop_gateway_close(void *card);

#ifdef __cplusplus
}
#endif
#endif
