"""The margin grip: up at once, down slowly, quiet in between."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.grip.stages import Policy, margin_grip
from vegrip.grip.policies.demand import Demand
from vegrip.grip.policies.margin_grip import GripSettings
from vegrip.messages import Reason

DT = 0.002
SETTINGS = GripSettings(
    wanted_margin=0.2, dead_band=0.05, release_time=1.0, settle_time=0.3, usual_time=0.0, slip_growth=5.0
)


def need(force: float, bound: float = 0.1, **changes: bool) -> Demand:
    given = {"in_contact": True, "trusted": True} | changes
    return Demand(least_force=force, tangential_force=1.0, margin_bound=bound, **given)


LARGEST = 60.0  # [N] that the limits let through


def run(grip: Policy, demand: Demand, held: float, seconds: float) -> tuple[float, set[Reason]]:
    reasons = set()
    for _ in range(round(seconds / DT)):
        held, reason = grip.wanted(min(held, LARGEST), demand, DT)
        reasons.add(reason)
    return held, reasons


def test_of_a_demand_nothing_is_known_that_is_not_said() -> None:
    numbers = (Demand().least_force, Demand().tangential_force, Demand().torque, Demand().margin_bound)
    assert all(map(math.isnan, numbers))
    assert True not in (Demand().in_contact, Demand().slipping, Demand().trusted)


def test_a_greater_need_is_met_at_once() -> None:
    assert margin_grip(SETTINGS).wanted(2.0, need(5.0), DT) == (5.0, Reason.RAISE)


def test_a_need_that_only_the_forecast_has_says_so() -> None:
    assert margin_grip(SETTINGS).wanted(2.0, need(5.0, bound=0.3), DT) == (5.0, Reason.FORECAST)


def test_nothing_is_lowered_while_the_rise_settles() -> None:
    grip = margin_grip(SETTINGS)
    held, _ = grip.wanted(2.0, need(5.0), DT)
    held, reasons = run(grip, need(1.0), held, 0.28)
    assert held == 5.0
    assert reasons == {Reason.HOLD}


def test_the_rest_before_a_fall_counts_from_the_last_rise_or_slip_and_ends_to_the_step() -> None:
    """Half a second in steps of a sixteenth; a need that equals what is held is no rise."""
    for rise, steps in ((need(5.0), 7), (need(5.0, slipping=True), 7), (None, 0)):
        grip = margin_grip(replace(SETTINGS, settle_time=0.5, dead_band=0.0))
        held = 5.0 if rise is None else grip.wanted(4.0, rise, 0.0625)[0]
        if rise is None:
            assert {grip.wanted(held, need(held), 0.0625) for _ in range(8)} == {(held, Reason.HOLD)}
        told = [grip.wanted(held, need(1.0), 0.0625)[1] for _ in range(9)]
        assert told == [Reason.HOLD] * steps + [Reason.LOWER] * (9 - steps)


def test_lowering_follows_the_release_time() -> None:
    """The envelope falls as exp(-t / release_time) after the settling time; the command is one play above."""
    grip = margin_grip(SETTINGS)
    held, _ = grip.wanted(2.0, need(5.0), DT)
    held, _ = run(grip, need(1.0), held, 0.3 + 2.0)
    envelope = 1.0 + 4.0 * math.exp(-2.0)
    assert held == pytest.approx(envelope / 0.95, rel=5e-3)


def test_the_command_never_falls_below_the_need() -> None:
    grip = margin_grip(SETTINGS)
    held, rng = 1.0, np.random.default_rng(1)
    for wanted in 3.0 + np.cumsum(rng.normal(0.0, 0.05, 4000)):
        held, _ = grip.wanted(held, need(abs(wanted)), DT)
        assert held >= abs(wanted)


def test_noise_within_the_dead_band_never_reaches_the_actuator() -> None:
    grip = margin_grip(SETTINGS)
    noise = np.random.default_rng(2).normal(0.0, 0.015, 500)  # the same every second: no new extremes
    needs = 4.0 * (1.0 + np.tile(noise.clip(-0.04, 0.04) / 4.0, 10))
    held, commands = float(needs[0]), []
    for wanted in needs:
        held, _ = grip.wanted(held, need(float(wanted)), DT)
        commands.append(held)
    assert len(set(commands[2500:])) == 1


def test_felt_slip_raises_the_grip_whatever_the_model_says() -> None:
    grip = margin_grip(SETTINGS)
    held, reasons = run(grip, need(1.0, slipping=True), 4.0, 0.1)
    assert held == pytest.approx(4.0 * (1.0 + 5.0 * DT) ** 50)
    assert reasons == {Reason.SLIP}


def test_felt_slip_raises_the_grip_without_a_trusted_estimate() -> None:
    force, reason = margin_grip(SETTINGS).wanted(4.0, Demand(slipping=True), DT)
    assert force > 4.0
    assert reason == Reason.SLIP


def test_an_untrusted_estimate_holds() -> None:
    assert margin_grip(SETTINGS).wanted(4.0, need(1.0, trusted=False), DT) == (4.0, Reason.UNTRUSTED)


def test_in_the_air_the_grip_opens_slowly() -> None:
    held, reasons = run(margin_grip(SETTINGS), need(math.nan, in_contact=False), 4.0, 1.3)
    assert held == pytest.approx(4.0 * math.exp(-1.0) / 0.95, rel=0.01)
    assert Reason.LOWER in reasons


USUAL = GripSettings(wanted_margin=0.2, dead_band=0.05, release_time=1.0, settle_time=0.3)


@pytest.mark.parametrize("wrong", [0.0, 0.5, 1.9, 8.0, math.inf])
@pytest.mark.parametrize("seconds", [DT, 10 * DT, 1.0])
def test_a_need_that_is_wrong_for_a_second_neither_lets_the_grip_down_nor_keeps_it_up(
    wrong: float, seconds: float
) -> None:
    grip = margin_grip(USUAL)
    held, _ = run(grip, need(2.0), 2.0, 3.0)
    usual = held
    held, _ = run(grip, need(wrong), held, seconds)
    assert held >= usual
    held = min(held, 15.0)  # what the limits let through
    after, _ = run(grip, need(2.0), held, 0.5)
    assert after < 15.0
    assert run(grip, need(2.0), after, 4.0)[0] >= usual


def test_a_need_that_has_fallen_for_good_is_followed() -> None:
    grip = margin_grip(USUAL)
    held, _ = run(grip, need(5.0), 5.0, 3.0)
    held, _ = run(grip, need(1.0), held, 8.0)
    assert held < 1.1


def test_a_need_that_was_usual_before_is_gone_back_to_at_once() -> None:
    """After a burst of 2 s the grip goes back to the need of before; where no slide is noticed it waits."""
    held_after = {}
    for learning in (False, True):
        grip = margin_grip(replace(SETTINGS, usual_time=2.5, release_time=0.1), learning=learning)
        held, _ = run(grip, need(2.0), 2.0, 4.0)
        held, _ = run(grip, need(5.0), held, 2.0)
        held_after[learning], _ = run(grip, need(2.0), held, 0.8)
    assert held_after[True] < 2.5
    assert held_after[False] == pytest.approx(5.0, rel=0.06)


def test_a_need_lower_than_any_before_still_has_to_last() -> None:
    """A sensor that says there is no load for a second does not let the grip down."""
    grip = margin_grip(replace(SETTINGS, usual_time=2.5, release_time=0.1), learning=True)
    held, _ = run(grip, need(2.0), 2.0, 5.0)
    held, _ = run(grip, need(0.1), held, 1.0)
    assert held >= 0.99 * 2.0


@pytest.mark.parametrize(("learning", "growth"), [(False, 5.0), (True, 0.7)])
def test_a_finger_that_learns_with_others_grows_at_a_slide_of_the_object_and_alone_at_its_own_slip(
    learning: bool, growth: float
) -> None:
    settings = replace(SETTINGS, slip_growth=5.0, slide_growth=0.7)
    grip = margin_grip(settings, learning=learning)
    held, reason = grip.wanted(4.0, need(1.0, slipping=True), DT)
    assert (held, reason) == (pytest.approx(4.0 * (1.0 + growth * DT), rel=1e-12), Reason.SLIP)
