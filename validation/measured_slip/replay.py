"""A measured lift as the states of two fingers, through :class:`vegrip.GripController`.

The pads close within 0.5 s, then the weight comes within 0.25 s and stays. They measure normal and tangential
forces and feel no slip. A lift whose force is commanded begins with the measured one and follows the command,
by a drive without a lag, from when the weight is there.
"""

from dataclasses import dataclass, replace

import numpy as np

import vegrip
from validation.measured_slip.levels import Level
from vegrip import FingertipState, GripController
from vegrip.grip.settings import ControlSettings

FINGERS = ("thumb", "index")
TIP_RADIUS = 9e-3  # [m]
RATE = 200  # [Hz]
CLOSED, LIFTS, LIFTED, ENDS = 0.5, 0.5, 0.75, 5.0  # [s]
NOISE = 0.01  # [N] std of each component
STRONGEST = 60.0  # [N] above every force of the table, so that no limit hides what is commanded


@dataclass(frozen=True)
class Replayed:
    """What the controller said at the end."""

    margin: float
    bound: float
    commanded: float  # [N]


def controller() -> GripController:
    """Return a controller with the default settings, but for the largest force."""
    plain = ControlSettings()
    settings = replace(plain, limits=replace(plain.limits, max_force=STRONGEST))
    return GripController(FINGERS, model=vegrip.paper_model(TIP_RADIUS), settings=settings)


def replay(
    hand: GripController,
    level: Level,
    *,
    gain: float = 1.0,
    follows: bool = False,
    seconds: float = ENDS,
    seed: int = 1,
) -> Replayed:
    """Replay one lift.

    Args:
        hand: the controller; it forgets what it knew.
        level: the lift.
        gain: of the tangential channels.
        follows: whether the pads press as commanded, once the object is lifted.
        seconds: how long it takes.
        seed: of the noise.

    """
    hand.reset()
    rng = np.random.default_rng(seed)
    first = hand.fingers[FINGERS[0]]
    for k in range(round(seconds * RATE)):
        t, now = k / RATE, (k + 1) * (1_000_000_000 // RATE)
        pull = gain * level.tangential_force * min(max((t - LIFTS) / (LIFTED - LIFTS), 0.0), 1.0)
        force = first.held if follows and t > LIFTED else level.normal_force * min(t / CLOSED, 1.0)
        hand.step([_state(name, k, now, force, pull, rng) for name in FINGERS], now)
    told = hand.margin(FINGERS[0])
    return Replayed(told.margin.value, told.lower_bound, first.held)


def _state(
    name: str, seq: int, now: int, force: float, pull: float, rng: np.random.Generator
) -> FingertipState:
    noise = NOISE * rng.standard_normal(3)
    return FingertipState(
        now, name, seq, normal_force=force + noise[0],
        tangential_force_x=pull + noise[1], tangential_force_y=noise[2],
    )  # fmt: skip
