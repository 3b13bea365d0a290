/* NI-DAQmx as a gateway: analog outputs are the commands, analog inputs the positions, one sample of each per cycle, timed by software.
 *
 *     piezoloop bench header > gateway.h
 *     cc -shared -fPIC -O2 -o libnidaqmx_card.so nidaqmx.c -lnidaqmx
 *     piezoloop bench run controller.fmu --rate 1k --gateway \
 *         'plugin://./libnidaqmx_card.so?ao=Dev1/ao0:1 ai=Dev1/ai0:1 range=10 amplifier=15 um_per_volt=2.5'
 *
 * amplifier: commands in V of the piezo divided by it are the card's volts. um_per_volt: positions. Checked against a stub of the header;
 * not tried on a card. */
#include "gateway.h"

#include <NIDAQmx.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    TaskHandle out, in;
    uint32_t channels;
    double amplifier, um_per_volt, timeout;
    char ao[128], ai[128], error[1024];
} Card;

static char open_error[1024];

/* The value of `name=value` among words that blanks separate. */
static void option(const char *options, const char *name, char *value, size_t size) {
    size_t length = strlen(name);
    for (const char *at = options; at && *at; at = strchr(at, ' ')) {
        at += strspn(at, " ");
        if (strncmp(at, name, length) == 0 && at[length] == '=')
            snprintf(value, size, "%.*s", (int)strcspn(at + length + 1, " "), at + length + 1);
    }
}

static double number(const char *options, const char *name, double otherwise) {
    char text[64] = "";
    option(options, name, text, sizeof text);
    return text[0] ? strtod(text, NULL) : otherwise;
}

/* NI's codes: below 0 errors, above 0 warnings. */
static int bad(int32 code, char *text, size_t size) {
    if (code < 0) DAQmxGetExtendedErrorInfo(text, (uInt32)size);
    return code < 0;
}

static void release(Card *card) {
    if (card->out) DAQmxStopTask(card->out), DAQmxClearTask(card->out);
    if (card->in) DAQmxStopTask(card->in), DAQmxClearTask(card->in);
    free(card);
}

uint32_t piezoloop_gateway_version(void) { return PIEZOLOOP_GATEWAY_VERSION; }

int32_t piezoloop_gateway_open(const char *options, uint32_t channels, double period, void **out) {
    Card *card = calloc(1, sizeof *card);
    if (!card) return 2;
    strcpy(card->ao, "Dev1/ao0");
    strcpy(card->ai, "Dev1/ai0");
    option(options, "ao", card->ao, sizeof card->ao);
    option(options, "ai", card->ai, sizeof card->ai);
    double range = number(options, "range", 10.0);
    card->amplifier = number(options, "amplifier", 1.0);
    card->um_per_volt = number(options, "um_per_volt", 1.0);
    card->channels = channels;
    card->timeout = period > 0.01 ? period : 0.01;
    uInt32 outs = 0, ins = 0;
    if (bad(DAQmxCreateTask("", &card->out), open_error, sizeof open_error) ||
        bad(DAQmxCreateTask("", &card->in), open_error, sizeof open_error) ||
        bad(DAQmxCreateAOVoltageChan(card->out, card->ao, "", -range, range, DAQmx_Val_Volts, NULL), open_error, sizeof open_error) ||
        bad(DAQmxCreateAIVoltageChan(card->in, card->ai, "", DAQmx_Val_Cfg_Default, -range, range, DAQmx_Val_Volts, NULL), open_error,
            sizeof open_error) ||
        bad(DAQmxGetTaskNumChans(card->out, &outs), open_error, sizeof open_error) ||
        bad(DAQmxGetTaskNumChans(card->in, &ins), open_error, sizeof open_error)) {
        release(card);
        return 3;
    }
    if (outs != channels || ins != channels || card->amplifier == 0.0) {
        snprintf(open_error, sizeof open_error, "%s has %u outputs, %s %u inputs, the run %u channels; amplifier must not be 0", card->ao,
                 (unsigned)outs, card->ai, (unsigned)ins, (unsigned)channels);
        release(card);
        return 4;
    }
    if (bad(DAQmxStartTask(card->out), open_error, sizeof open_error) || bad(DAQmxStartTask(card->in), open_error, sizeof open_error)) {
        release(card);
        return 5;
    }
    *out = card;
    return 0;
}

int32_t piezoloop_gateway_describe(void *handle, char *text, uint32_t size) {
    Card *card = handle;
    snprintf(text, size, "NI-DAQmx: %s, %s; amplifier %g, %g um/V", card->ao, card->ai, card->amplifier, card->um_per_volt);
    return 0;
}

int32_t piezoloop_gateway_exchange(void *handle, uint32_t enable, const double *commands, double *positions, uint32_t *count,
                                   uint32_t *status) {
    Card *card = handle;
    float64 volts[128];
    int32 written = 0, read = 0;
    (void)enable; /* without it the commands are those of the safe state */
    for (uint32_t i = 0; i < card->channels; i++) volts[i] = commands[i] / card->amplifier;
    if (bad(DAQmxWriteAnalogF64(card->out, 1, 0, card->timeout, DAQmx_Val_GroupByChannel, volts, &written, NULL), card->error,
            sizeof card->error) ||
        bad(DAQmxReadAnalogF64(card->in, 1, card->timeout, DAQmx_Val_GroupByChannel, volts, card->channels, &read, NULL), card->error,
            sizeof card->error))
        return 6;
    if (written != 1 || read != 1) return PIEZOLOOP_GATEWAY_NO_SAMPLE;
    for (uint32_t i = 0; i < card->channels; i++) positions[i] = volts[i] * card->um_per_volt;
    *count = card->channels;
    *status = PIEZOLOOP_GATEWAY_VALID | PIEZOLOOP_GATEWAY_POWERED;
    return PIEZOLOOP_GATEWAY_GOOD;
}

const char *piezoloop_gateway_last_error(void *handle) {
    Card *card = handle;
    return card ? card->error : open_error;
}

void piezoloop_gateway_close(void *handle) { release(handle); }
