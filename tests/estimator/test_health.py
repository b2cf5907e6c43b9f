"""How far the innovations are outside, by channel and regime, and what is said of it."""

import math
from types import ModuleType

import numpy as np
import pytest

from vegrip.clock import NS
from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise
from vegrip.estimator.compiled import Kernels, module_for
from vegrip.estimator.health import NO_CELL, HealthHysteresis, Look
from vegrip.estimator.initial_state import initial_memory
from vegrip.estimator.layout import CHANNELS, MODE, PER_CELL, PER_CHANNEL, REGIMES, layout_of
from vegrip.messages import FingertipState
from vegrip.model import paper_model
from vegrip.types import Floats

MODEL = paper_model(9e-3)
LAYOUT = layout_of(MODEL)
PLACES = LAYOUT.places()
SHAPE = len(CHANNELS), len(REGIMES), len(PER_CELL)


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


CALM_CELL, LEAST, MOST = (500.0, 0.0, 1.0), 0.4, 1.4


@pytest.mark.parametrize(
    ("channel", "regime", "mean", "nis", "misfit"),
    [
        ("normal_force", "air", 0.0, MOST, 1.0),
        ("normal_force", "hold", 0.25, 1.0, 1.0),
        ("normal_force", "sliding", -0.75, 1.0, 3.0),
        ("contact_radius", "deep hold", 0.0, LEAST / 4.0, 4.0),
        ("contact_radius", "fast unloading", 0.8, 1.0, 2.0),
        ("normal_force", "late hold", 2.0, 1.0, 2.0),
        ("displacement", "hold", 0.0, 6.0 * MOST, 2.0),
        ("normal_force", "jerk", 9.0, 9.0, 1.0 / MOST),
    ],
)
def test_a_cell_is_outside_by_its_bias_and_by_its_scatter(
    module: Kernels, memory: Floats, channel: str, regime: str, mean: float, nis: float, misfit: float
) -> None:
    """Wider in motion, late in a hold and for the displacement; a jerk is not judged."""
    cells, at = cells_of(memory).reshape(SHAPE), (CHANNELS.index(channel), REGIMES.index(regime))
    cells[:] = CALM_CELL
    cells[at] = 300.0, mean, nis
    found = look(module, memory, len(REGIMES) * at[0] + at[1])
    assert found.misfit == pytest.approx(misfit)
    assert divmod(int(found.worst), len(REGIMES)) == at or regime == "jerk"
    assert found.reported_misfit == pytest.approx(misfit if regime != "jerk" else 0.0)
    assert found.judged == len(CHANNELS) * len(REGIMES)


def test_the_mean_nis_is_by_weight_and_leaves_out_what_follows_a_jerk(
    module: Kernels, memory: Floats
) -> None:
    cells = cells_of(memory).reshape(SHAPE)
    cells[:] = 0.0
    assert math.isnan(look(module, memory).nis)
    cells[0, 0], cells[1, 1], cells[2, REGIMES.index("jerk")] = (100, 0, 1), (300, 0, 5), (900, 0, 50)
    found = look(module, memory)
    assert (found.nis, found.judged) == (pytest.approx(4.0), 2.0)


def test_what_fails_is_named_by_channel_and_regime(module: Kernels, memory: Floats) -> None:
    cells, verdict = cells_of(memory).reshape(SHAPE), HealthHysteresis()

    def told(seconds: int) -> tuple[str, str] | None:
        found = look(module, memory, verdict.failing)
        failing = verdict.update(int(found.worst), found.misfit, found.reported_misfit, seconds * NS)
        channel, regime = divmod(failing, len(REGIMES))
        return None if failing == NO_CELL else (CHANNELS[channel], REGIMES[regime])

    cells[:] = CALM_CELL
    assert told(1) is None
    for i, (channel, regime) in enumerate([("contact_radius", "air"), ("displacement", "deep hold")]):
        cells[CHANNELS.index(channel), REGIMES.index(regime)] = 500.0, 10.0 ** (i + 1), 1.0
        assert told(2 + i) == (channel, regime)
    cells[:] = CALM_CELL
    assert [told(4 + i) is None for i in range(12)] == [False] * 10 + [True] * 2


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


def test_a_force_that_is_followed_for_want_of_a_displacement_is_no_misfit_where_it_agrees_too_well(
    module: Kernels, memory: Floats
) -> None:
    cells = cells_of(memory).reshape(SHAPE)
    cells[CHANNELS.index("normal_force"), REGIMES.index("late hold")] = 500.0, 0.0, 0.006
    assert look(module, memory).misfit > 10.0
    memory[PLACES["MODE"][0] + MODE.index("BLIND")] = 1.0
    assert look(module, memory).misfit < 0.01
    cells[CHANNELS.index("normal_force"), REGIMES.index("late hold")] = 500.0, 0.0, 2.0 * MOST
    assert look(module, memory).misfit == pytest.approx(2.0)


@pytest.mark.parametrize("weights", [(), (150.0,), (500.0,), (500.0, 500.0)])
def test_a_model_that_agrees_wherever_it_is_judged_is_consistent(weights: tuple[float, ...]) -> None:
    """Of one regime or of several, but not before enough was seen of any."""
    estimator = ContactEstimator(MODEL, SensorNoise(), EstimatorSettings())
    estimator.assimilate(FingertipState(NS, "tip", 1, 0.0, 0.0, 0.0, 0.0, -1e-3))
    cells = estimator.named.section("HEALTH").reshape(SHAPE)
    cells[:] = 0.0
    for regime, weight in enumerate(weights):
        cells[0, regime] = weight, 0.0, 1.0
    assert estimator.health().consistent == (max(weights, default=0.0) > 200.0)
