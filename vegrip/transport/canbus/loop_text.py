"""The loop of the bus in C, beside the text of the kernels: it waits, receives and sends.

It does what a step of :class:`~vegrip.transport.canbus.hub.Hub` does, with the kernels in place of the model:
after each sleep the caches are cold, and it is the size of what runs then that decides what a frame costs.
It leaves as soon as anything is out of the ordinary; Python deals with that.
"""

from typing import Final

from vegrip.transport.canbus.kernels import memory
from vegrip.transport.canbus.kernels.limits import GATHERED, LONGEST_SLEEP, NO_EVENT, SLICE, TRANSMIT_QUEUE
from vegrip.transport.canbus.leaving import Why

LOOP_FLAGS: Final = ("-D_GNU_SOURCE",)
"""Of the compiler: for ``ppoll`` and ``clock_nanosleep``."""


LOOP: Final = f"""
#include <errno.h>
#include <poll.h>
#include <sys/socket.h>
#include <time.h>

static int64_t vg_clock(void)
{{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}}

static struct timespec vg_span(int64_t ns)
{{
    return (struct timespec){{ns / 1000000000, ns % 1000000000}};
}}

/* Sends what is to be sent; false: a member does not read. */
static bool vg_send(int64_t *t, const uint8_t *d)
{{
    while (t[{memory.SENT}] < t[{memory.PACKETS}]) {{
        const int64_t *packet = t + {memory.TO_SEND} + t[{memory.SENT}] * {memory.PACKET_ENTRY};
        const int64_t *member = t + {memory.SLOTS} + packet[{memory.TO_SLOT}] * {memory.SLOT};
        const ssize_t sent = send((int)member[{memory.DESCRIPTOR}], d + packet[{memory.TO_SEND_AT}],
            (size_t)packet[{memory.TO_SEND_BYTES}], MSG_DONTWAIT | MSG_NOSIGNAL);
        if (sent < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) {{
            return false;
        }} /* else it was sent, or its member has gone; reading from it will show that */
        t[{memory.SENT}]++;
    }}
    t[{memory.SENT}] = t[{memory.PACKETS}] = t[{memory.BYTES_TO_SEND}] = 0;
    return true;
}}

static bool vg_is_read(const int64_t *t, int64_t slot)
{{
    return t[{memory.SLOTS} + slot * {memory.SLOT} + {memory.WAITING}] < {TRANSMIT_QUEUE};
}}

/* Reads all that a member has sent; returns why the loop must leave, or TIME. */
static int64_t vg_read(int64_t *t, uint8_t *d, int64_t slot)
{{
    while (vg_is_read(t, slot)) {{
        const int fd = (int)t[{memory.SLOTS} + slot * {memory.SLOT} + {memory.DESCRIPTOR}];
        const ssize_t length = recv(fd, d + {memory.RECEIVED}, {memory.LONGEST_PACKET},
            MSG_DONTWAIT | MSG_NOSIGNAL);
        if (length < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) {{
            break;
        }}
        t[{memory.WHO}] = slot;
        t[{memory.LENGTH}] = length;
        if (length <= 0) {{
            return {Why.GONE:d};
        }}
        if (!vg_take_packet(t, d, slot, length, vg_clock())) {{
            return {Why.OTHER_PACKET:d};
        }}
    }}
    return {Why.TIME:d};
}}

/* Waits for the frame on the bus, or for requests where there is none; false: a signal has come. */
static bool vg_wait(const int64_t *t, int64_t until, struct timespec *patience)
{{
    const int64_t now = vg_clock();
    int64_t event = vg_next_event(t);
    *patience = vg_span(0);
    if (event == {NO_EVENT}) {{
        const int64_t end = t[{memory.DUE}] < until ? t[{memory.DUE}] : until;
        *patience = vg_span(end > now ? end - now : 0);
        return true;
    }}
    event += t[{memory.QUEUED}] > 1 ? {GATHERED} : 0;
    if (event <= now) {{
        return true;
    }}
    const int64_t end = event < now + {LONGEST_SLEEP} ? event : now + {LONGEST_SLEEP};
    const struct timespec wake = vg_span(end);
    return clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, 0) == 0;
}}

static bool vg_advance_and_send(int64_t *t, uint8_t *d)
{{
    const int64_t now = vg_clock(), event = vg_next_event(t);
    const int64_t limit = event < now - {SLICE} ? event + {SLICE} : now;
    while (vg_advance(t, d, limit, now)) {{
        if (!vg_send(t, d)) {{
            return false;
        }}
    }}
    if (!vg_send(t, d)) {{
        return false;
    }}
    vg_hand_out(t, d, now);
    return vg_send(t, d);
}}

int64_t vg_loop(int64_t *t, uint8_t *d, int64_t until)
{{
    struct pollfd watched[{memory.MOST_SLOTS} + 1];
    const int64_t members = t[{memory.MEMBERS}];
    for (;;) {{
        struct timespec patience;
        if (!vg_wait(t, until, &patience)) {{
            return {Why.TIME:d};
        }}
        const int64_t now = vg_clock();
        vg_conclude(t, d, now);
        vg_hand_out(t, d, now);
        if (!vg_send(t, d)) {{
            return {Why.BEHIND:d};
        }}
        for (int64_t slot = 0; slot < members; slot++) {{
            const int fd = (int)t[{memory.SLOTS} + slot * {memory.SLOT} + {memory.DESCRIPTOR}];
            watched[slot] = (struct pollfd){{vg_is_read(t, slot) ? fd : -1, POLLIN, 0}};
        }}
        watched[members] = (struct pollfd){{(int)t[{memory.DOOR}], POLLIN, 0}};
        if (ppoll(watched, (nfds_t)members + 1, &patience, 0) < 0) {{
            return {Why.TIME:d};
        }}
        for (int64_t slot = 0; slot < members; slot++) {{
            const int64_t why = watched[slot].revents ? vg_read(t, d, slot) : {Why.TIME:d};
            if (why) {{
                return why;
            }}
        }}
        if (!vg_advance_and_send(t, d)) {{
            return {Why.BEHIND:d};
        }}
        if (watched[members].revents) {{
            return {Why.NEWCOMER:d};
        }}
        if (now >= until) {{
            return {Why.TIME:d};
        }}
    }}
}}
"""
"""``vg_loop(t, d, until)`` carries frames until the time ``until`` [ns], or until something else is asked."""
