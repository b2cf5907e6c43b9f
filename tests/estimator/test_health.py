"""The health that is worked out where the innovations lie says what it would say over arrays."""

import math
from types import ModuleType

import numpy as np
import pytest

from tests.estimator.health_in_numpy import ENOUGH, SHAPE, Hysteresis, misfit_of_cells, verdict
from vegrip.estimator import EstimatorSettings, SensorNoise
from vegrip.estimator.compiled import Kernels, module_for
from vegrip.estimator.health import NO_CELL, HealthHysteresis, Look, health_of
from vegrip.estimator.initial_state import initial_memory
from vegrip.estimator.layout import CHANNELS, PER_CELL, PER_CHANNEL, REGIMES, layout_of
from vegrip.messages import Condition, FingertipState
from vegrip.model import paper_model
from vegrip.types import Floats

MODEL = paper_model(9e-3)
LAYOUT = layout_of(MODEL)
PLACES = LAYOUT.places()
LOOK_NS = 200_000_000


@pytest.fixture(scope="module", params=["compiled", "plain"])
def module(request: pytest.FixtureRequest) -> Kernels | ModuleType:
    return module_for(MODEL, LAYOUT, plain=request.param == "plain")


@pytest.fixture
def memory() -> Floats:
    return initial_memory(MODEL, LAYOUT, SensorNoise(), EstimatorSettings())


def cells_of(memory: Floats) -> Floats:
    return memory[slice(*PLACES["HEALTH"])]


def look(module: Kernels, memory: Floats, before: int = NO_CELL) -> Look:
    out = np.full(len(Look._fields), np.nan)
    module.look_at_cells(memory, float(before), out)
    return Look(*out.tolist())


def draw(rng: np.random.Generator, memory: Floats) -> None:
    """Put cells into ``memory`` as a life leaves them: some empty, some at their edge, some far outside."""
    cells = cells_of(memory).reshape(SHAPE)
    cells[..., PER_CELL.index("WEIGHT")] = rng.choice([0.0, 50.0, ENOUGH, 900.0], SHAPE[:2])
    cells[..., PER_CELL.index("MEAN")] = rng.normal(0.0, rng.choice([0.02, 0.3, 3.0]), SHAPE[:2])
    cells[..., PER_CELL.index("NIS")] = rng.gamma(rng.choice([0.5, 20.0]), 0.05, SHAPE[:2])
    if rng.random() < 0.2:
        cells[rng.random(SHAPE[:2]) < 0.7] = 0.0


def test_each_look_is_that_over_arrays(module: Kernels, memory: Floats) -> None:
    rng = np.random.default_rng(1)
    for _ in range(300):
        draw(rng, memory)
        misfit = misfit_of_cells(cells_of(memory)).ravel()
        before = int(rng.integers(misfit.size))
        found = look(module, memory, before)
        assert found.misfit == misfit.max()
        assert found.worst == misfit.argmax()
        assert found.misfit_told == misfit[before]
        assert found.judged == np.count_nonzero(cells_of(memory)[:: len(PER_CELL)] >= ENOUGH)


def test_the_verdict_over_time_is_that_over_arrays(module: Kernels, memory: Floats) -> None:
    rng = np.random.default_rng(2)
    here, there, told = HealthHysteresis(), Hysteresis(), set()
    for i in range(2000):
        if i % 7 == 0 and i > 20:
            draw(rng, memory)
        if i % 300 > 200:
            cells_of(memory).reshape(SHAPE)[..., 1:] = 0.0, 1.0  # well inside, for ten seconds and longer
        state = FingertipState(i * LOOK_NS, "index", i)
        found = health_of(state, i, Condition.OK, look(module, memory, here.failing), here)
        wanted = verdict(cells_of(memory), state.stamp, there)
        assert (found.consistent, found.channel, found.regime) == wanted[1:]
        assert found.nis == pytest.approx(wanted.nis, rel=1e-13, nan_ok=True)
        told.add((found.consistent, found.channel))
    assert len(told) == 2 + len(CHANNELS), "every channel fails once, none does, and nothing is known"


def test_refusals_are_those_of_all_channels(module: Kernels, memory: Floats) -> None:
    at = [LAYOUT.channel_place(i, "REJECTED") for i in range(len(CHANNELS))]
    assert len(PER_CHANNEL) > 1
    memory[at] = 3.0, 4.0, 5.0
    assert look(module, memory).rejected == 12.0


def test_a_cell_with_little_in_it_is_not_judged(module: Kernels, memory: Floats) -> None:
    cells = cells_of(memory).reshape(SHAPE)
    cells[1, 2] = 150.0, 3.0, 9.0
    assert look(module, memory).misfit == 0.0
    cells[1, 2, 0] = 500.0
    found = look(module, memory)
    assert found.misfit > 3.0
    assert divmod(int(found.worst), len(REGIMES)) == (1, 2)


@pytest.mark.parametrize("odd", [math.nan, math.inf])
def test_a_cell_that_is_not_finite_fails_at_once(module: Kernels, memory: Floats, odd: float) -> None:
    for number in (1, 2):
        cells = cells_of(memory).reshape(SHAPE)
        cells[:] = 500.0, 0.0, 1.0
        cells[1, 2, number] = odd
        found = look(module, memory)
        assert found.misfit == math.inf
        assert divmod(int(found.worst), len(REGIMES)) == (1, 2)
