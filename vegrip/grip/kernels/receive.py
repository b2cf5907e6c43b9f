"""A frame from the line: checks of its bytes, of its counter and of its time, before anything is changed.

Where frames go through no compiled step, :mod:`vegrip.transport.codec.sequence` counts the same.
"""

from vegrip.estimator.elapsed import bounded_time, elapsed_time
from vegrip.grip.kernels.frame_bytes import is_intact
from vegrip.grip.kernels.generated import *

SILENT = 500_000_000  # [ns] a line silent for longer may go on with any counter
MOST_LOST = 10_000  # frames lost in a row within that time
HALF_TIME = 2147483648  # half of what the sender's 32 bits of microseconds count
ALL_TIME = 4294967295


def is_welcome(t: Wholes, frame: Bytes, length: int, arrival: int) -> bool:
    """Return whether a frame is whole, new and plausible; changes nothing."""
    if not is_whole(t, frame, length):
        return False
    return t.line.last < 0 or is_next(t, counter_of_state(frame), arrival)


def is_whole(t: Wholes, frame: Bytes, length: int) -> bool:
    """Return whether a frame is what the sender has sent, and means something."""
    if length != STATE_LENGTH or not is_intact(frame, STATE_LENGTH, t.setup.state_id):
        return False
    return version_of_state(frame) == WIRE_VERSION and values_mean_something(frame)


def is_next(t: Wholes, counter: int, arrival: int) -> bool:
    """Return whether the counter goes on, or begins anew after a silence."""
    step = counter - t.line.last & ALL_TIME
    silent = elapsed_time(arrival, t.line.stamp) > SILENT
    return step != 0 and (step <= MOST_LOST or silent)


def stamp_of(t: Wholes, frame: Bytes, arrival: int) -> int:
    """Return the time of a state [ns]: its arrival, or the instant nearest to that by the sender's bits."""
    if t.setup.sender_time == 0:
        return bounded_time(arrival)
    now = bounded_time(arrival) // 1000
    return (now + (time_of_state(frame) - now + HALF_TIME & ALL_TIME) - HALF_TIME) * 1000


def take_frame(f: Floats, t: Wholes, frame: Bytes, arrival: int) -> None:
    """Take a welcome frame: counter, time and values of the state."""
    count_on(t, counter_of_state(frame), arrival)
    t.news.seq = t.line.last
    t.news.stamp = stamp_of(t, frame, arrival)
    unpack_state(f, frame)


def count_on(t: Wholes, counter: int, arrival: int) -> None:
    """Take a counter of 32 bits that begins or goes on."""
    if t.line.last < 0:
        t.line.last = counter
    else:
        step = counter - t.line.last & ALL_TIME
        t.line.last += step
        if elapsed_time(arrival, t.line.stamp) <= SILENT:
            t.line.lost += step - 1
    t.line.stamp = arrival
