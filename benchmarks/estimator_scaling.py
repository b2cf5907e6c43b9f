"""What an estimator costs as fingers and history grow: nothing may grow but the number of fingers.

``N_fingers_vs_one`` sets a sample of each of N fingers (ours) against N samples of one finger (theirs).
``step_after_an_hour_vs_at_first`` sets a step after an hour at 1 kHz (ours) against one of the first second.
``memory_per_finger`` gives the bytes of everything an estimator owns, and as ``theirs`` those of a history of
60 s at 1 kHz, which a direct sum over the past would have to keep.
"""

import tracemalloc

from benchmarks._timing import compared
from benchmarks.estimator import DISPLACEMENT, DT, FORCE, settled
from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.messages import NAN
from vegrip.model import paper_model
from vegrip.types import Floats

FINGERS = (1, 5, 20, 100)
HOUR = 3_600_000  # steps at 1 kHz
SMALLEST = {"FINGERS": (1, 2), "HOUR": 1000}
SAMPLE = (FORCE, DISPLACEMENT, NAN, 0.2, 1e-4, 0.0)


def run() -> dict[str, dict[str, float]]:
    estimator = settled(paper_model(8e-3))
    module, m = estimator._module, estimator.numbers
    results = {}
    for count in FINGERS:
        hands = [m.copy() for _ in range(count)]

        def of_all(hands: list[Floats] = hands) -> None:
            for hand in hands:
                module.update(hand, DT, *SAMPLE)

        def of_one(count: int = count, one: Floats = hands[0]) -> None:
            for _ in range(count):
                module.update(one, DT, *SAMPLE)

        results[f"{count}_fingers_vs_one"] = compared(of_all, of_one)
    fresh, old = m.copy(), m.copy()
    for _ in range(HOUR):
        module.filter_step(old, 1e-3, FORCE, DISPLACEMENT, NAN)
    results["step_after_an_hour_vs_at_first"] = compared(
        lambda: module.filter_step(old, 1e-3, FORCE, DISPLACEMENT, NAN),
        lambda: module.filter_step(fresh, 1e-3, FORCE, DISPLACEMENT, NAN),
    )
    return results | {"memory_per_finger": memory()}


def memory() -> dict[str, float]:
    """Return bytes where the others have microseconds."""
    model = paper_model(8e-3)
    ContactEstimator(model, SensorNoise())  # what all fingers share
    tracemalloc.start()
    kept = ContactEstimator(model, SensorNoise())
    ours, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    theirs = 60 * 1000 * 3 * 8  # t, force, displacement
    assert kept.numbers.nbytes < ours
    return {"ours_us": ours, "theirs_us": theirs, "ratio": theirs / ours, "ours_bytes": ours}
