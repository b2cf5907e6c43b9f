"""The plant of its own kind holds by its law of friction, and what is wrong with a sensor spoils it alone."""

import math
from dataclasses import replace

import numpy as np
import pytest

from .channels import FAULTS
from .grasp import (
    FELT,
    WORLDS,
    Case,
    Channel,
    Occurrence,
    Sensors,
    draw,
    load_course,
    without_a_channel,
)
from .pairs import NAMED, PAIRS, all_pairs, draw_pair
from .plant import DEPTH, FORCE, FORCE_Y, PATH, SPEED, Array, Make, Plant
from .sensors import COLUMNS, SENSOR_FAULTS, columns_of

WOOD = Make(mu=0.33, exponent=0.25, load=0.25 * 9.81)
"""Two silicone pads on wood: friction of 70 lifts, and the lightest of their objects."""
EVEN = Make(fingers=5, spread=0.0)


def pressed(make: Make, squeeze: float, load: float, seconds: float = 1.0) -> Plant:
    """Return a plant that is pressed evenly and loaded within half that time; forces in N."""
    plant, before, steps = Plant(make), np.zeros(2), round(seconds * 200)
    n = make.fingers
    drives, same = np.array([squeeze, *[squeeze / (n - 1)] * (n - 1)]), (np.ones(n), np.ones(n))
    for k in range(steps):
        after = np.array([0.0, -load * min(2.0 * (k + 1) / steps, 1.0)])
        plant.advance(0.005, drives, same, np.array([before, after]))
        before = after
    return plant


@pytest.mark.parametrize("make", [EVEN, replace(EVEN, exponent=0.33), replace(EVEN, fingers=2), WOOD])
@pytest.mark.parametrize(("part", "holds"), [(1.03, True), (0.97, False)])
def test_the_least_squeeze_is_the_least(make: Make, part: float, holds: bool) -> None:
    make = replace(make, spread=0.0)
    squeeze = part * float(Plant(make).least_squeeze(np.array(make.load), np.ones(make.fingers)))
    plant = pressed(make, squeeze, make.load)
    assert plant.rows[0, FORCE] == pytest.approx(squeeze, rel=1e-3)
    assert (plant.slid.min() < 1e-6) == holds


@pytest.mark.parametrize("squeeze", [0.5, 5.0, 10.0])
def test_what_a_sliding_finger_carries_over_its_force_falls_with_the_force_by_the_power(
    squeeze: float,
) -> None:
    plant = pressed(replace(WOOD, spread=0.0, mu=0.4), squeeze, load=20.0, seconds=0.2)
    assert plant.rows[:, FORCE] == pytest.approx(squeeze, rel=0.05)
    ratio = np.abs(plant.rows[:, FORCE_Y]) / plant.rows[:, FORCE]
    assert ratio == pytest.approx(0.4 * (plant.rows[0, FORCE] / 5.0) ** -0.25, rel=1e-3)


def test_without_an_exponent_the_plant_is_that_of_constant_friction() -> None:
    """Numbers of the plant before it had one: held, slid and pressed."""
    plant = Plant(Make(fingers=3, mu=0.4, kinetic=0.9))
    for k in range(200):
        load = np.array([[0.0, -0.0026 * k], [0.0, -0.0026 * (k + 1)]])
        plant.advance(0.005, np.array([0.6, 0.3, 0.3]), (np.ones(3),) * 2, load)
    assert plant.rows[:, [FORCE_Y, PATH, DEPTH]] == pytest.approx(np.array(BEFORE), rel=1e-12)


BEFORE = [
    [-0.22558206825993082, 0.002580925152327899, 0.0007704951539212916],
    [-0.10798227828674971, 0.0025841387220053966, 0.0004409439277135259],
    [-0.10110551300553089, 0.002584598590343796, 0.0004867016403548012],
]


def test_old_seeds_draw_what_they_drew() -> None:
    case = draw(np.random.default_rng([3, 7]), world=WORLDS["old"])
    assert (case.fault, case.seed, case.make.seed, case.rises) == ("biased", 9751, 6978, 15)
    assert case.make.mu == pytest.approx(0.7216409451796533, rel=1e-12)
    assert (case.make.exponent, case.tangential_gain) == (0.0, 1.0)


def test_real_hands_are_drawn_over_the_whole_range_of_friction_exponent_and_gain() -> None:
    cases = [draw(np.random.default_rng([seed, 7])) for seed in range(400)]
    for values, low, high in (
        ([case.make.mu for case in cases], 0.2, 1.1),
        ([case.make.exponent for case in cases], 0.0, 0.33),
        ([case.tangential_gain for case in cases], 0.8, 1.05),
    ):
        assert low <= min(values) < low + 0.02 * (high - low)
        assert high - 0.02 * (high - low) < max(values) <= high


def test_a_load_that_is_drawn_can_be_held_with_15_newtons() -> None:
    for seed in range(100):
        case = draw_pair(np.random.default_rng([seed, 8]))
        most = np.hypot(*load_course(case).T).max()
        assert Plant(case.make).least_squeeze(most, np.ones(case.make.fingers)) < 15.0


def measured(case: Case, times: list[float]) -> Array:
    """Return what is measured of fingers that press and carry alike, (times, fingers, 9)."""
    sensors, rows = Sensors(case), Plant(case.make).rows
    values, noise = np.full((case.make.fingers, 9), math.nan), np.full((case.make.fingers, 6), 0.01)
    found = []
    for t in times:
        rows[:] = np.arange(1.0, 1.0 + rows.shape[1]) + 0.01 * t
        sensors.measure(t, rows, noise, values)
        found.append(values.copy())
    return np.array(found)


def test_a_tangential_gain_scales_what_is_felt_of_tangential_forces_alone() -> None:
    plain, low = measured(Case(), [1.0])[0], measured(Case(tangential_gain=0.8), [1.0])[0]
    assert low[:, 1:3] - 0.01 == pytest.approx(0.8 * (plain[:, 1:3] - 0.01))
    others = [column for column in FELT if column not in (1, 2)]
    assert np.array_equal(low[:, others], plain[:, others])


@pytest.mark.parametrize("fault", SENSOR_FAULTS)
def test_a_fault_of_a_sensor_spoils_its_own_channel_of_its_own_finger_from_its_start_on(fault: str) -> None:
    times = [2.0, *np.linspace(5.0, 40.0, 50).tolist()]
    case = Case(also=(Occurrence(fault, 4.0, (1,)),))
    sound, spoilt = measured(Case(), times), measured(case, times)
    changed = ~np.isclose(spoilt, sound, rtol=1e-9, atol=0.0, equal_nan=True)
    assert not changed[0].any()
    assert not changed[:, 0].any()
    assert {column for column in range(9) if changed[:, 1, column].any()} <= set(columns_of(fault))
    assert changed[1:, 1].any()


def test_a_second_fault_of_a_slip_channel_spoils_what_the_first_has_left() -> None:
    """The thumb's is dead, and then a random speed is added to what it says; the index finger is sound."""
    both = Case(fault="dead", which=(0,), also=(Occurrence("biased", 1.0, (0,)),))
    channel, rows = Channel(both, np.random.default_rng(1)), Plant(both.make).rows
    rows[:, SPEED] = 3e-3
    said = [channel.say(0.005 * k, rows, np.zeros(2)) for k in range(300)]
    assert said[100] == [(0.0, 0.0), (1.0, 3e-3)]
    assert said[299] == [(0.0, 5e-3), (1.0, 3e-3)]


def test_the_grip_without_a_channel_has_the_faults_of_the_other_sensors() -> None:
    case = Case(fault="dead", also=(Occurrence("normal-stuck", 3.0), Occurrence("stuck", 1.0)))
    bare = without_a_channel(case)
    assert [one.fault for one in bare.slip_faults] == ["absent"]
    assert bare.sensor_faults == case.sensor_faults
    assert bare.after == 5.0  # the first fault began at once
    assert without_a_channel(replace(case, start=2.5)).after == 6.0


def test_all_pairs_are_every_two_of_the_named_faults() -> None:
    assert len(NAMED) == len(FAULTS) - 1 + 8 * len(COLUMNS)
    cases = all_pairs([0.15, 1.1])
    assert len(cases) == 2 * len(PAIRS)
    assert len({frozenset(pair) for pair in PAIRS}) == len(PAIRS)
    assert len(PAIRS) == math.comb(len(NAMED), 2) - (len(FAULTS) - 2)  # "absent" beside another
    assert {tuple(one.fault for one in case.faults) for case in cases} == set(PAIRS)
    assert {round(case.make.mu, 9) for case in cases} == {0.15, 1.1}
