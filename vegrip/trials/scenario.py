"""What the hand of the demonstration goes through: an object of unknown friction, and disturbances.

Everything follows from one seed, and nothing of it depends on the controller:

* the object's surface: nominal friction coefficient between 0.45 and 1.0, which no controller is told;
* pushes, twists, slow loads, shaking, added mass and turns at random times
  (:func:`vegrip.virtual.disturbances`);
* once, in the second half, the faces get wet: friction falls by 10 % to 40 % for some seconds.

Two grasps: the whole ``hand`` around 0.3 kg, whose five contacts share a torque by tangential forces; and a
``pinch`` of thumb and index on 0.1 kg, where each contact must carry torsion itself.
"""

from dataclasses import dataclass, replace

import numpy as np

from vegrip.virtual import Disturbance, HandSettings, VirtualHand, disturbances
from vegrip.virtual.disturbance import Wetting

SETTLED_S = 1.0
"""[s] from here on the hand carries the object by itself; figures of the comparison start here."""

FRICTION_RANGE = (0.45, 1.0)
WETTING = (0.6, 0.9)

_HAND = HandSettings()
GRASPS = {
    "hand": _HAND,
    "pinch": replace(
        _HAND,
        fingers=("thumb", "index"),
        x=(0.0, 0.0),
        y=(0.0, 0.0),
        plate=replace(_HAND.plate, mass=0.1, inertia=1e-4),
    ),
}


CORES_OF_THE_HAND = 4
"""Hand, node, bus and screen of five fingers at 500 Hz together; with fewer cores states come too late."""


def fitting_grasp(cores: int) -> str:
    return "hand" if cores >= CORES_OF_THE_HAND else "pinch"


@dataclass(frozen=True)
class Scenario:
    """One object and its fate."""

    seed: int
    duration: float  # [s]
    grasp: str = "hand"  # one of GRASPS
    relaxes_slowly: bool = True  # the tips have a second relaxation, which the model of no controller has
    names: tuple[str, ...] = ()  # of the first fingers of the grasp, which has no others; () = its own

    @property
    def settings(self) -> HandSettings:
        """The hand, with the friction of this object."""
        rng = np.random.default_rng([self.seed, 2])
        hand = GRASPS[self.grasp]
        tip = hand.tip if self.relaxes_slowly else hand.tip.with_one_rate()
        if self.names:
            n = len(self.names)
            hand = replace(hand, fingers=self.names, x=hand.x[:n], y=hand.y[:n])
        return replace(hand, tip=replace(tip, friction=float(rng.uniform(*FRICTION_RANGE))))

    @property
    def events(self) -> tuple[Disturbance, ...]:
        plate = self.settings.plate
        events = disturbances(self.seed, self.duration, weight=plate.mass * plate.gravity)
        return tuple(sorted((*events, *self._wetting()), key=lambda event: event.start))

    def hand(self) -> VirtualHand:
        return VirtualHand(self.settings, self.seed, self.events)

    def _wetting(self) -> tuple[Disturbance, ...]:
        rng = np.random.default_rng([self.seed, 3])
        start, factor = float(rng.uniform(0.5, 0.7)) * self.duration, float(rng.uniform(*WETTING))
        return (Wetting(start, 0.2 * self.duration, factor),)
