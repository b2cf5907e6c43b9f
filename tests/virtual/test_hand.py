"""The whole hand: equilibrium, margins, slips, commands, repeatability."""

import math
from dataclasses import replace

import numpy as np
import pytest

from vegrip.errors import UsageError
from vegrip.virtual import HandSettings, VirtualHand, disturbances
from vegrip.virtual.disturbance import AddedMass, SlowLoad
from vegrip.virtual.fingertip import even_grid, utilisation
from vegrip.virtual.settings import ActuatorSettings, ObjectSettings, SensorSettings, ThermalSettings

CALM = HandSettings(sensor=SensorSettings(rate=100.0))
WEIGHT = CALM.plate.mass * CALM.plate.gravity


def grip(hand: VirtualHand, force: float, duration: float, dt: float = 0.01) -> None:
    command = dict.fromkeys(hand.fingers[1:], force)
    for _ in range(round(duration / dt)):
        hand.step(dt, command)


def truths(hand: VirtualHand):
    return [hand.truth(finger) for finger in hand.fingers]


def test_normal_forces_balance_and_follow_the_command() -> None:
    hand = VirtualHand(CALM)
    grip(hand, 2.0, 3.0)
    thumb, *others = truths(hand)
    assert thumb.normal_force == pytest.approx(sum(t.normal_force for t in others), rel=1e-9)
    for truth in others:
        assert truth.normal_force == pytest.approx(2.0, abs=2.0 * CALM.actuator.stiction)


def test_friction_carries_exactly_the_weight() -> None:
    hand = VirtualHand(CALM)
    grip(hand, 2.0, 3.0)
    assert sum(t.tangential_force_y for t in truths(hand)) == pytest.approx(-WEIGHT, rel=1e-5)
    thumb, *others = truths(hand)
    # the frame of the thumb looks the other way
    assert thumb.tangential_force_x == pytest.approx(sum(t.tangential_force_x for t in others), abs=1e-5)


def test_object_stays_where_it_is_while_the_margin_is_ample() -> None:
    hand = VirtualHand(CALM)
    grip(hand, 2.5, 3.0)
    before = hand.shift.copy()
    grip(hand, 2.5, 5.0)
    assert min(t.margin for t in truths(hand)) > 0.3
    assert np.abs(hand.shift - before)[:2].max() < 5e-6  # only the stiffness of the contacts creeps
    assert hand.slips == 0


def test_object_slips_when_the_grip_falls_below_the_least_force_of_the_patches() -> None:
    """The grip is lowered slowly; the limit follows from Coulomb on two faces: 2 mu N = weight."""
    settings = replace(CALM, spread=0.0, plate=ObjectSettings(offset_x=0.0, offset_y=0.0))
    hand = VirtualHand(settings)
    mu = settings.tip.friction
    least = WEIGHT / (2.0 * mu) / 4.0
    grip(hand, 1.05 * least + settings.actuator.stiction, 3.0)
    assert not hand.dropped
    assert hand.tips["slip_distance"].max() < 1e-3
    grip(hand, 0.9 * least - settings.actuator.stiction, 3.0)
    assert hand.slips >= 1
    assert hand.dropped


@pytest.mark.parametrize("seed", [0, 1])
def test_friction_never_exceeds_the_limit_of_the_patch(seed) -> None:
    settings = replace(CALM, rings=12, spokes=24)
    hand = VirtualHand(settings, seed, disturbances(seed, 8.0, start=1.0, pause=0.5))
    for _ in range(400):
        grip(hand, 0.9, 0.02)
        assert max(t.utilisation for t in truths(hand)) <= 1.0 + 5e-3
        f = np.hypot(hand.tips["pull_x"], hand.tips["pull_y"])
        limit = np.array([t.friction_coefficient * t.normal_force for t in truths(hand)])
        assert np.all(f <= limit * (1.0 + 1e-9) + 1e-12)
        if hand.dropped:
            break


def test_margin_falls_with_the_load_and_slip_comes_where_it_is_zero() -> None:
    hand = VirtualHand(CALM, events=(SlowLoad(2.0, 10.0, 0.0, -3.0 * WEIGHT),))
    grip(hand, 1.5, 2.0)
    previous = 1.0
    while hand.slips == 0 and hand.time < 10.0:
        grip(hand, 1.5, 0.25)
        lowest = min(t.margin for t in truths(hand))
        assert lowest <= previous + 0.02
        previous = lowest
    assert hand.slips == 1
    assert previous < 0.02


def test_same_seed_same_run_bit_for_bit() -> None:
    def run(seed):
        hand = VirtualHand(CALM, seed, disturbances(5, 4.0, start=0.5, pause=0.5))
        command = dict.fromkeys(hand.fingers[1:], 2.0)
        return [repr(state) for _ in range(300) for state in hand.step(0.01, command)]  # NaN differs from NaN

    assert run(3) == run(3)
    assert run(3) != run(4)


def test_how_time_is_cut_into_calls_does_not_matter() -> None:
    one, many = VirtualHand(CALM, 2), VirtualHand(CALM, 2)
    command = dict.fromkeys(one.fingers[1:], 2.0)
    states = repr(one.step(1.5, command))
    assert repr([s for _ in range(500) for s in many.step(0.003, command)]) == states


def test_states_come_at_the_rate_of_the_sensors() -> None:
    hand = VirtualHand(HandSettings(sensor=SensorSettings(rate=500.0)))
    states = hand.step(1.0, {})
    assert len(states) == 5 * 500
    stamps = [s.stamp for s in states if s.finger == "index"]
    assert np.diff(stamps) == pytest.approx(2_000_000)
    assert [s.seq for s in states if s.finger == "index"] == list(range(1, 501))


def test_finer_simulation_gives_the_same_forces_and_margins() -> None:
    def run(**change):
        hand = VirtualHand(replace(CALM, **change), events=(AddedMass(1.5, 1.0, 0.2),))
        grip(hand, 2.0, 2.0)
        return np.array([(t.normal_force, t.tangential_force_y, t.margin) for t in truths(hand)])

    base = run()
    assert run(step=2.5e-4) == pytest.approx(base, abs=0.01)
    finer = run(rings=24, spokes=48)
    assert finer == pytest.approx(base, abs=0.02)
    assert np.abs(finer - run(rings=12, spokes=24)).max() < 0.6 * np.abs(finer - base).max()


def test_without_command_the_position_is_held_and_the_grip_relaxes() -> None:
    hand = VirtualHand(CALM)
    grip(hand, 3.0, 1.5)
    held = hand.truth("index")
    hand.step(5.0, {})
    later = hand.truth("index")
    assert later.normal_force < 0.97 * held.normal_force
    assert later.normal_force > 0.6 * held.normal_force
    assert not hand.dropped


def test_more_asked_of_the_thumb_makes_all_others_give_more() -> None:
    hand = VirtualHand(CALM)
    command = {**dict.fromkeys(hand.fingers[1:], 1.5), "thumb": 10.0}
    for _ in range(300):
        hand.step(0.01, command)
    assert hand.truth("thumb").normal_force == pytest.approx(10.0, abs=0.1)
    assert hand.truth("ring").normal_force == pytest.approx(2.5, abs=0.03)


def test_object_rests_on_its_stand_while_the_hand_closes() -> None:
    hand = VirtualHand(CALM)
    hand.step(CALM.actuator.close_time, {})
    assert hand.shift == pytest.approx(0.0, abs=1e-9)
    assert hand.truth("index").normal_force == pytest.approx(CALM.actuator.initial_force, abs=0.05)


def test_a_hand_that_does_not_close_drops_its_object_once_and_feels_nothing() -> None:
    hand = VirtualHand(replace(CALM, actuator=ActuatorSettings(initial_force=0.05)))
    states = hand.step(3.0, {})
    assert hand.dropped
    assert hand.slips == 1
    assert all(truth.normal_force == 0.0 and not truth.sliding for truth in truths(hand))
    assert abs(states[-1].normal_force) < 0.1


def test_warming_softens_the_grip_of_a_holding_hand() -> None:
    thermal = ThermalSettings(warming=True, rise=20.0, time=5.0, softening=0.01)
    warm, cold = VirtualHand(replace(CALM, thermal=thermal)), VirtualHand(CALM)
    for hand in (warm, cold):
        grip(hand, 3.0, 1.0)
        hand.step(5.0, {})
    assert warm.truth("index").normal_force < 0.95 * cold.truth("index").normal_force


def test_a_finger_the_hand_does_not_have_is_refused() -> None:
    with pytest.raises(UsageError, match="no finger tail"):
        VirtualHand(CALM).step(0.01, {"tail": 1.0})


def test_one_finger_can_be_lifted_while_the_others_hold() -> None:
    hand = VirtualHand(CALM)
    command = {**dict.fromkeys(hand.fingers[1:], 2.5), "ring": 0.0}
    for _ in range(300):
        hand.step(0.01, command)
    assert hand.truth("ring").normal_force <= CALM.actuator.stiction
    assert not hand.dropped


def test_opening_the_hand_drops_the_object() -> None:
    hand = VirtualHand(CALM)
    grip(hand, 2.0, 1.5)
    grip(hand, 0.0, 1.0)
    assert hand.dropped


def test_two_fingers_are_a_gripper() -> None:
    jaws = replace(CALM, fingers=("left", "right"), x=(0.0, 0.0), y=(0.0, 0.0))
    hand = VirtualHand(jaws)
    grip(hand, 6.0, 3.0)
    assert not hand.dropped
    assert hand.truth("left").normal_force == pytest.approx(6.0, abs=0.05)


@pytest.mark.parametrize("seed", range(3))
def test_states_stay_finite_under_any_command(seed) -> None:
    rng = np.random.default_rng(seed)
    hand = VirtualHand(CALM, seed, disturbances(seed, 4.0, start=0.5, pause=0.4))
    for _ in range(100):
        command = {f: float(rng.choice([0.0, -1.0, 1e9, np.nan, 3.0, 0.5])) for f in hand.fingers}
        for state in hand.step(0.04, command):
            channels = (state.normal_force, state.tangential_force_x, state.torque_z, state.displacement)
            assert np.all(np.isfinite(channels))
        for truth in truths(hand):
            assert 0.0 <= truth.normal_force < 200.0
            assert np.isfinite(truth.utilisation)


def test_the_truth_of_a_contact_is_that_of_its_patch_alone() -> None:
    hand = VirtualHand(HandSettings(), 1, disturbances(1, 4.0, start=1.1, pause=0.3))
    grid = even_grid(hand.settings.rings, hand.settings.spokes)
    for _ in range(30):
        hand.step(0.09, dict.fromkeys(hand.fingers[1:], 2.0))
        for truth in truths(hand):
            most, along = (
                truth.friction_coefficient * truth.normal_force,
                math.hypot(truth.tangential_force_x, truth.tangential_force_y),
            )
            turned = truth.torque_z / (most * truth.contact_radius)
            used = utilisation(grid, truth.pressure_exponent, along / most, turned)
            assert truth.utilisation == pytest.approx(used, rel=1e-12)
            load = math.hypot(along, truth.torque_z / truth.contact_radius)
            assert truth.limit_radius * used == pytest.approx(load, rel=1e-12)
