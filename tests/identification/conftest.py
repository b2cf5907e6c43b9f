"""A fingertip of a few lines that shares nothing with the model: taps in an episode, sensors with zeros."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from tests.conftest import Once
from tests.identification.bench import bench_recording
from vegrip.identification.recording import Fingertip, Recording
from vegrip.types import Floats

RATE = 200.0
NOISE = {"normal_force": 0.01, "displacement": 5e-6}
AIR = -0.3  # [mm]


def moved(kind: str, rng: np.random.Generator, rate: float) -> tuple[Floats, Floats]:
    """Time [s] and depth [mm] of an episode, at ``rate`` [Hz]."""
    way, t = [(0.0, AIR), (0.4, AIR)], 0.4
    if kind == "hold":
        deep = rng.uniform(0.6, 1.4)
        way += [(t + 0.15, deep), (t + 4.0, deep), (t + 4.2, AIR), (t + 5.0, AIR)]
    elif kind == "ramp":
        lasts = 1.6 / rng.uniform(0.5, 4.0)
        way += [(t + lasts, 1.3), (t + 2.0 * lasts, AIR), (t + 2.0 * lasts + 0.6, AIR)]
    elif kind == "wander":
        for until in np.arange(t + 0.25, 6.0, 0.25):
            way.append((until, rng.uniform(0.4, 1.4)))
        way += [(6.2, AIR), (7.0, AIR)]
    else:  # taps: the contact is lost while the tip is dented, and made again
        for _ in range(5):
            deep = rng.uniform(0.5, 1.4)
            way += [(t + 0.1, deep), (t + 0.5, deep), (t + 0.6, AIR), (t + 0.9, AIR)]
            t += 0.9
    times, depths = zip(*way, strict=True)
    t = np.arange(0.0, times[-1], 1.0 / rate)
    return t, np.interp(t, times, depths)


def shown(t: Floats, depth: Floats, force: Floats, kind: str, seconds: float) -> tuple[Floats, Floats]:
    """Return what sensors show of depth and force; a lag is integrated in steps of a hundredth of it."""
    if kind == "delay":
        return depth, np.interp(t - seconds, t, force)
    if not kind:
        return depth, force
    true = depth if kind == "displacement" else force
    fine = np.linspace(t[0], t[-1], round(100.0 * (t[-1] - t[0]) / seconds))
    follows, y = np.interp(fine, t, true), np.empty(fine.size)
    y[0], step = follows[0], (fine[1] - fine[0]) / seconds
    for i in range(1, fine.size):
        y[i] = y[i - 1] + step * (0.5 * (follows[i] + follows[i - 1]) - y[i - 1])
    late = np.interp(t, fine, y)
    return (late, force) if kind == "displacement" else (depth, late)


def pressed(
    seed: int,
    *,
    kinds: Sequence[str] = ("hold", "taps", "ramp", "hold", "taps", "ramp"),
    branches: Sequence[tuple[float, float]] = ((0.3, 3.0),),
    zeros: tuple[float, float] = (0.0, 0.0),
    crack: tuple[float, float] | None = None,
    second: tuple[float, float] | None = None,
    exponent: float = 1.5,
    pull: float = 0.0,
    late: tuple[str, float] = ("", 0.0),
    rate: float = RATE,
) -> Recording:
    """A power law of the depth through exponential relaxation, cut off at zero.

    ``branches``: amplitude and rate [1/s]; ``zeros`` of displacement [mm] and force [N]; ``crack``: when [s]
    which share is added to the stiffness; ``second``: at which depth [mm] a spring [N/mm] is touched;
    ``pull``: force [N] with which the surfaces stick, on the way out over a neck of 0.1 mm;
    ``late``: "lag", "delay" (of the force) or "displacement" (a lag of it), and by how many seconds;
    ``rate`` [Hz] of the samples.
    """
    rng = np.random.default_rng(seed)
    rows, began = [], 0.0
    for episode, kind in enumerate(kinds):
        t, depth = moved(kind, rng, rate)
        elastic = 1.8 * np.maximum(depth, 0.0) ** exponent
        if second is not None:
            elastic += second[1] * np.maximum(depth - second[0], 0.0)
        if crack is not None:
            elastic *= np.where(t + began >= crack[0], 1.0 + crack[1], 1.0)
        force = (1.0 - sum(share for share, _ in branches)) * elastic
        for share, relaxes in branches:
            branch, keep = 0.0, np.exp(-relaxes / rate)
            for i, step in enumerate(np.diff(elastic, prepend=elastic[0])):
                branch = branch * keep + share * step * np.sqrt(keep)
                force[i] += branch
        force = np.maximum(force, 0.0) * (depth > 0.0)
        touched = np.maximum.accumulate(depth) > 0.0
        force -= pull * touched * np.clip(1.0 + depth / 0.1, 0.0, 1.0)
        depth, force = shown(t, depth, force, *late)
        rows.append(np.c_[t + began, np.full(t.size, episode), 1e-3 * (depth + zeros[0]), force + zeros[1]])
        began += t[-1] + 20.0
    t, episodes, depth, force = np.vstack(rows).T
    columns = {
        "displacement": depth + NOISE["displacement"] * rng.standard_normal(t.size),
        "normal_force": force + NOISE["normal_force"] * rng.standard_normal(t.size),
    }
    return Recording("tip", t, episodes.astype(np.int64), columns, Fingertip(0.01), NOISE)


@pytest.fixture(scope="session")
def tip() -> Callable[..., Recording]:
    """Give a recording of the fingertip of a few lines."""
    return pressed


@pytest.fixture(scope="session")
def bench(once: Once[Recording]) -> Callable[..., Recording]:
    """Give the recording of the bench with a hidden effect (by name, amount, seed), or with none."""

    def made(name: str = "", amount: float = 1.0, seed: int = 0) -> Recording:
        return once(f"bench-{name}-{amount}-{seed}", lambda _: bench_recording(name, amount, seed))

    return made
