"""Friction of a virtual tip falls with the normal force by the power that is set, without one not at all."""

from dataclasses import replace

import numpy as np
import pytest

from tests.virtual.build import tips_of
from vegrip.trials.closed_loop import GRASPS
from vegrip.virtual import FingertipSettings, HandSettings, VirtualHand, kernels
from vegrip.virtual.bench.protocol import slip
from vegrip.virtual.bench.trial import run_trial
from vegrip.virtual.settings import SensorSettings

MU, G = 0.5, 0.3


@pytest.mark.parametrize("force", [0.0, 1e-9, 0.37, 5.0, 19.3])
@pytest.mark.parametrize("factor", [1.0, 0.7])
def test_without_an_exponent_friction_is_that_of_the_surface_to_the_bit(force: float, factor: float) -> None:
    (tip,) = tips_of(1, friction=0.83, force=force)
    assert kernels.friction_of(tip, factor) == factor * 0.83


def test_friction_is_the_stated_one_at_five_newtons_and_goes_with_the_power_of_the_force() -> None:
    at = {
        N: kernels.friction_of(tips_of(1, friction=MU, friction_exponent=G, force=N)[0], 1.0)
        for N in (1, 5, 20)
    }
    assert at[5] == MU
    assert at[1] / at[20] == pytest.approx(20.0**G)


def pinch(exponent: float) -> HandSettings:
    """Return two fingers of one friction that hold a plate in its centre of mass."""
    hand = GRASPS["pinch"]
    return replace(
        hand, spread=0.0, tip=replace(hand.tip, friction=MU, friction_exponent=exponent),
        plate=replace(hand.plate, mass=0.25, offset_x=0.0, offset_y=0.0),
    )  # fmt: skip


@pytest.mark.parametrize("exponent", [0.0, G])
@pytest.mark.parametrize(("part", "holds"), [(1.03, True), (0.97, False)])
def test_the_hand_holds_with_the_least_force_of_the_law(exponent: float, part: float, holds: bool) -> None:
    """``m g = 2 mu (N / 5 N)^-g N``."""
    settings = pinch(exponent)
    weight = settings.plate.mass * settings.plate.gravity
    least = 5.0 * (weight / (2.0 * MU * 5.0)) ** (1.0 / (1.0 - exponent))
    hand = VirtualHand(settings, seed=1)
    hand.step(1.1, {"thumb": 3.0, "index": 3.0})
    pressed = 0.0
    while not hand.dropped and hand.time < 4.0:
        pressed = hand.truth("index").normal_force
        hand.step(0.05, {"thumb": part * least, "index": part * least})
    assert pressed == pytest.approx(part * least, abs=0.015)  # the drives rest within 0.01 N
    assert hand.dropped != holds
    assert (hand.slips == 0) == holds


@pytest.mark.parametrize("exponent", [0.0, G])
def test_a_tip_on_the_bench_slides_at_its_friction_at_the_force(exponent: float) -> None:
    tip = FingertipSettings(friction=MU, friction_exponent=exponent)
    exact = SensorSettings(
        normal_force=0.0, tangential_force=0.0, force_bias=0.0, force_step=0.0, displacement_bias=0.0
    )
    for force in (0.8, 8.0):
        told = run_trial(tip, [slip(force, 0.2, pull=5e-3)], exact, truth=False).columns
        slides = told["slip"] > 0.0
        pull = np.hypot(told["tangential_force_x"], told["tangential_force_y"])[slides]
        assert len(pull) > 100
        assert pull / told["normal_force"][slides] == pytest.approx(MU * (force / 5.0) ** -exponent, rel=0.01)
