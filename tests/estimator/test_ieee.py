"""Compiled or not, on this processor or another: the kernels compute the same, whatever comes in.

The sign of a NaN that an operation makes differs between processors, and what ``min`` and ``max`` make of one
differs between languages. So nothing may depend on either.
"""

import builtins
import math
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from vegrip.contact.limit_surface import fast
from vegrip.estimator import EstimatorSettings, SensorNoise
from vegrip.estimator.compiled import module_for
from vegrip.estimator.friction_prior import COULOMB
from vegrip.estimator.initial_state import initial_memory
from vegrip.estimator.layout import FRICTION, layout_of
from vegrip.model import cache, paper_model

Floats = NDArray[np.float64]
Sample = tuple[float, ...]
HOSTILE = (math.nan, -math.nan, math.inf, -math.inf, 0.0, -0.0, 5e-324, -1e-310, 1e300, -1e300, 1.0, -1.0)
PAUSES = (0.0, 1e-9, 0.1, 10.0, 1e10)  # [s] the longest that stamps of 64 bits allow
ASKED = ((0.3, 1.6), (0.0, 0.0), (0.999, 6.0), (1.0, 1.6), (-1.0, -1.6), (math.nan, 1.6))  # margin, quantile
MODEL = paper_model(9e-3)
LAYOUT = layout_of(MODEL)
NOISE = SensorNoise()


@pytest.fixture(scope="module")
def compiled() -> ModuleType:
    return module_for(MODEL, LAYOUT, late=EstimatorSettings().late)  # what a node compiles


@pytest.fixture
def plain(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The module as Python runs it; a NaN that reaches what may depend on its sign or order fails."""
    module = module_for(MODEL, LAYOUT, plain=True)
    for name in ("min", "max"):
        monkeypatch.setattr(module, name, no_nan(getattr(builtins, name)), raising=False)
    monkeypatch.setattr(module.math, "copysign", no_nan(math.copysign))
    return module


def no_nan(function: Callable[..., Any]) -> Callable[..., Any]:
    def checked(*arguments: Any) -> Any:
        assert not any(math.isnan(a) for a in arguments), f"{function.__name__}{arguments}"
        return function(*arguments)

    return checked


def memory() -> Floats:
    return initial_memory(MODEL, LAYOUT, NOISE, EstimatorSettings(friction=COULOMB))


def samples(seed: int, count: int = 45) -> list[Sample]:
    """A press with load and slip, in which one value in seven is hostile: the arguments of ``update``."""
    rng = np.random.default_rng(seed)
    out = []
    for i in range(count):
        depth = float(np.interp(i, [0, 12, 40], [-1e-4, 6e-4, 6e-4]))
        force = 6e4 * max(depth, 0.0) ** 1.5
        sample = [0.002, force, depth, math.nan, 0.3 * force, 1e-4 * force, 0.0]
        for j in range(1, len(sample)):
            if rng.random() < 0.15:
                sample[j] = HOSTILE[rng.integers(len(HOSTILE))]
        if rng.random() < 0.1:
            sample[0] = PAUSES[rng.integers(len(PAUSES))]
        out.append((-1.0 if i == 0 else sample[0], *sample[1:]))
    return out


def outputs(module: ModuleType, m: Floats, sample: Sample, asked: tuple[float, float]) -> Floats:
    out = np.zeros(6)
    module.update(m, *sample)
    module.margin_of(m, sample[4], sample[5], out)
    out[5] = module.least_force(m, sample[4], sample[5], *asked)
    return out


@pytest.mark.parametrize("seed", range(4))
def test_compiled_and_uncompiled_agree_on_hostile_samples(
    compiled: ModuleType, plain: ModuleType, seed: int
) -> None:
    m, n = memory(), memory()
    for i, sample in enumerate(samples(seed)):
        asked = ASKED[i % len(ASKED)]
        np.testing.assert_allclose(
            outputs(compiled, m, sample, asked), outputs(plain, n, sample, asked), rtol=1e-6, err_msg=f"{i}"
        )
        np.testing.assert_allclose(m, n, rtol=1e-6, atol=1e-300, err_msg=f"{i}: {sample}")


def test_the_sign_of_a_nan_that_comes_in_changes_nothing(compiled: ModuleType) -> None:
    m, n = memory(), memory()
    for i, sample in enumerate(samples(9, 400)):
        turned = tuple(-x if math.isnan(x) else x for x in sample)
        a, b = outputs(compiled, m, sample, ASKED[i % 6]), outputs(compiled, n, turned, ASKED[i % 6])
        np.testing.assert_array_equal(a, b)
        np.testing.assert_array_equal(m, n)


@pytest.mark.parametrize("load", [0.0, 0.5, 3.0])
def test_the_least_force_in_the_air_is_the_load_over_friction_with_its_spread(
    compiled: ModuleType, plain: ModuleType, load: float
) -> None:
    m = memory()
    for dt in (-1.0, *[0.002] * 9):
        compiled.update(m, dt, 0.0, -1e-4, math.nan, load, 0.0, 0.0)
    quantile = 1.6
    least = compiled.least_force(m, load, 0.0, 0.0, quantile)
    assert plain.least_force(m.copy(), load, 0.0, 0.0, quantile) == pytest.approx(least, rel=1e-9)
    place = LAYOUT.places()["FRICTION"][0]
    mu, std = math.exp(m[place + FRICTION.index("LN_MU")]), math.sqrt(m[place + FRICTION.index("VAR")])
    held = load / mu * math.exp(quantile * std)  # by the friction that is at least there
    noise = quantile * NOISE.tangential_force / mu
    assert held < least < 1.6 * (held + noise), (
        "that of the contact's shape and of its relaxation comes on top"
    )


def test_a_gauge_that_is_not_known_never_counts_as_held(compiled: ModuleType) -> None:
    m = memory()
    for dt in (-1.0, *[0.002] * 9):
        compiled.update(m, dt, 0.7, 6e-4, math.nan, 0.2, 0.0, 0.0)
    m[slice(*LAYOUT.places()["Y"])] = math.nan
    assert not compiled.least_force(m, 0.2, 0.0, 0.0, 1.6) < math.inf
    out = np.zeros(5)
    compiled.margin_of(m, 0.2, 0.0, out)
    assert not out[3] > 0.0, "it does not say that the contact will hold"


SURFACE = {
    "gauge": 3, "gauge_gradient": 3, "support_gradient": 3, "radius_gradient": 2, "torsion_gradient": 1,
    "point": 2, "cor_distance": 3, "least_normal_force": 8,
}  # fmt: skip


@pytest.mark.parametrize(("name", "arguments"), SURFACE.items())
def test_the_limit_surface_agrees_with_itself_uncompiled(name: str, arguments: int) -> None:
    text = Path(fast.__file__).read_text(encoding="utf-8")
    text = text.replace("from vegrip.compiled import njit\n", "import numba\nnjit = numba.njit(cache=True)\n")
    uncompiled = getattr(
        cache.load_plain(text.replace("njit = ", "njit_ = ").replace("@njit", "@njit_")), name
    )
    rng = np.random.default_rng(arguments)
    values = [*HOSTILE, 2.0, 0.3, 180.0, 1e-160, 1e160]
    for _ in range(600):
        given = [float(values[i]) for i in rng.integers(len(values), size=arguments)]
        ours, theirs = getattr(fast, name)(*given), uncompiled(*given)
        np.testing.assert_allclose(ours, theirs, rtol=1e-9, err_msg=f"{given}")
