"""Twelve laws of kinds that the grammar of drafts does not hold, and recordings with one of them hidden.

The virtual bench shares no physics code with the model. Each law stands for something that fingertips do and
that no catalogue has; depths are in units of the deepest press, forces in units of the force there.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from vegrip.identification.recording import Fingertip, Recording
from vegrip.virtual.bench.protocol import AIR_SEGMENT, Episode, Segment, triangles
from vegrip.virtual.bench.trial import run_trial
from vegrip.virtual.hidden import Clocked, Hidden, fresh, lasting
from vegrip.virtual.settings import FingertipSettings, SensorSettings

RATE_HZ = 100.0
NOISE_N, NOISE_M = 0.01, 1e-6  # of the sensors
QUIET = 1e-3  # of the noise, where the truth is asked for
SIMULATION_STEP_S = 2.5e-3
EPISODES = 10
CLEAR = Segment(0.3, depth=-1e-4)  # in the air, before and after each episode


@dataclass
class Scaled(Hidden):
    """A law over depth and force in units of the deepest press."""

    depth: float = 1e-3  # [m]
    force: float = 1.0  # [N]
    share: float = 0.25  # of the force, that the law makes


@dataclass
class TanhDrag(Scaled):
    """Resistance that saturates with the speed, as a lubricated sheath."""

    speed: float = 4.0  # [deepest presses/s]
    _x: float = fresh()
    _dt: float = lasting(1.0)

    def more(self, x: float, elastic: float) -> float:
        rate = (x - self._x) / self._dt / self.depth
        return self.share * elastic * math.tanh(rate / self.speed)

    def strained(self, elastic: float, x: float, dt: float) -> None:
        self._x, self._dt = x, dt


@dataclass
class StretchedWear(Scaled):
    """Softening by the way rubbed in and out, as a stretched exponential."""

    way: float = 6.0  # [deepest presses]
    stretch: float = 0.6
    _way: float = lasting()
    _x: float = fresh()

    def elastic(self, force: float, x: float) -> float:
        return force * (1.0 - self.share * -math.expm1(-((self._way / self.way) ** self.stretch)))

    def remember(self, x: float, force: float, dt: float) -> None:
        self._way += abs(x - self._x) / self.depth if x > 0.0 else 0.0
        self._x = x


@dataclass
class Relay(Scaled):
    """Something lets go beyond a depth, and grips again only far below it: hysteresis with two thresholds."""

    high: float = 0.7
    low: float = 0.25
    over: float = 0.15  # on the way back
    _has_let_go: bool = fresh(False)

    def elastic(self, force: float, x: float) -> float:
        back = min(max(self.high - x / self.depth, 0.0) / self.over, 1.0)
        return force * (1.0 - self.share * self._has_let_go * back)

    def remember(self, x: float, force: float, dt: float) -> None:
        self._has_let_go = x > (self.low if self._has_let_go else self.high) * self.depth


@dataclass
class Presses(Scaled):
    """Stiffness that falls with the number of presses, quickly at first and ever more slowly."""

    half: float = 3.0  # presses after which half is gone
    _count: float = lasting()
    _is_touching: bool = fresh(False)

    def elastic(self, force: float, x: float) -> float:
        return force * (1.0 - self.share * self._count / (self._count + self.half))

    def remember(self, x: float, force: float, dt: float) -> None:
        self._count += self._is_touching and x <= 0.0
        self._is_touching = x > 0.0


@dataclass
class SecondBody(Scaled):
    """A second, round body that is met inside."""

    at: float = 0.5

    def elastic(self, force: float, x: float) -> float:
        return force + 8.0 * self.share * self.force * math.pow(max(x / self.depth - self.at, 0.0), 1.5)


@dataclass
class StickSlipDrive(Scaled):
    """A drive that sticks until it is far enough behind, and then jumps."""

    gap: float = 0.06
    _at: float = fresh()

    def moved(self, position: float) -> float:
        if abs(position - self._at) > self.gap * self.depth:
            self._at = position
        return self._at


@dataclass
class Leak(Scaled):
    """A cushion that loses its filling while it is loaded, and never gets it back."""

    impulse: float = 20.0  # [deepest force x s]
    _lost: float = lasting()

    def elastic(self, force: float, x: float) -> float:
        return force * (1.0 - 1.5 * self.share * self._lost / (self._lost + self.impulse))

    def strained(self, elastic: float, x: float, dt: float) -> None:
        self._lost += elastic / self.force * dt


@dataclass
class Eyring(Scaled):
    """An over-stress that flows the quicker the larger it is, by the sinh of thermal activation."""

    time: float = 1.5  # [s]
    activation: float = 0.15  # [deepest force]
    _flowed: float = fresh()

    def more(self, x: float, elastic: float) -> float:
        return 2.0 * self.share * (elastic - self._flowed)

    def strained(self, elastic: float, x: float, dt: float) -> None:
        over = (elastic - self._flowed) / (self.activation * self.force)
        quick = math.sinh(min(abs(over), 20.0)) / abs(over) if abs(over) > 1e-6 else 1.0
        self._flowed += -math.expm1(-dt / self.time * quick) * (elastic - self._flowed)


@dataclass
class TouchWarming(Scaled):
    """What is touched warms the tip, which is then softer, and the air cools it."""

    time: float = 25.0  # [s]
    _warmth: float = lasting()

    def start(self, pause: float) -> None:
        super().start(pause)
        self._warmth *= math.exp(-pause / self.time)

    def elastic(self, force: float, x: float) -> float:
        return force / (1.0 + 5.0 * self.share * self._warmth)

    def remember(self, x: float, force: float, dt: float) -> None:
        self._warmth += -math.expm1(-dt / self.time) * ((x > 0.0) - self._warmth)


@dataclass
class LockUp(Scaled):
    """Foam whose cells close: the force has a pole."""

    pole: float = 1.35

    def elastic(self, force: float, x: float) -> float:
        q = min(max(x, 0.0) / self.depth / self.pole, 0.97) ** 4
        return force * (1.0 + 2.0 * self.share * q / (1.0 - q))


@dataclass
class DwellAdhesion(Scaled):
    """Surfaces that pull the harder the longer they touch, by the logarithm of the time."""

    time: float = 0.2  # [s]
    _touched: float = fresh()

    def pull(self, x: float) -> float:
        return 0.2 * self.share * self.force * math.log1p(self._touched / self.time) if x > 0.0 else 0.0

    def remember(self, x: float, force: float, dt: float) -> None:
        self._touched = self._touched + dt if x > 0.0 else 0.0


@dataclass
class Payne(Clocked, Scaled):
    """Softer after a large strain, and stiff again after a while of small ones."""

    heals: float = 25.0  # [s]
    _strain: float = lasting()

    def start(self, pause: float) -> None:
        super().start(pause)
        self._strain *= math.exp(-pause / self.heals)

    def elastic(self, force: float, x: float) -> float:
        return force * (1.0 - 1.6 * self.share * self._strain / (self._strain + 0.5))

    def remember(self, x: float, force: float, dt: float) -> None:
        super().remember(x, force, dt)
        self._strain = max(self._strain * math.exp(-dt / self.heals), x / self.depth)


# a second set, written before any draft of it was seen: the same kinds in other forms and amounts


@dataclass
class DryingSeal(Scaled):
    """Resistance that falls with the speed, as of a seal whose film carries it."""

    share: float = 0.18
    speed: float = 1.5  # [deepest presses/s]
    _x: float = fresh()
    _dt: float = lasting(1.0)

    def more(self, x: float, elastic: float) -> float:
        rate = (x - self._x) / self._dt / self.depth
        film = 0.25 + 0.75 * math.exp(-abs(rate) / self.speed)
        return self.share * elastic * film * math.tanh(rate / 0.05)

    def strained(self, elastic: float, x: float, dt: float) -> None:
        self._x, self._dt = x, dt


@dataclass
class OverloadDamage(Scaled):
    """Bonds that break above a load, the quicker the larger it is, until none are left."""

    share: float = 0.4
    bears: float = 0.35  # [deepest force]
    time: float = 1.2  # [s]
    _broken: float = lasting()

    def elastic(self, force: float, x: float) -> float:
        return force * (1.0 - self.share * self._broken)

    def strained(self, elastic: float, x: float, dt: float) -> None:
        over = max(elastic / self.force - self.bears, 0.0)
        self._broken += -math.expm1(-((over / self.bears) ** 2) * dt / self.time) * (1.0 - self._broken)


@dataclass
class SnappingDome(Scaled):
    """A dome that carries ever less toward a depth, and beyond it nothing until it is nearly free again."""

    share: float = 0.14
    snaps: float = 0.55
    _is_through: bool = fresh(False)

    def elastic(self, force: float, x: float) -> float:
        part = min(max(x / self.depth / self.snaps, 0.0), 1.0)
        return force + self.share * self.force * math.sin(math.pi * part) * (not self._is_through)

    def remember(self, x: float, force: float, dt: float) -> None:
        self._is_through = x > (0.1 if self._is_through else self.snaps) * self.depth


@dataclass
class RoundedStop(Scaled):
    """A stop that is met ever harder around a depth."""

    share: float = 0.35
    at: float = 0.6
    wide: float = 0.07

    def elastic(self, force: float, x: float) -> float:
        over = (max(x, 0.0) / self.depth - self.at) / self.wide
        met = math.log1p(math.exp(over)) - math.log1p(math.exp(-self.at / self.wide))
        return force + 4.0 * self.share * self.force * self.wide * met


@dataclass
class ThinningFlow(Scaled):
    """An over-stress that flows by the cube of itself."""

    share: float = 0.4
    time: float = 2.0  # [s]
    scale: float = 0.12  # [deepest force]
    _flowed: float = fresh()

    def more(self, x: float, elastic: float) -> float:
        return self.share * (elastic - self._flowed)

    def strained(self, elastic: float, x: float, dt: float) -> None:
        over = (elastic - self._flowed) / (self.scale * self.force)
        self._flowed += -math.expm1(-dt / self.time * over * over) * (elastic - self._flowed)


@dataclass
class PatchWarming(Scaled):
    """What is touched warms the tip through the patch, the more the wider it is; the air cools it slowly."""

    share: float = 0.3
    time: float = 8.0  # [s]
    cools: float = 40.0  # [s]
    _warmth: float = lasting()

    def start(self, pause: float) -> None:
        super().start(pause)
        self._warmth *= math.exp(-pause / self.cools)

    def elastic(self, force: float, x: float) -> float:
        return force * math.exp(-2.0 * self.share * self._warmth)

    def remember(self, x: float, force: float, dt: float) -> None:
        wide = math.sqrt(max(x, 0.0) / self.depth)
        self._warmth += dt * ((1.0 - self._warmth) * wide / self.time - self._warmth / self.cools)


OUTSIDE_LAWS: Final[Mapping[str, type[Scaled]]] = {
    "tanh_drag": TanhDrag, "stretched_wear": StretchedWear, "relay": Relay, "presses": Presses,
    "second_body": SecondBody, "stick_slip_drive": StickSlipDrive, "leak": Leak, "eyring": Eyring,
    "touch_warming": TouchWarming, "lock_up": LockUp, "dwell_adhesion": DwellAdhesion, "payne": Payne,
}  # fmt: skip
SECOND_LAWS: Final[Mapping[str, type[Scaled]]] = {
    "drying_seal": DryingSeal, "overload_damage": OverloadDamage, "snapping_dome": SnappingDome,
    "rounded_stop": RoundedStop, "thinning_flow": ThinningFlow, "patch_warming": PatchWarming,
}  # fmt: skip


def presses(depth: float, rng: np.random.Generator) -> Episode:
    """Return a press to some depth at some speed, held for some time."""
    deep, speed = rng.uniform(0.4, 1.0) * depth, 10.0 ** rng.uniform(-0.3, 1.0) * depth
    ramp = deep / speed
    return (
        AIR_SEGMENT,
        Segment(ramp, depth=deep),
        Segment(rng.uniform(0.5, 4.0)),
        Segment(ramp, depth=0.0),
        Segment(0.5),
    )


def cycles(depth: float, rng: np.random.Generator) -> Episode:
    """Return triangles of some depth and speed, or a sine about some depth."""
    if rng.random() < 0.6:
        speed = 10.0 ** rng.uniform(-0.1, 0.9) * depth
        return triangles(rng.uniform(0.4, 1.0) * depth, speed, int(rng.integers(2, 5)))
    frequency = 10.0 ** rng.uniform(-0.4, 0.4)
    wave = Segment(
        round(4.0 * frequency) / frequency, amplitude=rng.uniform(0.1, 0.3) * depth, frequency=frequency
    )
    mean = rng.uniform(0.4, 0.7) * depth
    return (
        AIR_SEGMENT,
        Segment(0.3, depth=mean),
        Segment(0.5),
        wave,
        Segment(0.3, depth=0.0),
        Segment(0.5),
    )


OUTSIDE_PROTOCOLS: Final[Mapping[str, Callable[[float, np.random.Generator], Episode]]] = {
    "presses": presses,
    "cycles": cycles,
}


def draw_tip(seed: int) -> FingertipSettings:
    """Return a fingertip that the paper's model explains."""
    rng = np.random.default_rng([seed, 11])
    return FingertipSettings(
        radius=float(rng.uniform(6e-3, 12e-3)),
        reference_force=float(rng.uniform(1.2, 3.0)),
        exponent=float(rng.uniform(1.4, 1.9)),
        amplitudes=(float(rng.uniform(0.15, 0.3)),),
        rates=(float(np.exp(rng.uniform(np.log(1.0), np.log(4.0)))),),
    )


def record(
    law: str, protocol: str, seed: int, *, is_quiet: bool = False, more: Sequence[Episode] = ()
) -> Recording:
    """Return a recording with a law hidden, none where ``law`` is empty; ``is_quiet``: next to no noise.

    ``more``: episodes that are done with the same fingertip afterwards.
    """
    tip, rng = draw_tip(seed), np.random.default_rng([seed, 13, list(OUTSIDE_PROTOCOLS).index(protocol)])
    depth = 0.15 * tip.radius
    force = tip.reference_force * (depth / tip.reference_indentation) ** tip.exponent
    episodes = [OUTSIDE_PROTOCOLS[protocol](depth, rng) for _ in range(EPISODES)]
    episodes = [(CLEAR, *one, CLEAR) for one in (*episodes, *more)]
    part = QUIET if is_quiet else 1.0
    trial = run_trial(
        tip,
        episodes,
        SensorSettings(
            rate=RATE_HZ, normal_force=part * NOISE_N, displacement=part * NOISE_M, force_bias=0.0
        ),
        seed,
        hidden={law: {"depth": depth, "force": force}} if law else {},
        catalogue={**OUTSIDE_LAWS, **SECOND_LAWS},
        step=SIMULATION_STEP_S,
        rings=4,
        spokes=8,
        truth=False,
    )
    columns = {name: trial.columns[name] for name in ("displacement", "normal_force")}
    stated = {"normal_force": NOISE_N, "displacement": NOISE_M}
    episode = trial.columns["episode"].astype(np.int64)
    name = f"{law or 'nothing'}, {protocol}, seed {seed}"
    return Recording(name, trial.columns["t"], episode, columns, Fingertip(tip.radius), stated)
