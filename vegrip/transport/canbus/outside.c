/* What the bus needs of its surroundings: clock, connections, bytes; outside.py has the same for Python. */
#include <errno.h>
#include <poll.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>

static inline int64_t vg_nearest(double value)
{
    return (int64_t)rint(value);
}

static inline void vg_copy_bytes(uint8_t *to, int64_t place, const uint8_t *source, int64_t begin, int64_t size)
{
    memcpy(to + place, source + begin, (size_t)size);
}

static inline void vg_store(uint8_t *to, int64_t place, int64_t value, int64_t size)
{
    for (int64_t i = 0; i < size; i++) {
        to[place + i] = (uint8_t)((uint64_t)value >> 8 * i);
    }
}

static inline int64_t vg_load(const uint8_t *source, int64_t begin, int64_t size)
{
    int64_t value = 0;
    for (int64_t i = size - 1; i >= 0; i--) {
        value = value << 8 | source[begin + i];
    }
    return value;
}

static int64_t vg_clock(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

static struct timespec vg_span(int64_t ns)
{
    return (struct timespec){ns / 1000000000, ns % 1000000000};
}

static bool vg_sleep_until(int64_t end)
{
    const struct timespec wake = vg_span(end);
    return clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, NULL) == 0;
}

static bool vg_look(const int64_t *watched, int64_t *ready, int64_t count, int64_t patience)
{
    struct pollfd all[VG_MOST_WATCHED];
    const struct timespec span = vg_span(patience);
    for (int64_t i = 0; i < count; i++) {
        all[i] = (struct pollfd){(int)watched[i], POLLIN, 0};
    }
    if (ppoll(all, (nfds_t)count, &span, NULL) < 0) {
        return false;
    }
    for (int64_t i = 0; i < count; i++) {
        ready[i] = all[i].revents != 0;
    }
    return true;
}

static bool vg_would_block(void)
{
    return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
}

static int64_t vg_receive(int64_t descriptor, uint8_t *to, int64_t room)
{
    const ssize_t length = recv((int)descriptor, to, (size_t)room, MSG_DONTWAIT);
    if (length < 0) {
        return vg_would_block() ? -1 : 0;
    }
    return (int64_t)length;
}

static bool vg_send(int64_t descriptor, const uint8_t *source, int64_t begin, int64_t size)
{
    /* else it was sent, or its member has gone; reading from it will show that */
    return !(send((int)descriptor, source + begin, (size_t)size, MSG_DONTWAIT | MSG_NOSIGNAL) < 0
        && vg_would_block());
}
