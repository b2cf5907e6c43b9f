"""An object that still stands shows nothing of its weight: until it is felt, force is not lowered."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from vegrip.grip.controller import GripController
from vegrip.grip.safety import LimitSettings
from vegrip.grip.settings import ControlSettings
from vegrip.messages import FingertipState
from vegrip.model import ContactModel, paper_model

PERIOD_S = 0.002
CLOSED_N = 3.0
FINGERS = ("thumb", "index")
Course = list[tuple[float, float]]  # time [s], command [N]
OfTime = Callable[[float], float]


@pytest.fixture(scope="module")
def model() -> ContactModel:
    return paper_model(8e-3)


def course(
    model: ContactModel,
    felt: Callable[[float, float], float],
    load: OfTime,
    settings: ControlSettings | None = None,
    seconds: float = 4.0,
) -> Course:
    """Return the commands for a pinch; ``felt`` [N] is of time and command, ``load`` [N] of time."""
    hand = GripController(FINGERS, model=model, settings=settings or ControlSettings())
    commands, held = [], 0.0
    for i in range(round(seconds / PERIOD_S)):
        now, noise = i * PERIOD_S, 5e-3 * math.sin(1.7 * i)
        stamp = round(now * 1e9)
        for name in FINGERS:
            state = FingertipState(
                stamp, name, i,
                normal_force=felt(now, held) + noise, tangential_force_x=load(now) + noise,
                tangential_force_y=noise, torque_z=1e-2 * noise, slip=0.0,
            )  # fmt: skip
            hand.answer(state, stamp)
        held = hand.fingers["index"].held
        commands.append((now, held))
    return commands


def at(commands: Course, time: float) -> float:
    return next(force for now, force in commands if now >= time)


def obeyed(gain: float = 1.0) -> Callable[[float, float], float]:
    """A drive that begins at the force of the close."""
    return lambda now, held: CLOSED_N if now < 0.1 else gain * held


def lifted(after: float) -> OfTime:
    return lambda now: 0.0 if now < after else 0.2 * min((now - after) / 0.2, 1.0)


def test_until_a_load_is_felt_the_force_of_the_close_is_kept_and_then_lowered(model: ContactModel) -> None:
    commands = course(model, obeyed(), lifted(2.0))
    assert at(commands, 1.99) == pytest.approx(CLOSED_N, rel=0.02)
    assert at(commands, 3.99) < 0.6 * CLOSED_N


@pytest.mark.parametrize("handed_over", [0.6, 9.9])
def test_a_hand_that_closed_by_itself_hands_its_force_over(model: ContactModel, handed_over: float) -> None:
    """What is commanded counts from then on; or not before the lift."""

    def felt(now: float, held: float) -> float:
        return (
            min(CLOSED_N, 0.4 + 10.0 * now)
            if now < handed_over
            else max(held, CLOSED_N - 60.0 * (now - handed_over))
        )

    commands = course(model, felt, lifted(1.0), seconds=1.2)
    assert at(commands, 0.5) < 0.5 * CLOSED_N
    assert at(commands, 1.1) == pytest.approx(CLOSED_N, rel=0.02)


@pytest.mark.parametrize("gain", [0.8, 1.3])
def test_a_drive_of_another_gain_is_not_asked_for_more_and_more(model: ContactModel, gain: float) -> None:
    commands = course(model, obeyed(gain), lifted(9.0), seconds=3.0)
    assert CLOSED_N * 0.98 < max(force for _, force in commands) < 1.02 * CLOSED_N * max(gain, 1.0)


def test_an_object_that_is_gone_and_comes_again_stands_again(model: ContactModel) -> None:
    def felt(now: float, held: float) -> float:
        return 0.0 if 1.5 < now < 2.5 else CLOSED_N if now < 3.5 else held

    def load(now: float) -> float:
        return lifted(0.5)(now) if now < 1.5 else 0.0

    commands = course(model, felt, load)
    assert at(commands, 3.99) >= at(commands, 3.0) > 0.3


def test_a_grip_that_learns_by_lowering_force_keeps_nothing(model: ContactModel) -> None:
    settings = ControlSettings()
    learning = replace(settings, friction=replace(settings.friction, learning=True))
    assert at(course(model, obeyed(), lifted(9.0), learning, seconds=2.0), 1.99) < 0.5 * CLOSED_N


@pytest.mark.parametrize("seed", [29, 34, 167])
def test_a_touch_within_the_noise_asks_for_no_more_than_its_load_needs(seed: int) -> None:
    """Neither radius nor exponent is known then, of which the one is the wronger the less N is."""
    rng = np.random.default_rng(seed)
    rate, begin = rng.uniform(2.0, 80.0), rng.uniform(0.0, 0.1)  # [N/s], [s]
    limits = LimitSettings(max_force=60.0)
    hand = GripController(
        ("tip",), model=paper_model(25e-3), settings=ControlSettings(thumb="", limits=limits)
    )
    for i in range(150):
        stamp = round(i * PERIOD_S * 1e9)
        force, x, y, torque = rng.standard_normal(4) * [1e-2, 1e-2, 1e-2, 1e-4]
        force += rate * max(i * PERIOD_S - begin, 0.0)
        hand.answer(FingertipState(stamp, "tip", i, force, x, y, torque), stamp)
        assert hand.fingers["tip"].held < 2.0
