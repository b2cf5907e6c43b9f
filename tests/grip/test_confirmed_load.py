"""A lone wrong sample of a load raises a grip by little, and a load that is there waits for one sample."""

import math
from dataclasses import replace

import numpy as np
import pytest

from vegrip.grip.confirmed_load import CONFIRM_SIZE, confirm_load
from vegrip.grip.controller import GripController
from vegrip.grip.policies.margin_grip import GripSettings
from vegrip.grip.settings import ControlSettings
from vegrip.messages import FingertipState
from vegrip.model import paper_model

NOISE, TORQUE_NOISE = 0.01, 1e-4  # [N], [N m]
MOST = 1.5  # times the command, by a lone sample
FINGERS = ("thumb", "index")
PERIOD = 2_000_000  # [ns]
Load = tuple[float, float, float]


def counted(loads: list[Load], at: int = 0) -> list[Load]:
    """Return as what each of (x, y, torque) counts."""
    q = [math.nan] * (at + CONFIRM_SIZE)
    return [confirm_load(q, at, *load, NOISE, TORQUE_NOISE) for load in loads]


@pytest.mark.parametrize("off", [(9.0, 0.0, 0.0), (0.0, -9.0, 0.0), (0.0, 0.0, 1.9), (-59.0, 59.0, -1.9)])
def test_a_lone_sample_counts_for_no_more_than_a_band_and_the_next_one_in_full(off: Load) -> None:
    load = (0.3, -0.4, 5e-3)
    wrong = (load[0] + off[0], load[1] + off[1], load[2] + off[2])
    told = counted([load, load, wrong, load, load])
    band = 0.25 * 0.5 + 6.0 * NOISE
    bands = band, band, 0.25 * 5e-3 + 6.0 * TORQUE_NOISE
    for value, before, most in zip(told[2], load, bands, strict=True):
        assert abs(value - before) <= most * (1.0 + 1e-12)
    assert told[3] == pytest.approx(load, rel=0.3)
    assert told[4] == load


@pytest.mark.parametrize("step", [(3.0, 0.0, 0.0), (0.0, 4.0, 0.0), (0.0, 0.0, 0.1), (-0.3, 0.4, -5e-3)])
def test_a_load_that_stays_counts_in_full_with_its_second_sample(step: Load) -> None:
    load = (0.3, -0.4, 5e-3)
    risen = (load[0] + step[0], load[1] + step[1], load[2] + step[2])
    assert counted([load, load, risen, risen])[-1] == pytest.approx(risen)


@pytest.mark.parametrize("rate", [50, 200, 1000])
def test_a_load_that_rises_by_half_within_a_tenth_of_a_second_counts_at_once(rate: int) -> None:
    rng = np.random.default_rng(rate)
    size = 1.0 + 0.5 * np.clip(np.arange(rate) / rate - 0.4, 0.0, 0.1) / 0.1
    loads = [(0.6 * s + NOISE * e, -0.8 * s + NOISE * d, 0.0) for s, (e, d) in
             zip(size, rng.standard_normal((rate, 2)), strict=True)]  # fmt: skip
    assert counted(loads) == loads


def test_without_a_band_it_is_the_median_of_three() -> None:
    values = np.random.default_rng(3).standard_normal(500)
    q, told = [math.nan] * CONFIRM_SIZE, []
    for value in values:
        before = [q[0], q[3]]
        confirm_load(q, 0, value, 0.0, 0.0, -0.25 / 6.0 * math.hypot(*q[:2]), 0.0)
        told.append((q[0], sorted([*before, value])[1]))
    got, median = np.array(told[1:]).T
    assert got == pytest.approx(median, abs=1e-12)


def test_what_is_not_a_number_counts_as_that_and_the_sample_after_it_as_it_is() -> None:
    load, nothing = (0.3, -0.4, 5e-3), (math.nan, -0.4, math.nan)
    told = counted([load, nothing, (5.0, -0.4, 0.1)], at=3)
    assert math.isnan(told[1][0])
    assert math.isnan(told[1][2])
    assert told[2] == (5.0, -0.4, 0.1)


def states(number: int, values: dict[str, float]) -> list[FingertipState]:
    """Return what both fingers of a pinch of 3 N feel, with ``values`` in the place of its own."""
    wobble = 1e-2 * math.sin(1.7 * number)
    felt = {
        "normal_force": 3.0 + wobble, "displacement": DEPTH + 5e-4 * wobble, "torque_z": 1e-2 * wobble,
        "tangential_force_x": 0.5 + 0.3 * wobble, "tangential_force_y": 0.3 * wobble, "temperature": 25.0,
        "slip": 0.0, "slip_speed": 0.0,
    }  # fmt: skip
    return [FingertipState(number * PERIOD, name, number, **(felt | values)) for name in FINGERS]


MODEL = paper_model(8e-3)
DEPTH = (3.0 / (MODEL.simulate([0.0, 1.0], [0.0, 1e-3]).normal_force[-1] / 1e-3**1.5)) ** (1.0 / 1.5)


@pytest.mark.parametrize("lag", [0.0, 0.01, 0.03])
@pytest.mark.parametrize("leap", [False, True], ids=["all", "one"])
def test_a_lone_sample_of_any_channel_raises_the_command_by_half_at_most(lag: float, leap: bool) -> None:
    grip = replace(GripSettings(), drive_lag=lag)
    hand = GripController(FINGERS, model=MODEL, settings=ControlSettings(grip=grip))
    wrong = [
        {"tangential_force_x": 5.0}, {"tangential_force_x": -59.0}, {"tangential_force_y": 2.0},
        {"torque_z": 0.02}, {"torque_z": -1.9}, {"normal_force": 0.0}, {"normal_force": 59.0},
        {"displacement": 0.0}, {"displacement": 9e-3}, {"slip": 1.0}, {"slip_speed": 0.5},
        {"slip": 1.0, "slip_speed": 0.5}, {"temperature": 99.0},
    ]  # fmt: skip
    gap, before, largest = 150, 0.0, 0.0
    for number in range(gap * (len(wrong) + 1)):
        part, at = number % gap, number // gap - 1
        values = wrong[at] if part == 0 and at >= 0 else {}
        felt = states(number, {})
        felt[: 1 if leap else 2] = states(number, values)[: 1 if leap else 2]
        commands = {one.finger: one.normal_force for one in hand.step(felt, number * PERIOD)}
        if part == gap - 1:
            before = max(commands.values())
        if at >= 0 and part < gap // 2:
            largest = max(largest, max(commands.values()) / before)
    assert largest <= MOST


def test_a_load_that_is_there_is_answered_from_its_second_sample_on() -> None:
    hand = GripController(FINGERS, model=MODEL)
    needed = []
    for number in range(1000):
        values = {"tangential_force_x": 1.0} if number >= 990 else {}
        hand.step(states(number, values), number * PERIOD)
        needed.append(hand.fingers["thumb"].memory["GRIP_REQUIRED"])
    # the need grows faster than the load, and its uncertainty with the distance from where friction is stated
    assert needed[990] < 1.25 ** (1.0 / (1.0 - 0.15)) * needed[989] * 1.03
    assert needed[991] > 1.5 * needed[989]
    assert needed[991] == pytest.approx(needed[999], rel=0.01)
