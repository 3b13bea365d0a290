/* A fake card whose registers are a file: n outputs, then n inputs, as doubles of this computer. Each output is wired to its input
 * through a stage of 0.1 um/V that needs 3 ms. Build and run:
 *
 *     piezoloop bench header > gateway.h
 *     cc -shared -fPIC -O2 -o libcard.so card.c
 *     piezoloop bench run --plan plan.toml --gateway 'plugin://./libcard.so?registers.bin' --rate 1k
 *
 * Replace the lines marked HERE by calls of your driver (nidaqmx.c does that for NI-DAQmx). */
#include "gateway.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    FILE *file;
    uint32_t channels;
    double period;
    char path[256];
    double x[128];
    char error[320];
} Card;

/* Why open failed: there is no card then. */
static char open_error[320];

uint32_t piezoloop_gateway_version(void) { return PIEZOLOOP_GATEWAY_VERSION; }

int32_t piezoloop_gateway_open(const char *options, uint32_t channels, double period, void **out) {
    const char *path = options[0] ? options : "registers.bin";
    Card *card = calloc(1, sizeof *card);
    if (!card || channels > 128 || strlen(path) >= sizeof card->path) {
        snprintf(open_error, sizeof open_error, "no memory, more than 128 channels, or too long a name");
        free(card);
        return 2;
    }
    card->channels = channels;
    card->period = period;
    strcpy(card->path, path);
    card->file = fopen(path, "w+b"); /* HERE: open the device */
    if (!card->file) {
        snprintf(open_error, sizeof open_error, "%s: %s", path, strerror(errno));
        free(card);
        return 3;
    }
    *out = card;
    return 0;
}

int32_t piezoloop_gateway_describe(void *handle, char *text, uint32_t size) {
    Card *card = handle;
    snprintf(text, size, "fake card with %u channels in %s", (unsigned)card->channels, card->path);
    return 0;
}

static int32_t failed(Card *card, const char *what) {
    snprintf(card->error, sizeof card->error, "%s: cannot be %s: %s", card->path, what, strerror(errno));
    return 4;
}

int32_t piezoloop_gateway_exchange(void *handle, uint32_t enable, const double *commands, double *positions, uint32_t *count,
                                   uint32_t *status) {
    Card *card = handle;
    uint32_t n = card->channels;
    (void)enable; /* without it the commands are those of the safe state: they are written as well */
    for (uint32_t i = 0; i < n; i++) /* the stage behind the card */
        card->x[i] += (0.1 * commands[i] - card->x[i]) * (card->period / (3e-3 + card->period));
    /* HERE: write the outputs */
    rewind(card->file);
    if (fwrite(commands, sizeof *commands, n, card->file) != n || fwrite(card->x, sizeof *card->x, n, card->file) != n ||
        fflush(card->file))
        return failed(card, "written");
    /* HERE: read the inputs */
    if (fseek(card->file, (long)(n * sizeof *positions), SEEK_SET) || fread(positions, sizeof *positions, n, card->file) != n)
        return failed(card, "read");
    *count = n;
    *status = PIEZOLOOP_GATEWAY_VALID | PIEZOLOOP_GATEWAY_POWERED;
    return PIEZOLOOP_GATEWAY_GOOD;
}

const char *piezoloop_gateway_last_error(void *handle) {
    Card *card = handle;
    return card ? card->error : open_error;
}

void piezoloop_gateway_close(void *handle) {
    Card *card = handle;
    fclose(card->file); /* HERE: close the device; the last exchange was one without enable */
    free(card);
}
