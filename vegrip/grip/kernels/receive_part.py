"""A state in several classic frames: each is checked and kept, and the last one completes the state.

As :mod:`vegrip.transport.codec.assembly` has it, as far as everything comes in order; else nothing changes.
"""

from vegrip.estimator.elapsed import bounded_time, elapsed_time
from vegrip.grip.kernels.generated import *
from vegrip.grip.kernels.part_protection import is_part_intact
from vegrip.grip.kernels.receive import SILENT

PART_WINDOW = 5_000_000  # [ns] see assembly.WINDOW_NS
RING = 15  # counters of profile 11
PART_HEAD = 2  # bytes before the values


def is_part_welcome(t: Wholes, frame: Bytes, part: int, arrival: int) -> bool:
    """Return whether part number ``part`` is whole and the next one."""
    data_id = t.setup.state_id + int(PART_OFFSETS[part - 1])
    if not is_part_intact(frame, PART_LENGTH, data_id) or version_of_part(frame) != PART_VERSION:
        return False
    return part_means_something(frame, part) and is_next_part(t, counter_of_part(frame), part, arrival)


def is_next_part(t: Wholes, counter: int, part: int, arrival: int) -> bool:
    """Return whether a first part begins the next state, or another one goes on with the open one."""
    if part == 1:
        return t.line.last < 0 or is_next_in_ring(t, counter, arrival)
    expected = counter == t.parts.counter and part == t.parts.expected
    return expected and elapsed_time(arrival, t.parts.stamp) <= PART_WINDOW


def is_next_in_ring(t: Wholes, counter: int, arrival: int) -> bool:
    """Return whether a counter goes on by less than half of the ring, or anew after a silence."""
    step = (counter - t.line.last) % RING
    silent = elapsed_time(arrival, t.line.stamp) > SILENT
    return step != 0 and (step <= RING // 2 or silent)


def completes(frame: Bytes, part: int) -> bool:
    """Return whether no further part comes."""
    return part == STATE_PARTS or is_last_part(frame)


def keep_part(t: Wholes, frame: Bytes, part: int, arrival: int) -> None:
    """Keep a welcome part; a state that was begun and not finished is counted."""
    if part == 1:
        counter = counter_of_part(frame)
        count_on_ring(t, counter, arrival)
        t.parts.incomplete += 1 if t.parts.expected > 0 else 0
        t.parts.counter, t.parts.stamp = counter, bounded_time(arrival)
    t.parts.expected = part + 1
    start = PART_BYTES0 + (part - 1) * PART_PAYLOAD
    for i in range(PART_PAYLOAD):
        t[start + i] = int(frame[PART_HEAD + i])


def count_on_ring(t: Wholes, counter: int, arrival: int) -> None:
    """Take a counter that begins or goes on."""
    if t.line.last < 0:
        t.line.last = counter
    else:
        step = (counter - t.line.last) % RING
        t.line.last += step
        if elapsed_time(arrival, t.line.stamp) <= SILENT:
            t.line.lost += step - 1
    t.line.stamp = arrival


def take_parts(f: Floats, t: Wholes, parts: int) -> None:
    """Take the state of which ``parts`` have come; what was not sent is not measured."""
    t.parts.expected = 0
    for i in range(parts * PART_PAYLOAD, STATE_PARTS * PART_PAYLOAD):
        t.part_bytes[i] = int(ABSENT_BYTES[i])
    t.news.seq, t.news.stamp = t.line.last, t.parts.stamp
    unpack_parts(f, t)
