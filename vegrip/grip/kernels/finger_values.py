"""The numbers of one state of one finger: values, counter and time in, and the numbers of its command."""

import math

from vegrip.estimator.elapsed import bounded_time
from vegrip.grip.kernels.finger_step import LEFT_ALONE, answer_state
from vegrip.grip.kernels.generated import *
from vegrip.grip.kernels.receive import count_on, is_next


def finger_values(
    f: Floats, t: Wholes, g: Floats, values: Floats, counter: int, stamp: int, arrival: int, now: int
) -> int:
    """Answer the state of ``values`` and ``stamp`` [ns]; the command stays in the memory."""
    if not are_welcome(t, values, counter, arrival):
        return LEFT_ALONE
    count_on(t, counter, arrival)
    t.news.seq, t.news.stamp = t.line.last, bounded_time(stamp)
    for i in range(MEASURED):
        f.state[i] = values[i]
    return answer_state(f, t, g, now)


def are_welcome(t: Wholes, values: Floats, counter: int, arrival: int) -> bool:
    """Return whether the values mean something and the state is new."""
    for i in range(MEASURED):
        if math.isinf(values[i]):
            return False
    return t.line.last < 0 or is_next(t, counter, arrival)
