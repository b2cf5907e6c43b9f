"""What goes through the frames of a packet of the virtual bus in C, beside the text of the kernels.

A packet brings several frames that have ended together. Each state in it is answered as the frame alone would
be, and the commands leave in one packet, too. :mod:`vegrip.grip.compiled_packet` calls these functions; where
C does not run, frames are answered one by one.
"""

import ctypes
from typing import Final

from vegrip.grip.batch_text import COMMAND_BYTES, COMMANDED, REPORT_BYTES
from vegrip.transport.canbus.frame_time import FD_SIZES
from vegrip.transport.canbus.hub_wire import DELIVERY_AT, MOST_REQUESTS, PLAIN_FLAGS, RATE_SWITCH, REQUEST_AT

MOST_FINGERS: Final = 62
"""Whose states one packet may bring: a bit of a number each."""
IDENTIFIERS: Final = 2048
RESULTS_FIRST: Final = 8
"""Where the results of states begin: finger, bits of the step, arrival of each; before them the packet's."""
REQUEST_BYTES: Final = tuple(REQUEST_AT["data"] + size for size in REPORT_BYTES)
RESULTS_SIZE: Final = RESULTS_FIRST + 3 * MOST_REQUESTS
ANSWER_BYTES: Final = MOST_REQUESTS * (REQUEST_AT["data"] + COMMAND_BYTES)

_POINTER, _WHOLE = ctypes.c_void_p, ctypes.c_int64
STEP_ARGUMENTS: Final = (*[_POINTER] * 4, ctypes.c_char_p, *[_WHOLE] * 3, *[_POINTER] * 2)
REPORT_ARGUMENTS: Final = (_POINTER, _POINTER, _WHOLE, _POINTER)

WORDS: Final = f"""
static const uint8_t packet_sizes[16] = {{{", ".join(map(str, FD_SIZES))}}};

static int64_t packet_word(const uint8_t *at, int bytes)
{{
    uint64_t word = 0;
    for (int i = bytes - 1; i >= 0; i--) {{
        word = word << 8 | at[i];
    }}
    return (int64_t)word;
}}

static void packet_request(uint8_t *at, int64_t now, int64_t id, uint8_t code)
{{
    for (int i = 0; i < 8; i++) {{
        at[{REQUEST_AT["time"]} + i] = (uint8_t)((uint64_t)now >> 8 * i);
    }}
    for (int i = 0; i < 4; i++) {{
        at[{REQUEST_AT["identifier"]} + i] = (uint8_t)((uint64_t)id >> 8 * i);
    }}
    at[{REQUEST_AT["flags"]}] = {PLAIN_FLAGS};
    at[{REQUEST_AT["code"]}] = code;
}}
"""

STEP: Final = f"""
int64_t vg_packet_step(double *const *f, int64_t *const *t, double *g, const uint8_t *fingers,
    const uint8_t *packet, int64_t length, int64_t expected, int64_t now, uint8_t *requests, int64_t *results)
{{
    int64_t at = 0, states = 0, commands = 0, lost = 0, seen = 0, last = 0;
    uint8_t *request = requests;
    while (length - at >= {DELIVERY_AT["data"]} && states < {MOST_REQUESTS}) {{
        const uint8_t *one = packet + at, *data = one + {DELIVERY_AT["data"]};
        const int64_t id = packet_word(one + {DELIVERY_AT["identifier"]}, 4);
        const int flags = one[{DELIVERY_AT["flags"]}], code = one[{DELIVERY_AT["code"]}];
        if ((flags | {RATE_SWITCH}) != {PLAIN_FLAGS} || code > 15) {{
            break;
        }}
        if (id >= {IDENTIFIERS} || fingers[id] == 0) {{
            break;
        }}
        const int64_t size = packet_sizes[code], n = fingers[id] - 1;
        if (length - at - {DELIVERY_AT["data"]} < size || (seen >> n & 1) != 0) {{
            break;
        }}
        const int64_t end = packet_word(one + {DELIVERY_AT["end"]}, 8);
        const int done = (int)vg_finger_step(f[n], t[n], g, data, size, end, now,
            request + {REQUEST_AT["data"]});
        if (done == 0) {{
            break;
        }}
        if (done & {COMMANDED}) {{
            packet_request(request, now, t[n][COMMAND_ID], {FD_SIZES.index(COMMAND_BYTES)});
            request += {REQUEST_AT["data"] + COMMAND_BYTES};
            commands++;
        }}
        const int64_t number = packet_word(one + {DELIVERY_AT["number"]}, 4);
        lost += (number - expected) & 0xFFFFFFFF;
        expected = (number + 1) & 0xFFFFFFFF;
        seen |= (int64_t)1 << n;
        results[{RESULTS_FIRST} + 3 * states] = n;
        results[{RESULTS_FIRST} + 3 * states + 1] = done;
        results[{RESULTS_FIRST} + 3 * states + 2] = end;
        states++;
        last = at;
        at += {DELIVERY_AT["data"]} + size;
    }}
    results[0] = at;
    results[1] = lost;
    results[2] = expected;
    results[3] = packet_word(packet + last + {DELIVERY_AT["end"]}, 8);
    results[4] = packet_word(packet + last + {DELIVERY_AT["busy"]}, 8);
    results[5] = commands;
    results[6] = request - requests;
    return states;
}}
"""
"""Answers the states at the beginning of a packet, as far as each is of another finger; returns how many."""

REPORT: Final = f"""
int vg_packet_report(double *f, int64_t *t, int64_t now, uint8_t *requests)
{{
    uint8_t *first = requests, *second = first + {REQUEST_BYTES[0]}, *margin = second + {REQUEST_BYTES[1]};
    if (!vg_finger_report(f, t, now, first + {REQUEST_AT["data"]}, second + {REQUEST_AT["data"]},
        margin + {REQUEST_AT["data"]})) {{
        return 0;
    }}
    packet_request(first, now, t[CONTACT1_ID], {FD_SIZES.index(REPORT_BYTES[0])});
    packet_request(second, now, t[CONTACT2_ID], {FD_SIZES.index(REPORT_BYTES[1])});
    packet_request(margin, now, t[MARGIN_ID], {FD_SIZES.index(REPORT_BYTES[2])});
    return 1;
}}
"""
"""Packs contact and slip margin of a finger where they are due; returns whether they were."""

PACKET_TEXT: Final = f"{WORDS}{STEP}{REPORT}"
"""All of it; the places of identifiers are defined above it, see :mod:`vegrip.grip.batch_text`."""
