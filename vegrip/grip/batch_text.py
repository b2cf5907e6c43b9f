"""What goes through the rows of a batch in C, beside the text of the kernels.

Pointers to pointers are the one thing that the kernels have no words for. :mod:`vegrip.grip.compiled_batch`
calls these functions, and does the same in Python where C does not run.
"""

import ctypes
from typing import Final

from vegrip.grip.layout import FingerLayout
from vegrip.transport.codec.batch_codec import FIRST_ROW, ROW_ID, ROW_STRIDE

COMMANDED: Final = 2
"""Bit of a step after which a command was packed."""
STATE_BYTES: Final = 48
COMMAND_BYTES: Final = 24
REPORT_BYTES: Final = (64, 64, 48)
"""Of the frames of a report: both of a contact, and that of a slip margin."""
COMMAND_ROW: Final = ROW_ID.size + COMMAND_BYTES
CONTACT_ROW: Final = ROW_ID.size + REPORT_BYTES[0]
MARGIN_ROW: Final = ROW_ID.size + REPORT_BYTES[2]

_POINTER, _WHOLE = ctypes.c_void_p, ctypes.c_int64
STEP_ARGUMENTS: Final = (
    *[_POINTER] * 3, *[_WHOLE] * 5, ctypes.c_char_p, *[_WHOLE] * 3, *[_POINTER] * 2,
)  # fmt: skip
REPORT_ARGUMENTS: Final = (_POINTER, _POINTER, ctypes.c_char_p, _WHOLE, _WHOLE, *[_POINTER] * 3)

STEP: Final = f"""
int64_t vg_batch_step(double *const *f, int64_t *const *t, double *g, int64_t places, int64_t state_row,
    int64_t state_base, int64_t command_row, int64_t command_base, const uint8_t *payload, int64_t rows,
    int64_t arrival, int64_t now, uint8_t *answers, uint8_t *done)
{{
    int64_t commands = 0;
    for (int64_t i = 0; i < rows; i++) {{
        const uint8_t *row = payload + {FIRST_ROW} + i * state_row;
        const int64_t id = row[0] + 256 * row[1], n = id / {ROW_STRIDE} - 1;
        uint8_t *answer = answers + commands * command_row;
        done[i] = 0;
        if (n < 0 || n >= places || f[n] == 0 || id % {ROW_STRIDE} != state_base) {{
            continue;
        }}
        done[i] = (uint8_t)vg_finger_step(f[n], t[n], g, row + {ROW_ID.size}, state_row - {ROW_ID.size},
            arrival, now, answer + {ROW_ID.size});
        if (done[i] & {COMMANDED}) {{
            answer[0] = (uint8_t)((command_base + (n + 1) * {ROW_STRIDE}) & 255);
            answer[1] = (uint8_t)((command_base + (n + 1) * {ROW_STRIDE}) >> 8);
            commands++;
        }}
    }}
    return commands;
}}
"""
"""Answers the rows of states; returns how many commands there are."""

REPORT: Final = f"""
static void row_id(uint8_t *row, int64_t id)
{{
    row[0] = (uint8_t)(id & 255);
    row[1] = (uint8_t)(id >> 8);
}}

void vg_batch_report(double *const *f, int64_t *const *t, const uint8_t *numbers, int64_t count, int64_t now,
    uint8_t *contacts, uint8_t *margins, uint8_t *reported)
{{
    for (int64_t i = 0; i < count; i++) {{
        const int64_t n = numbers[i];
        uint8_t *second = contacts + {CONTACT_ROW};
        reported[i] = (uint8_t)vg_finger_report(f[n], t[n], now, contacts + {ROW_ID.size},
            second + {ROW_ID.size}, margins + {ROW_ID.size});
        if (reported[i]) {{
            row_id(contacts, t[n][CONTACT1_ID]);
            row_id(second, t[n][CONTACT2_ID]);
            row_id(margins, t[n][MARGIN_ID]);
            contacts += 2 * {CONTACT_ROW};
            margins += {MARGIN_ROW};
        }}
    }}
}}
"""
"""Packs the rows of contacts and slip margins of fingers by their numbers, where they are due."""


def batch_text(finger: FingerLayout) -> str:
    """Return both functions for fingers of a layout, and above them where identifiers lie."""
    names = ("COMMAND_ID", "CONTACT1_ID", "CONTACT2_ID", "MARGIN_ID")
    places = "".join(f"#define {name} {finger.wholes[f'SETUP_{name}']}\n" for name in names)
    return f"{places}{STEP}{REPORT}"
