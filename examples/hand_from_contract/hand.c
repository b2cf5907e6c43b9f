/* A hand in C, from proto/README.md alone: finger 0 of hand 0 in the classic CAN layout, 200 states a second. It serves
   its bus as socketcand does (TCP, loopback); on a board the two lines marked (bus) send and receive a frame.
   cc -O2 hand.c -o hand && ./hand 28600 5      port, seconds after the first command */
#include <arpa/inet.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>
static double obeyed, until; /* the force in force [N], and till when */
static int commands, greeted;
static double now(clockid_t id) { struct timespec t; clock_gettime(id, &t); return t.tv_sec + 1e-9 * t.tv_nsec; }
static double noise(void) { return 0.001 * (rand() % 21 - 10); } /* [N] */
static void put(uint8_t *at, double newtons) { int16_t mn = newtons * 1000; at[0] = mn & 0xFF; at[1] = mn >> 8 & 0xFF; }
static uint8_t crc8(unsigned id, const uint8_t *frame) { /* E2E profile 11: ID, low byte first, then bytes 1..7 */
    uint8_t bytes[9] = {id & 0xFF, id >> 8}, crc = 0;
    memcpy(bytes + 2, frame + 1, 7);
    for (int i = 0; i < 9; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++) crc = crc << 1 ^ (crc & 0x80 ? 0x1D : 0);
    }
    return crc;
}
static void send_state(int bus, unsigned counter, double normal, double x) {
    uint8_t f[8] = {0, counter % 15 | 1 << 4 | 1 << 7}; /* version 1; last: no part follows, nothing else is measured */
    put(f + 2, normal), put(f + 4, x), put(f + 6, noise());
    f[0] = crc8(0x100, f);
    dprintf(bus, "< frame 100 %.6f ", now(CLOCK_REALTIME)); /* (bus) */
    for (int i = 0; i < 8; i++) dprintf(bus, "%02x%s", f[i], i < 7 ? "" : " >");
}
static void hear(const char *text) { /* "< send 040 8 a b c d e f g h >" */
    unsigned id, b[8];
    uint8_t f[8];
    const char *form = "< send %x 8 %x %x %x %x %x %x %x %x >";
    if (sscanf(text, form, &id, b, b + 1, b + 2, b + 3, b + 4, b + 5, b + 6, b + 7) != 9) return;
    for (int i = 0; i < 8; i++) f[i] = b[i];
    int16_t mn = f[2] | f[3] << 8;
    if (id != 0x040 || f[0] != crc8(id, f) || (f[1] >> 4 & 7) != 1 || mn < 0) return;
    obeyed = 0.001 * mn, until = now(CLOCK_MONOTONIC) + 0.002 * f[7], commands++;
}
int main(int argc, char **argv) {
    struct sockaddr_in at = {.sin_family = AF_INET, .sin_port = htons(argc > 2 ? atoi(argv[1]) : 0)};
    int door = socket(AF_INET, SOCK_STREAM, 0), bus = -1;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (argc < 3 || bind(door, (void *)&at, sizeof at) || listen(door, 1) || (bus = accept(door, 0, 0)) < 0) return 1;
    char text[4096];
    double grip = 1.5, end = now(CLOCK_MONOTONIC) + 60;
    dprintf(bus, "< hi >");
    for (unsigned n = 0, first = 1, ready = 0; now(CLOCK_MONOTONIC) < end; n++) {
        ssize_t got = recv(bus, text, sizeof text - 1, MSG_DONTWAIT); /* (bus) */
        if (got == 0) break;
        text[got > 0 ? got : 0] = 0;
        for (char *p = text; (p = strchr(p, '<')); p++)
            if (strncmp(p, "< send", 6)) dprintf(bus, "< ok >"), greeted++, ready = n + 40; else hear(p);
        if (commands && first) first = 0, end = now(CLOCK_MONOTONIC) + atof(argv[2]);
        grip += 0.2 * ((now(CLOCK_MONOTONIC) < until ? obeyed : grip) - grip); /* no command in force: hold as it is */
        if (greeted > 1 && n > ready) send_state(bus, n, grip + noise(), 0.5 + noise()); /* it carries 0.5 N */
        usleep(5000);
    }
    return printf("{\"commands\": %d, \"grip\": %.3f}\n", commands, grip) < 0;
}
