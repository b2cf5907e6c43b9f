"""The estimator's kernels in C leave every number of the memory as plain Python does.

With ``VEGRIP_KERNEL=numba`` they are compared with what numba compiles. That takes most of a minute for each
model, so the effects come in groups.
"""

import ctypes
import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
import pytest

from vegrip.c99 import host
from vegrip.effects import BUILT_IN, effect
from vegrip.effects.contract import OUTSIDE
from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.estimator.compiled import KINDS, Kernels, module_for, node_text_of
from vegrip.estimator.layout import COUNTS, Layout, layout_of
from vegrip.model import BASE, ContactModel, paper_model
from vegrip.model.native import kernel_mode, run_by

DT = 4e-3
ITERATES = "jkr_adhesion"  # it solves an equation in every call: beside others it takes six times as long
ADDED = [name for name in BUILT_IN if name not in (*BASE, ITERATES)]
TOGETHER = 8  # effects in one model
GROUPS = [[ITERATES], *(ADDED[first : first + TOGETHER] for first in range(0, len(ADDED), TOGETHER))]
needs_compiler = pytest.mark.skipif(host.compiler() is None, reason="no C compiler")


def eventful(model: ContactModel, samples: int) -> Iterator[tuple[np.ndarray, tuple[float, ...]]]:
    """Yield what is felt besides, and an update's arguments: a press, a slip, losses, a wrong sensor."""
    rng = np.random.default_rng(4)
    t = np.arange(samples) * DT
    depth = np.interp(t, [0.1, 0.4, 1.2, 1.5], [-1e-4, 8e-4, 8e-4, 5e-4])
    forces = model.simulate(t, depth).normal_force + rng.normal(0.0, 0.01, samples)
    loads = np.interp(t, [0.5, 1.0], [0.0, 0.5])
    for i, (force, load) in enumerate(zip(forces.tolist(), loads.tolist(), strict=True)):
        f = math.nan if i % 47 == 0 else math.inf if i == 175 else force + (0.8 if i > 450 else 0.0)
        blind = 100 < i < 108 or 200 < i < 280
        d = math.nan if blind else depth[i] + rng.normal(0.0, 5e-6)
        slip = 1.0 if 350 < i < 360 else 0.0
        dt = -1.0 if i == 0 else 0.7 if i == 150 else DT
        beside = np.array([20.0 + 5.0 * math.sin(i / 50.0), load, 1e-4, 1e-3 * slip, load, 0.0])
        yield beside, (dt, f, d, 1e-3 if i % 25 == 0 else math.nan, load, 1e-4, slip)


def other_than_c(estimator: ContactEstimator) -> Kernels:
    """Return what C is compared with."""
    return module_for(estimator.model, estimator.layout, plain=kernel_mode() != "numba")


def in_c(model: ContactModel, layout: Layout) -> Kernels:
    return run_by("c", node_text_of(model, layout), KINDS, results={"least_force": ctypes.c_double})


def differing(model: ContactModel, samples: int = 600) -> str:
    """Return where the two differ first; nothing when they do not."""
    estimator = ContactEstimator(model, SensorNoise())
    by_other, by_c = other_than_c(estimator), in_c(model, estimator.layout)
    memories, margins = (
        [estimator._blank.copy(), estimator._blank.copy()],
        [np.full(5, np.nan), np.full(5, np.nan)],
    )
    places = estimator.layout.places()
    outside = slice(places["EXOGENOUS"][0], places["EXOGENOUS"][0] + len(OUTSIDE))
    for i, (beside, sample) in enumerate(eventful(model, samples)):
        least = []
        for module, m, margin in zip((by_other, by_c), memories, margins, strict=True):
            m[outside] = beside
            module.update(m, *sample)
            if i % 10 == 0:
                module.margin_of(m, sample[4], sample[5], margin)
                least.append(module.least_force(m, sample[4], sample[5], 0.1, 1.6))
        if not np.array_equal(*memories, equal_nan=True):
            wrong = np.flatnonzero(~np.isclose(*memories, rtol=0.0, atol=0.0, equal_nan=True))[0]
            name, start = next((name, start) for name, (start, end) in places.items() if start <= wrong < end)
            return f"sample {i}: {name}[{wrong - start}], {memories[0][wrong]!r}, {memories[1][wrong]!r}"
        if not np.array_equal([*margins[0], *least[:1]], [*margins[1], *least[1:]], equal_nan=True):
            return f"sample {i}: margins {margins}, least forces {least}"
    states = memories[0][slice(*places["Y"])]
    if not np.isfinite(states).all():
        return f"states are no numbers, so they were not compared: {states}"
    if model == paper_model(8e-3) and memories[0][places["COUNTS"][0] + COUNTS.index("RESTARTS")] == 0.0:
        return "nothing began anew, which was to be compared"
    return ""


@needs_compiler
def test_the_papers_model() -> None:
    assert not differing(paper_model(8e-3))


@needs_compiler
@pytest.mark.long
@pytest.mark.parametrize("names", GROUPS, ids=" ".join)
def test_every_effect(names: list[str]) -> None:
    model = paper_model(8e-3)
    for name in names:
        model = model.with_effect(effect(name))
    assert not differing(model, 480)  # 30 samples after the last that happens


class OneBitOff:
    """Kernels of which one entry leaves one number a bit off, from its second call on."""

    def __init__(self, right: Kernels, entry: str, place: int) -> None:
        self.right, self.entry, self.place, self.calls = right, entry, place, 0

    def __getattr__(self, name: str) -> Callable[..., Any]:
        run: Callable[..., Any] = getattr(self.right, name)
        return partial(self._spoilt, run) if name == self.entry else run

    def _spoilt(self, run: Callable[..., Any], *given: Any) -> Any:
        result, self.calls = run(*given), self.calls + 1
        if self.calls < 2:
            return result
        if self.place < 0:
            return np.nextafter(result, math.inf)
        left = given[0] if self.entry == "update" else given[-1]
        known = left[self.place]
        left[self.place] = np.nextafter(known, math.inf) if math.isfinite(known) else 1.0
        return result


LAYOUT = layout_of(paper_model(8e-3))


@pytest.mark.parametrize(
    ("entry", "place", "told"),
    [
        *[("update", start, f"sample 1: {name}[0]") for name, (start, _) in LAYOUT.places().items()],
        *[("update", end - 1, f"sample 1: {name}[") for name, (_, end) in LAYOUT.places().items()],
        *[("margin_of", place, "sample 10: margins") for place in range(5)],
        ("least_force", -1, "sample 10: margins"),
    ],
)
def test_one_bit_of_one_number_is_a_difference(
    entry: str, place: int, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else it would prove nothing that there is none."""
    right = module_for(paper_model(8e-3), LAYOUT, plain=True)
    monkeypatch.setitem(globals(), "other_than_c", lambda _: right)
    monkeypatch.setitem(globals(), "in_c", lambda *_: OneBitOff(right, entry, place))
    assert differing(paper_model(8e-3), samples=2 if entry == "update" else 11).startswith(told)


@needs_compiler
def test_the_filter_alone() -> None:
    estimator = ContactEstimator(paper_model(8e-3), SensorNoise())
    by_other, by_c = other_than_c(estimator), in_c(estimator.model, estimator.layout)
    ours, theirs = estimator.numbers.copy(), estimator.numbers.copy()
    for _, sample in eventful(estimator.model, 150):
        dt = max(sample[0], 0.0)
        by_other.filter_step(ours, dt, *sample[1:4])
        by_c.filter_step(theirs, dt, *sample[1:4])
        assert np.array_equal(ours, theirs, equal_nan=True)
