"""Whether a signal counts the frames of its message, and how far, from the frames that came."""

import itertools
from collections.abc import Sequence
from typing import Final

from vegrip.transport.mapped.compiled import compile_raw
from vegrip.transport.mapped.database import ForeignMessage

MOST_REPEATS: Final = 0.02  # of the frames: a frame repeated now and then is what a counter is for
MIN_TURNS: Final = 3  # that a counter must have made before its end is known
MIN_COUNTER_FRAMES: Final = 10  # frames that tell nothing


def find_modulus(message: ForeignMessage, signal: str, frames: Sequence[bytes]) -> int | None:
    """Return where the counter ``signal`` begins again, 0 where its bits or the frames end it.

    None: it does not count frames. It stands still from one to the next, as one that counts cycles of
    several frames, or each page of a multiplexed message by itself; or it is a time.
    """
    place = message.signals[signal]
    raw = compile_raw(message, place)
    counts = [raw(data[: message.length]) for data in frames if len(data) >= message.length]
    if len(counts) < MIN_COUNTER_FRAMES:
        return 0
    end = max(counts) + 1
    steps = [(other - one) % end for one, other in itertools.pairwise(counts)]
    if steps.count(0) > MOST_REPEATS * len(counts) or 2 * steps.count(1) < len(steps):
        return None
    return end if end < 1 << place.length and len(counts) >= MIN_TURNS * end else 0
