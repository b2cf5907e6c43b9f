"""How fingertips are moved in the three styles: laboratory, short presses, grasps in use."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from validation.estimator_coverage.outside import Finger, Segment

STYLES = ("lab", "short", "use")
MAX_DEPTH_RADII = 0.4  # [R] in position control
DEEPEST_BY_FORCE = 0.18  # [R] before creep
RAMP = 0.05  # [s]
Episode = list[Segment]


class Manner(NamedTuple):
    """What a search may choose of a drive; shares in 0 .. 1 of their ranges."""

    haste: float  # closing speed, 1 mm/s to 0.5 m/s
    force: float  # of the presses, 0.5 to 8 N
    seed: int  # of all else


def drive(style: str, finger: Finger, manner: Manner) -> tuple[list[Episode], float]:
    """Return the episodes of a life, and the height [m] in the air where each begins."""
    rng = np.random.default_rng(manner.seed)
    air = -rng.uniform(5e-5, 3e-4)
    mover = Mover(finger, air, manner, rng)
    makers = {"lab": mover.laboratory, "short": mover.short, "use": mover.grasps}
    return list(makers[style]()), air


class Mover:
    """Makes episodes for one finger."""

    def __init__(self, finger: Finger, air: float, manner: Manner, rng: np.random.Generator) -> None:
        self.finger, self.air, self.manner, self.rng = finger, air, manner, rng

    def laboratory(self) -> Iterator[Episode]:
        """Holds at three depths, creep, triangles, sines, pulls, a twist, slides, a random press."""
        for scale in (0.3, 1.0, 2.0):
            yield [*self.press(scale), Segment(2.0), *self.release(RAMP)]
        yield [self.wait(), Segment(RAMP, self.newton(), by_force=True), Segment(2.0), *self.release(RAMP)]
        depth = self.depth(1.0)
        yield [
            self.wait(),
            *(Segment(s, to) for s in (2.0, 0.5, 0.1) for to in (depth, self.air)),
            self.wait(),
        ]
        for hertz in (1.0, 5.0):
            yield [*self.press(1.0), Segment(2.0, amplitude=0.3 * depth, hertz=hertz), *self.release(RAMP)]
        for twist in (False, True):
            yield self.slipping(0.5, twist=twist)
            yield self.slipping(0.1, twist=twist)
        yield [*self.press(1.0), Segment(0.05, load=1.5), Segment(1.0, load=1.5), *self.release(RAMP)]
        yield [self.wait(), *self.wander(6), *self.release(RAMP)]

    def short(self) -> Iterator[Episode]:
        """Five presses and five slips."""
        for scale in self.rng.uniform(0.3, 2.0, 5):
            yield [*self.press(scale), Segment(1.5), *self.release(RAMP)]
        for _ in range(5):
            yield self.slipping(self.rng.uniform(0.05, 1.0), twist=bool(self.rng.random() < 0.2))

    def grasps(self) -> Iterator[Episode]:
        """A dozen grasps that close from the air, hold loads, sometimes slip, and open."""
        for _ in range(12):
            speed = 1e-3 * 500.0 ** np.clip(self.manner.haste + self.rng.uniform(-0.3, 0.3), 0.0, 1.0)
            depth, by_force = self.depth(self.rng.uniform(0.3, 1.5)), self.rng.random() < 0.4
            episode = [self.wait(), Segment((depth - self.air) / speed, depth)]
            if by_force:
                grip = self.newton() * self.rng.uniform(0.4, 1.0)
                episode += [Segment(0.2, grip, by_force=True), Segment(0.3, grip, by_force=True)]
            twist, peak = bool(self.rng.random() < 0.25), self.rng.uniform(0.3, 1.2)
            for load in (peak, min(peak, 0.95), 0.2, 0.0):
                grip = self.newton() * self.rng.uniform(0.4, 1.0)
                to = grip if by_force else self.depth(self.rng.uniform(0.3, 1.5))
                moves = self.rng.random() < 0.5
                to = to if moves else grip if by_force else math.nan
                seconds = self.rng.uniform(0.05, 0.8)
                episode.append(Segment(seconds, to, by_force=by_force, load=load, twist=twist))
            yield [*episode, Segment(0.001, twist=False), *self.release(self.rng.uniform(0.02, 0.5))]

    def wait(self) -> Segment:
        """Stay in the air."""
        return Segment(self.rng.uniform(0.1, 0.4))

    def press(self, scale: float) -> Episode:
        """Close by a ramp and settle."""
        return [self.wait(), Segment(RAMP, self.depth(scale)), Segment(0.5)]

    def release(self, seconds: float) -> Episode:
        """Open and stay in the air."""
        return [Segment(seconds, self.air), self.wait()]

    def slipping(self, seconds: float, *, twist: bool) -> Episode:
        """Press, load to slip, slide, let go."""
        slide = [
            Segment(seconds, load=1.05, twist=twist),
            Segment(0.5, load=1.05, twist=twist),
            Segment(0.1, twist=twist),
        ]
        return [*self.press(self.rng.uniform(0.5, 1.5)), *slide, *self.release(RAMP)]

    def wander(self, corners: int) -> Episode:
        """Corner to corner at random, some of them jumps."""
        jumps = self.rng.random(corners) < 0.3
        return [
            Segment(1e-3 if jump else self.rng.uniform(0.05, 1.0), self.depth(self.rng.uniform(0.2, 1.5)))
            for jump in jumps
        ]

    def depth(self, scale: float) -> float:
        """Return the depth [m] whose elastic force is ``scale`` times that of this life."""
        force = 0.5 * math.pow(16.0, self.manner.force) * scale
        return min(float(self.finger.depth(force)), MAX_DEPTH_RADII * self.finger.radius)

    def newton(self) -> float:
        """Return a force [N] under which the finger does not creep too deep."""
        most = float(self.finger.elastic_force(np.array(DEEPEST_BY_FORCE * self.finger.radius)))
        return min(0.5 * math.pow(16.0, self.manner.force), most)
