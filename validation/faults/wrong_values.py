"""What a sensor that is wrong for up to a second does to the grip.

Usage: ``python -m validation.faults.wrong_values``.

A hand holds an object; the same grasp runs once undisturbed and once with wrong values in one channel, of one
finger or of all. The values are within the ranges of the watchdog, the frames are sound. The law::

    the command never falls below 0.95 of what it was without the fault, to within its rounding
    nor stays at the largest command for more than 0.5 s after the fault
    within 2 s the friction is back within two of its undisturbed standard deviations
    and its standard deviation has not shrunk

With learning a grip is let go of on purpose, a little later or earlier after a fault, so another run is no
measure: it has its slips at other times, and each of them teaches. There the law is about one run, in which a
second node (:mod:`.sound_node`) is given what the hand senses before it is made wrong::

    the object slips no more often than without the fault
    the command stays at the largest for no more than 0.5 s after the fault
    within 2 s the friction is within two standard deviations of what the second node believes
    and its standard deviation is not smaller than there: a fault teaches nothing
    from 2 s on no command is above 1.25 of the largest one of the second node since the fault began
    (a slip channel that lies is not used any more: of that, or of the grip that has none),
    and no finger is gripped fail-safe

``--worst N`` looks for the worst case: half of N at random, then steps from the worst in each part of it.
"""

import argparse
import logging
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache
from itertools import cycle

import numpy as np

from validation.faults.sound_node import SoundNode
from validation.faults.testbed import SAMPLING, STATE_RATE_HZ, Falsify, Scene
from vegrip.grip.node import GraspForce
from vegrip.grip.parameters import GraspParameters
from vegrip.messages import Estimate, FingertipState, Reason
from vegrip.trials.candidates import KNOBS, demo_parameters, parameters
from vegrip.types import Floats

FAULT_BEGIN_S = 6.0  # [s] of the fault, unless it is drawn
WATCHED_AFTER_S = 4.0  # [s] that are watched after it
BACK = 2.0  # [s] within which estimates have to be back
MAXIMUM = 0.5  # [s] for which the command may stay at its largest after the fault
FALLEN = 0.95
DURATIONS = (1.0 / STATE_RATE_HZ, 10.0 / STATE_RATE_HZ, 1.0)  # [s]

WRONG_VALUES = {
    "normal_force": (-4.0, 0.0, 1.0, 15.0, 59.0),
    "displacement": (-9e-3, 0.0, 1e-3, 2e-3, 9e-3),
    "tangential_force_x": (-5.0, 0.0, 0.7, 2.0, 5.0, 59.0),
    "torque_z": (-1.9, 0.0, 0.02, 0.1, 1.9),
    "slip": (0.0, 1.0),
    "slip_speed": (-0.5, 0.0, 0.01, 0.5),
    "temperature": (-20.0, 25.0, 99.0),
    "contact_radius": (1e-4, 2e-3, 8e-3),
}
"""Within the ranges that the watchdog believes."""
CHANNEL_NOISE = {"normal_force": 0.01, "displacement": 5e-6, "tangential_force_x": 0.01, "torque_z": 1e-4}
"""Of wrong values, so that they do not look frozen."""


@dataclass(frozen=True)
class Fault:
    """Wrong values of one channel; ``finger`` -1 is all of them."""

    channel: str
    value: float
    begin: float  # [s]
    duration: float  # [s]
    finger: int

    def __str__(self) -> str:
        """Say it in a line."""
        who = "all" if self.finger < 0 else f"finger {self.finger}"
        return (
            f"{self.channel} = {self.value:g} for {1e3 * self.duration:.0f} ms from {self.begin:.2f} s, {who}"
        )


@dataclass(frozen=True)
class Run:
    """One grasp: commands at every SAMPLING, estimates at one instant."""

    command: Floats  # [N], (instants, fingers)
    estimates: tuple[dict[str, Estimate], ...]  # of each finger, BACK after the fault
    slips: int = 0
    sound: "Run | None" = None  # the same of the node that is given sound states
    fail_safe: bool = False  # whether a finger is gripped fail-safe after the estimates


class Reference:
    """The grasp without a fault: simulated once, as far as it is asked for."""

    def __init__(self, *, learning: bool = False) -> None:
        self._scene = scene_of(learning=learning)
        self._estimates: list[tuple[dict[str, Estimate], ...]] = []  # at every SAMPLING
        self._slips: list[int] = []

    def run(self, end: float, look: float) -> Run:
        """Return the grasp until ``end`` [s], with the estimates at ``look`` [s]."""
        while (simulated := len(self._estimates)) < round(end / SAMPLING):
            self._scene.run_until((simulated + 1) * SAMPLING)
            self._estimates.append(_all_estimates(self._scene.node, self._scene.fingers))
            self._slips.append(self._scene.hand_node.hand.slips)
        command = np.array(self._scene.course.command[: round(end / SAMPLING)])
        at = round(end / SAMPLING) - 1
        return Run(command, self._estimates[round(look / SAMPLING) - 1], self._slips[at])


@dataclass(frozen=True)
class Verdict:
    """How far a fault went in each part of the law: 0 is not at all, 1 the limit."""

    fallen: float  # largest share by which the command fell, over 0.05; with learning 2 where it slipped
    maximum: float  # time at the largest command after the fault, over 0.5 s
    off: float  # largest error of an estimate, over two standard deviations
    risen: float  # with learning, by how much the command is too large after BACK, over a quarter of it
    shrunk: float  # largest standard deviation without the fault over that with it, less 1, over what it may
    unsound: float  # with learning, 2 where a finger is gripped fail-safe after BACK

    @property
    def worst(self) -> float:
        """The number to look at."""
        return max(self.fallen, self.maximum, self.off, self.risen, self.shrunk, self.unsound)


def scene_of(*, learning: bool = False) -> Scene:
    """Return the grasp that all faults meet."""
    return Scene("pinch", parameters=learning_parameters() if learning else None)


def learning_parameters() -> GraspParameters:
    """Return the parameters of a grasp that learns."""
    return parameters("learning", KNOBS["pinch"]["learning"])


def run(end: float, look: float, fault: Fault, *, learning: bool = False) -> Run:
    """Hold the object until ``end`` [s] with the fault; note the estimates at ``look`` [s]."""
    scene = scene_of(learning=learning)
    sound = SoundNode(learning_parameters(), scene.fingers) if learning else None
    scene.hand_node.falsify = _falsifier(scene, fault, sound)
    _run_until(look, scene, sound)
    known = told = _all_estimates(scene.node, scene.fingers)
    if sound is not None:
        told = _all_estimates(sound.node, scene.fingers)
    is_safe = _run_until(end, scene, sound)
    beside = None if sound is None else Run(np.array(sound.course), told)
    return Run(np.array(scene.course.command), known, scene.hand_node.hand.slips, beside, is_safe)


def _run_until(time: float, scene: Scene, sound: SoundNode | None) -> bool:
    """Run until ``time`` [s]; return whether a finger was gripped fail-safe meanwhile."""
    is_safe = False
    while scene.now < time - 0.5 * SAMPLING:
        scene.run_until(scene.now + SAMPLING)
        if sound is not None:
            sound.look(scene.clock.now())
        is_safe |= any(c.reason is Reason.FAIL_SAFE for c in scene.hand_node.commands.values())
    return is_safe


@cache
def reference(*, learning: bool = False) -> Reference:
    """Return the grasp without a fault."""
    return Reference(learning=learning)


@cache
def without_a_channel(end: float) -> Floats:
    """Return the commands [N] until ``end`` [s] of a grasp that learns and in which no slip is felt."""
    scene = scene_of(learning=True)
    scene.hand_node.falsify = lambda state: replace(state, slip=math.nan, slip_speed=math.nan)
    scene.run_until(end)
    return np.array(scene.course.command)


def judge(fault: Fault, *, learning: bool = False) -> Verdict:
    """Run the grasp with the fault and compare it with the one without."""
    over = round((fault.begin + fault.duration) / SAMPLING) * SAMPLING
    end, look = over + WATCHED_AFTER_S, over + BACK
    without, disturbed = reference(learning=learning).run(end, look), run(end, look, fault, learning=learning)
    n = min(len(without.command), len(disturbed.command))
    begun = round(fault.begin / SAMPLING)
    ratio = disturbed.command[begun:n] / np.maximum(without.command[begun:n], 1e-9)
    largest = demo_parameters().limits.max_force
    after = disturbed.command[round(over / SAMPLING) : n].max(axis=1) >= 0.999 * largest
    sound = disturbed.sound or without
    off, shrunk = _taught(sound.estimates, disturbed.estimates)
    fallen, above = float((1.0 - ratio.min()) / (1.0 - FALLEN)), 0.0
    if learning:
        fallen = SLIPPED if disturbed.slips > without.slips else 0.0
        back = round(look / SAMPLING)
        most = float(sound.command[begun:n].max())
        if fault.channel.startswith("slip"):
            most = max(most, float(without_a_channel(end)[begun:].max()))
        above = float(disturbed.command[back:n].max()) / most - 1.0
    return Verdict(
        fallen=fallen,
        risen=above / RISEN,
        maximum=float(np.count_nonzero(after)) * SAMPLING / MAXIMUM,
        off=off,
        shrunk=(shrunk - 1.0) / (SHRUNK - 1.0),
        unsound=UNSOUND if learning and disturbed.fail_safe else 0.0,
    )


SLIPPED = 2.0
"""How far it breaks the law to slip because of a fault."""
UNSOUND = 2.0
"""How far it breaks the law to be gripped fail-safe because of a fault that is over."""
RISEN = 0.25
"""By so much the command may be larger than it ever was without the fault."""
SHRUNK = 1.1
"""By so much a standard deviation may differ: a grip that rises changes the contact, and what is known."""


def _taught(
    sound: Sequence[Mapping[str, Estimate]], disturbed: Sequence[Mapping[str, Estimate]]
) -> tuple[float, float]:
    """Return the largest error, over two standard deviations, and by what the smallest one has shrunk."""
    off, shrunk = 0.0, 0.0
    for calm, other in zip(sound, disturbed, strict=True):
        for name, known in calm.items():
            off = max(off, abs(other[name].value - known.value) / (2.0 * known.std))
            shrunk = max(shrunk, known.std / max(other[name].std, 1e-300))
    return off, shrunk


def _all_estimates(node: GraspForce | None, fingers: Sequence[str]) -> tuple[dict[str, Estimate], ...]:
    assert node is not None  # noqa: S101 (it is not killed)
    return tuple(_estimates(node, finger) for finger in fingers)


def _estimates(node: GraspForce, finger: str) -> dict[str, Estimate]:
    estimator = node.fingers[finger].estimator
    e = estimator.contact_estimate()
    mu = e.friction_coefficient
    relative = mu.std / mu.value  # in its logarithm, where it is normal
    return {"friction": Estimate(math.log(mu.value), relative, mu.valid, mu.age)}


def _falsifier(scene: Scene, fault: Fault, sound: SoundNode | None) -> Falsify:
    rng = np.random.default_rng(1)
    concerned = set(scene.fingers) if fault.finger < 0 else {scene.fingers[fault.finger]}

    def falsify(state: FingertipState) -> FingertipState:
        if sound is not None:
            sound.take(state, scene.clock.now())
        inside = fault.begin <= scene.now < fault.begin + fault.duration
        if not inside or state.finger not in concerned:
            return state
        wrong = fault.value + CHANNEL_NOISE.get(fault.channel, 0.0) * float(rng.standard_normal())
        return replace(state, **{fault.channel: wrong})  # type: ignore[arg-type]

    return falsify


def faults() -> Iterator[Fault]:
    """Yield the table: every channel and value, one sample, ten, a second, one finger and all."""
    for channel, values in WRONG_VALUES.items():
        for value in values:
            for duration in DURATIONS:
                for finger in (0, -1):
                    yield Fault(channel, value, FAULT_BEGIN_S, duration, finger)


def drawn(rng: np.random.Generator) -> Fault:
    """Return any fault."""
    channel = str(rng.choice(list(WRONG_VALUES)))
    low, high = min(WRONG_VALUES[channel]), max(WRONG_VALUES[channel])
    value = float(rng.choice(WRONG_VALUES[channel])) if rng.random() < 0.3 else float(rng.uniform(low, high))
    duration = float(rng.choice(DURATIONS))
    return Fault(channel, value, float(rng.uniform(2.0, 10.0)), duration, int(rng.integers(-1, 2)))


def near(fault: Fault, rng: np.random.Generator) -> Fault:
    """Return a fault like ``fault``: value and begin differ a little, now and then duration or finger."""
    low, high = min(WRONG_VALUES[fault.channel]), max(WRONG_VALUES[fault.channel])
    value = min(max(fault.value + 0.1 * (high - low) * float(rng.standard_normal()), low), high)
    begin = max(2.0, fault.begin + 0.3 * float(rng.standard_normal()))
    duration = float(rng.choice(DURATIONS)) if rng.random() < 0.2 else fault.duration
    finger = int(rng.integers(-1, 2)) if rng.random() < 0.2 else fault.finger
    return Fault(fault.channel, value, begin, duration, finger)


def main(arguments: Sequence[str] | None = None) -> int:
    """Print a line for each fault that breaks the law, and the worst; return 1 if one does."""
    parser = argparse.ArgumentParser(prog="python -m validation.faults.wrong_values", description=__doc__)
    parser.add_argument("--worst", type=int, help="look for the worst case in so many tries")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--learning", action="store_true", help="with friction learned together, and probed")
    parser.add_argument("--only", help="channel")
    parser.add_argument("--all", action="store_true", help="print every line")
    options = parser.parse_args(arguments)
    names = [field.name for field in fields(Verdict)]
    print("law = 1".ljust(72), *(name.rjust(9) for name in names))  # noqa: T201
    worst: dict[str, tuple[float, Fault]] = {}  # in each part of the law
    broken = count = 0
    for fault in _cases(options, worst):
        verdict = judge(fault, learning=options.learning)
        count += 1
        broken += verdict.worst > 1.0
        if verdict.worst > 1.0 or options.all:
            print(str(fault).ljust(72), *(f"{getattr(verdict, n):9.2f}" for n in names), flush=True)  # noqa: T201
        for name in names:
            worst[name] = max(
                (getattr(verdict, name), fault), worst.get(name, (-math.inf, fault)), key=lambda w: w[0]
            )
    print(f"{broken} of {count} break the law; the worst in each part of it:")  # noqa: T201
    for name, (far, fault) in worst.items():
        print(f"{name:8} {far:5.2f}: {fault}")  # noqa: T201
    return 1 if broken else 0


def _cases(options: argparse.Namespace, worst: Mapping[str, tuple[float, Fault]]) -> Iterator[Fault]:
    if options.worst is None:
        yield from (f for f in faults() if options.only in (None, f.channel))
        return
    rng = np.random.default_rng(options.seed)
    for _ in range(max(1, options.worst // 2)):
        yield drawn(rng)
    parts = cycle(list(worst))
    for _ in range(options.worst // 2, options.worst):
        yield near(worst[next(parts)][1], rng)


if __name__ == "__main__":
    logging.getLogger("vegrip").setLevel(logging.ERROR)  # lost input is what is played here
    raise SystemExit(main())
