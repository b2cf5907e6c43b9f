"""What an estimator saves is legal whatever it has met, and brings it back where it was."""

import math
from dataclasses import replace

import numpy as np
import pytest

from vegrip.errors import InputError
from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise
from vegrip.estimator.initial_state import initial_memory
from vegrip.estimator.layout import FRICTION, MODE, NAMED, PER_CELL, PER_CHANNEL, REGIMES, layout_of
from vegrip.estimator.saved_numbers import SavedNumbers, Span, _joined
from vegrip.export import Request
from vegrip.export.estimator import simulated
from vegrip.model import paper_model

MODEL = paper_model(8e-3)
STATES = tuple(simulated(Request(MODEL, frames=300)))
POISON = (math.nan, math.inf, -math.inf, 1e300, -1e300, 5e-324, 0.0, -1.0, 1e9, 60.0, -0.05)
LAYOUT = layout_of(MODEL)
PLACES, SAVED = LAYOUT.places(), SavedNumbers(MODEL, LAYOUT)
BLANK = initial_memory(MODEL, LAYOUT, SensorNoise(), EstimatorSettings())
CHANNELS = ("normal_force", "displacement", "tangential_force_x", "torque_z", "slip", "contact_radius")


@pytest.mark.parametrize("seed", range(4))
def test_whatever_an_estimator_has_met_what_it_saves_is_legal(seed: int) -> None:
    estimator, rng = ContactEstimator(MODEL, SensorNoise()), np.random.default_rng(seed)
    saved = SavedNumbers(MODEL, estimator.layout)
    assert saved.are_legal(estimator.memory[saved.places])
    later = 0
    for state in STATES:
        later += int(10 ** rng.uniform(6.0, 11.0)) if rng.random() < 0.01 else 0
        changes = {name: float(rng.choice(POISON)) for name in CHANNELS if rng.random() < 0.1 * seed}
        estimator.update(replace(state, stamp=state.stamp + later, **changes))
        assert saved.are_legal(estimator.memory[saved.places])


def test_an_estimator_that_resumes_says_what_the_one_before_it_learned_with_settings_of_its_own() -> None:
    first, second = ContactEstimator(MODEL, SensorNoise()), ContactEstimator(MODEL, SensorNoise(0.03))
    for state in STATES:
        first.update(state)
    settings = second.memory[slice(*second.layout.places()["SET"])]
    second.resume(first.memory)
    for symbol in MODEL.parameters:
        assert second.value(symbol).value == first.value(symbol).value
        assert second.value(symbol).std == first.value(symbol).std
    assert np.array_equal(second.memory[slice(*second.layout.places()["SET"])], settings)
    assert not second.value("mu").valid
    numbers = dict(zip(FRICTION, first.memory[slice(*PLACES["FRICTION"])], strict=True))
    load, cov = numbers["LOAD"], numbers["COV"]
    assert load * cov != 0.0
    variance = numbers["VAR"] - 2.0 * load * cov + load * load * numbers["EXPONENT_VAR"]
    assert second.memory[PLACES["CONSIDER"][1] - 1] == pytest.approx(variance, rel=1e-12)


WIDE, INF = 1e50, math.inf
LEGAL = [
    *(("FRICTION", name, 1e-15, 100.0) for name in ("VAR", "BASE_VAR", "SCATTER_VAR")),
    *(("FRICTION", name, -2.0, 2.0) for name in ("EXPONENT", "BASE_EXPONENT")),
    *(("FRICTION", name, 0.0, 1.0) for name in ("SLIDING", "TOUCHING")),
    *(("FRICTION", name, -WIDE, WIDE) for name in ("SLIDE_MEAN", "EVENT_LN_U", "COV", "BASE_COV", "LOAD")),
    *(("FRICTION", name, low, high) for name, low, high in (
        ("EVENTS", 0.0, 2.0**53), ("SLIDE_COUNT", -1.0, 2.0**53), ("UNCONFIRMED", -WIDE, INF),
        ("PEAK", 0.0, WIDE),
    )),
    *(("MODE", name, 0.0, 1.0) for name in ("ZERO_KNOWN", "BLIND", "HEALTH_DECAY", "FELT", "MET")),
    *(("MODE", name, -WIDE, WIDE) for name in ("CORNER", "SLOPE", "ZERO_MEAN", "BEND")),
    ("MODE", "FREE_DEPTH", -INF, WIDE), ("MODE", "REST", 0.0, WIDE),
    *(("MOTION", name, -WIDE, WIDE) for name in ("POSITION", "SPEED", "COV")),
    ("HEALTH", "MEAN", -10.0, 10.0), ("HEALTH", "NIS", 0.0, 100.0), ("HEALTH", "WEIGHT", 0.0, WIDE),
    ("CHANNEL", "STREAK", 0.0, 2.0**53), ("CHANNEL", "AGE", 0.0, INF), ("CHANNEL", "USED", 0.0, 1.0),
    ("REPORT", "CONTACT", 0.0, 1.0), ("COUNTS", "RESTARTS", 0.0, 2.0**53), ("EXOGENOUS", "", -1e300, 1e300),
    ("RATIO", "COUNT", -WIDE, WIDE), ("Y", "", -200.0 * 8e-3, 10.0 * 8e-3),
]  # fmt: skip
NAMES = {name: names for name, (_, names) in NAMED.items()} | {"CHANNEL": PER_CHANNEL, "HEALTH": PER_CELL}


@pytest.mark.parametrize(("section", "name", "low", "high"), LEGAL)
def test_a_number_is_legal_up_to_its_bounds(section: str, name: str, low: float, high: float) -> None:
    memory = BLANK.copy()
    place = PLACES[section][0] + (NAMES[section].index(name) if name else 0)
    for value, legal in (
        (low, True), (high, True), (0.999 * high + 0.001 * max(low, 0.0), True),
        (math.nextafter(low, -INF), low == -INF), (math.nextafter(high, INF), high == INF),
    ):  # fmt: skip
        memory[place] = value
        assert SAVED.are_legal(memory[SAVED.places]) == legal, value


def test_a_learned_parameter_is_legal_up_to_a_twentieth_beyond_its_bounds() -> None:
    for j in range(LAYOUT.learned_from, LAYOUT.moving):
        low, high = BLANK[PLACES["LOW"][0] + j], BLANK[PLACES["HIGH"][0] + j]
        for share, legal in ((-0.051, False), (-0.049, True), (1.049, True), (1.051, False)):
            memory = BLANK.copy()
            memory[PLACES["Y"][0] + j] = low + share * (high - low)
            assert SAVED.are_legal(memory[SAVED.places]) == legal


@pytest.mark.parametrize(
    ("variance", "up", "down", "legal"),
    [
        (4.0, 6.0 * (1.0 + 0.9e-3), 6.0 * (1.0 + 0.9e-3), True),
        (4.0, -6.0 * (1.0 + 1.1e-3), -6.0 * (1.0 + 1.1e-3), False),
        (4.0, 3.0, 3.0 + 6.0 * 0.9e-3, True),
        (4.0, 3.0, 3.0 - 6.0 * 1.1e-3, False),
        (0.0, 0.0, 0.0, True),
        (-1e-9, 0.0, 0.0, False),
    ],
)
def test_a_covariance_is_legal_but_for_a_thousandth(
    variance: float, up: float, down: float, legal: bool
) -> None:
    memory, n = BLANK.copy(), LAYOUT.n
    P = memory[slice(*PLACES["P"])].reshape(n, n)
    P[0, 0], P[1, 1], P[0, 1], P[1, 0] = variance, 9.0, up, down
    assert SAVED.are_legal(memory[SAVED.places]) == legal


def test_every_number_that_lasts_is_saved_or_is_of_model_and_settings() -> None:
    """One that is forgotten here would silently be lost over a loss of power."""
    estimator = ContactEstimator(MODEL, SensorNoise())
    layout = estimator.layout
    told = ("VALUES", "PRIOR", "LOW", "HIGH", "DRIFT", "SET", "CONSIDER", "START", "REPORT")
    of_model = {i for name in told for i in range(*layout.places()[name])}
    saved = set(SavedNumbers(MODEL, layout).places.tolist())
    assert saved | of_model == set(range(layout.lasting))
    assert len(SavedNumbers(MODEL, layout).places) == len(saved)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_no_number_that_is_saved_may_be_none(value: float) -> None:
    estimator = ContactEstimator(MODEL, SensorNoise())
    saved = SavedNumbers(MODEL, estimator.layout)
    numbers = estimator.memory[saved.places]
    refused = 0
    for at in range(len(numbers)):
        wrong = numbers.copy()
        wrong[at] = value
        refused += not saved.are_legal(wrong)
    endless = {math.inf: 4, -math.inf: 1}.get(value, 0)  # ages, an unconfirmed slip; the deepest free depth
    assert refused == len(numbers) - endless


@pytest.mark.parametrize("ln_u", [-2.0, -0.1, 0.9, math.inf])
def test_a_slip_that_waits_for_another_like_it_is_saved_whatever_friction_it_showed(ln_u: float) -> None:
    estimator = ContactEstimator(MODEL, SensorNoise())
    saved = SavedNumbers(MODEL, estimator.layout)
    place = estimator.layout.places()["FRICTION"][0] + FRICTION.index("UNCONFIRMED")
    assert place in saved.places
    memory = estimator.memory.copy()
    memory[place] = ln_u
    assert saved.are_legal(memory[saved.places])


@pytest.mark.parametrize("name", ["REGIME", "CELL"])
def test_a_motion_that_is_saved_is_one_that_there_is(name: str) -> None:
    """It is the place of a row in a table."""
    estimator = ContactEstimator(MODEL, SensorNoise())
    saved = SavedNumbers(MODEL, estimator.layout)
    memory = estimator.memory.copy()
    for value in range(-2, len(REGIMES) + 3):
        memory[estimator.layout.places()["MODE"][0] + MODE.index(name)] = value
        assert saved.are_legal(memory[saved.places]) == (value in range(len(REGIMES)))


def test_numbers_of_another_size_are_refused() -> None:
    estimator = ContactEstimator(MODEL, SensorNoise())
    with pytest.raises(InputError):
        estimator.resume(estimator.memory[:-1])


def test_only_spans_that_follow_each_other_within_equal_bounds_are_one() -> None:
    apart = [
        Span(0, 2, 1, 0.0, 1.0),
        Span(3, 1, 1, 0.0, 1.0),  # one place is between them
        Span(4, 2, 1, 0.0, 2.0),  # up to another bound
        Span(6, 1, 1, -1.0, 2.0),
        Span(7, 2, 3, -1.0, 2.0),  # in steps
        Span(9, 1, 1, -1.0, 2.0),
        Span(0, 1, 1, -1.0, 2.0),  # before it
    ]
    assert list(_joined(iter(apart))) == apart
    following = [Span(0, 2, 1, 0.0, 1.0), Span(2, 3, 1, 0.0, 1.0), Span(5, 1, 1, 0.0, 1.0)]
    assert list(_joined(iter(following))) == [Span(0, 6, 1, 0.0, 1.0)]
