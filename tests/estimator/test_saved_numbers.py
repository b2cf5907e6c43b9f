"""What an estimator saves is legal whatever it has met, and brings it back where it was."""

import math
from dataclasses import replace

import numpy as np
import pytest

from vegrip.errors import InputError
from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.estimator.layout import FRICTION, MODE, REGIMES
from vegrip.estimator.saved_numbers import SavedNumbers
from vegrip.export import Request
from vegrip.export.estimator import simulated
from vegrip.model import paper_model

MODEL = paper_model(8e-3)
STATES = tuple(simulated(Request(MODEL, frames=300)))
POISON = (math.nan, math.inf, -math.inf, 1e300, -1e300, 5e-324, 0.0, -1.0, 1e9, 60.0, -0.05)
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
