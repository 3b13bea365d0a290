/* A machine of one axis in C: the position follows command / 12 with a lag of 5 ms.
 *
 *     cc -O2 -o peer peer.c && ./peer [PORT [SECONDS]]
 *
 * It speaks the packet of docs/gateway.md, listens to one peer, and stops itself without commands.
 * For a little-endian processor. */
#define _POSIX_C_SOURCE 200809L
#include <arpa/inet.h>
#include <poll.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { HEADER = 40, ENABLE = 1, POWERED = 1 << 8, VALID = 1 << 9, SAFE = 1 << 10 };
static const uint64_t HEARTBEAT = 100000000; /* ns without a command until the machine stops */

static uint64_t now_ns(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

/* CRC-32 of IEEE 802.3, as zlib's crc32. */
static uint32_t crc32(const uint8_t *bytes, size_t length) {
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < length; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

/* Offsets as in the table. memcpy, because the buffer need not be aligned. */
#define GET(to, bytes, offset) memcpy(&(to), (bytes) + (offset), sizeof(to))
#define PUT(bytes, offset, from) memcpy((bytes) + (offset), &(from), sizeof(from))

int main(int argc, char **argv) {
    uint16_t port = (uint16_t)(argc > 1 ? atoi(argv[1]) : 9000);
    double seconds = argc > 2 ? atof(argv[2]) : 1e9;
    struct sockaddr_in own = {.sin_family = AF_INET, .sin_port = htons(port)};
    own.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    struct sockaddr_in peer = own;
    peer.sin_port = htons((uint16_t)(port + 1));
    int link = socket(AF_INET, SOCK_DGRAM, 0);
    /* Connected: from now on nobody else is heard. */
    if (link < 0 || bind(link, (struct sockaddr *)&own, sizeof own) ||
        connect(link, (struct sockaddr *)&peer, sizeof peer)) {
        perror("peer");
        return 1;
    }
    printf("listening at udp://127.0.0.1:%u\n", port);
    fflush(stdout);

    double position = 0.0, applied = 0.0;
    int heard = 0, enabled = 0, stopped = 0;
    uint32_t sequence = 0, newest = 0;
    uint64_t echo_time = 0, begin = now_ns(), last_command = begin, last_step = begin;
    while ((double)(now_ns() - begin) < seconds * 1e9) {
        uint8_t in[2048], out[HEADER + 8 + 4] = {0};
        struct pollfd wait = {.fd = link, .events = POLLIN};
        poll(&wait, 1, 10);
        ssize_t length = recv(link, in, sizeof in, MSG_DONTWAIT);
        uint64_t now = now_ns();
        uint32_t checksum, number, status;
        uint16_t channels;
        if (length == HEADER + 8 + 4) {
            GET(checksum, in, HEADER + 8);
            GET(channels, in, 6);
            GET(number, in, 8);
            GET(status, in, 12);
            if (checksum == crc32(in, HEADER + 8) && !memcmp(in, "PZLB\1\1", 6) && channels == 1 &&
                (!heard || (int32_t)(number - newest) > 0)) {
                heard = 1;
                newest = number;
                last_command = now;
                enabled = (status & ENABLE) != 0;
                stopped = stopped && enabled;
                GET(echo_time, in, 16);
                GET(applied, in, HEADER);
                if (!enabled || stopped) applied = 0.0;
            }
        }
        if (enabled && now - last_command > HEARTBEAT) {
            stopped = 1;
            applied = 0.0;
        }
        double part = (double)(now - last_step) / 5e6;
        position += (applied / 12 - position) * (part < 1.0 ? part : 1.0);
        last_step = now;
        if (!heard) continue;
        uint16_t one = 1;
        status = POWERED | VALID | (stopped ? SAFE : 0);
        sequence++;
        memcpy(out, "PZLB\1\2", 6);
        PUT(out, 6, one);
        PUT(out, 8, sequence);
        PUT(out, 12, status);
        PUT(out, 16, now);
        PUT(out, 24, newest);
        PUT(out, 32, echo_time);
        PUT(out, HEADER, position);
        checksum = crc32(out, HEADER + 8);
        PUT(out, HEADER + 8, checksum);
        (void)!send(link, out, sizeof out, 0);
    }
    close(link);
    return 0;
}
