"""How a call is timed: the best of several batches, so that a busy machine does not decide the ratio."""

from collections.abc import Callable
from time import perf_counter

BATCH_SECONDS = 0.05
BATCHES = 5
SMALLEST = {"BATCH_SECONDS": 0.0, "BATCHES": 1}


def microseconds(call: Callable[[], object]) -> float:
    """Time of one ``call`` in microseconds; it is called once before, to compile and to warm the caches."""
    call()
    start = perf_counter()
    call()
    count = max(1, int(BATCH_SECONDS / max(perf_counter() - start, 1e-9)))
    best = min(_batch(call, count) for _ in range(BATCHES))
    return best / count * 1e6


def compared(ours: Callable[[], object], theirs: Callable[[], object]) -> dict[str, float]:
    """Time both in the same run; the ratio is theirs over ours."""
    ours_us, theirs_us = microseconds(ours), microseconds(theirs)
    return {"ours_us": ours_us, "theirs_us": theirs_us, "ratio": theirs_us / ours_us}


def _batch(call: Callable[[], object], count: int) -> float:
    start = perf_counter()
    for _ in range(count):
        call()
    return perf_counter() - start
