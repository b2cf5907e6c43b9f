"""A grip controller holds the object of :mod:`.plant` by what a channel of :mod:`.channels` says."""

import math
import tomllib
from collections import deque
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from vegrip import FingertipState, GripController
from vegrip.config import build
from vegrip.grip.node import GraspForce
from vegrip.grip.parameters import GraspParameters, estimator_factory
from vegrip.grip.wires import COMMANDED
from vegrip.messages import Condition, ModelHealth

from .channels import FAULTS, FLICKER_S, Said, Sound
from .plant import DEPTH, FORCE, FORCE_X, FORCE_Y, SPEED, STATED_AT_N, Array, Make, Plant
from .sensors import SENSOR_FAULTS, Measured, columns_of

NS = 1_000_000_000
LAUNCH = Path(__file__).parents[2] / "launch" / "demo.toml"
NAMES = ("thumb", "index", "middle", "ring", "little")

TOUCH_S, CLOSE_S, LIFT_S = 0.15, 0.6, 1.0  # the hand touches, is closed, has lifted the object
START_FORCE_N = 3.0  # with which it is closed
LATENCY_S = 0.002  # of a command
NOISE = {"force": 0.01, "tangential": 0.01, "torque": 1e-4, "depth": 5e-6}  # [N], [N], [N m], [m]
THRESHOLD_M_S, DELAY_S, SPEED_NOISE_M_S = 1e-4, 0.02, 5e-5  # of a sound slip channel
SLID_M, DROPPED_M = 3e-3, 0.02  # by which the object may slide, and from which on it is lost
LOOK_S = 0.2  # how often the condition is looked at, as by a node as it comes


@dataclass(frozen=True)
class Occurrence:
    """A fault of a slip channel or of another sensor: which, since when, where."""

    fault: str  # of FAULTS or SENSOR_FAULTS
    start: float = 0.0  # [s]
    which: tuple[int, ...] = ()  # fingers; none = all


@dataclass(frozen=True)
class Case:
    """One run: what is held, what is wrong, how it is gripped."""

    make: Make = field(default_factory=Make)
    fault: str = "none"
    start: float = 0.0  # [s] of the fault
    which: tuple[int, ...] = ()  # fingers with the fault; none = all
    gain: float = 1.0  # of the tangential force
    gain_drifts: bool = False  # it gets there in 50 s
    gain_start: float = -1.0  # [s]; negative: with the fault
    falls: float = 0.0  # [s] friction halves within 0.3 s; 0 = it does not
    falls_at: int = -1  # of this finger alone; negative: of all
    rises: int = 8  # sudden loads in a minute
    rise_at: float = 0.0  # [s] of one more; 0 = none
    exact: bool = False  # a sound channel says 0 and not its noise
    duration: float = 60.0
    rate: int = 200  # [Hz]
    seed: int = 1
    also: tuple[Occurrence, ...] = ()  # further faults
    tangential_gain: float = 1.0  # with which tangential forces are measured, without any fault
    after: float = -1.0  # [s] from which on force counts as after the fault; negative: 5 s after the first

    @property
    def faults(self) -> tuple[Occurrence, ...]:
        return (Occurrence(self.fault, self.start, self.which), *self.also)

    @property
    def slip_faults(self) -> tuple[Occurrence, ...]:
        return tuple(one for one in self.faults if one.fault in FAULTS and one.fault != "none")

    @property
    def sensor_faults(self) -> tuple[Occurrence, ...]:
        return tuple(one for one in self.faults if one.fault in SENSOR_FAULTS)

    @property
    def begins(self) -> float:
        """When the first fault begins [s]."""
        return min((one.start for one in self.faults if one.fault != "none"), default=self.start)

    def fingers_of(self, fault: Occurrence) -> tuple[int, ...]:
        return fault.which or tuple(range(self.make.fingers))


@dataclass
class Outcome:
    """What came of it."""

    dropped: float = math.inf  # [s]
    slid: float = 0.0  # [m] of the object: no finger has held it
    slid_at: float = math.inf  # [s] when it had slid by SLID_M
    finger: float = 0.0  # [m] of the finger that slid most
    over_least: float = math.nan  # mean force over the least possible, from the lift on
    after_fault: float = math.nan  # the same from 5 s after the beginning of the fault
    peak: float = 0.0  # [N]
    contradicted: float = math.inf  # [s] first time that the channel has contradicted the truth
    named: float = math.inf  # [s] when the health of a finger has said so since the fault
    said: str = ""
    explained: float = math.inf  # [s] when it was said why nothing is probed, since the contradiction
    unproven: str = ""  # first that was said of probing
    friction: float = math.nan  # what the thumb's friction is stated to be at the end


def load_course(case: Case) -> Array:
    """Return the load [N] at every sample, rows of x and y: weight, slow changes, sudden rises by half."""
    rng = np.random.default_rng([case.seed, 12])
    t = np.arange(round(case.duration * case.rate) + 2) / case.rate
    slow = np.zeros_like(t)
    for _ in range(4):
        f, phase, size = rng.uniform(0.05, 1.0), rng.uniform(0.0, 2.0 * math.pi), rng.uniform(0.3, 1.0)
        slow += size * np.sin(2.0 * math.pi * f * t + phase)
    load = 1.0 + 0.3 * slow / max(1.0, float(np.abs(slow).max()))
    starts = list(rng.uniform(2.0, case.duration, round(case.rises * case.duration / 60.0)))
    sudden = np.zeros_like(t)
    for start in [*starts, *([case.rise_at] if case.rise_at else [])]:
        quick, stays = rng.uniform(0.03, 0.1), rng.uniform(0.3, 4.0)
        up = np.clip((t - start) / quick, 0.0, 1.0)
        down = np.clip((t - start - stays) / rng.uniform(0.1, 1.0), 0.0, 1.0)
        sudden = np.maximum(sudden, 0.5 * (up - down))
    lifted = np.clip((t - CLOSE_S) / (LIFT_S - CLOSE_S), 0.0, 1.0)
    across = 0.1 * np.sin(2.0 * math.pi * rng.uniform(0.1, 0.5) * t)
    size = case.make.load * lifted * (load + sudden)
    return np.column_stack([size * across, -size])


def friction_course(case: Case) -> Array:
    """Return what the friction of each finger is multiplied by at every sample, (samples, fingers)."""
    t = np.arange(round(case.duration * case.rate) + 2) / case.rate
    factor = np.ones((len(t), case.make.fingers))
    if case.falls:
        fallen = 1.0 - 0.5 * np.clip((t - case.falls) / 0.3, 0.0, 1.0)
        fingers = slice(None) if case.falls_at < 0 else [case.falls_at]
        factor[:, fingers] = fallen[:, None]
    return factor


def settings_of(case: Case) -> GraspParameters:
    """Return the parameters of the demonstration, told of the slip channel of the plant."""
    nodes = tomllib.loads(LAUNCH.read_text(encoding="utf-8"))["node"]
    table: dict[str, Any] = next(node["parameters"] for node in nodes if node["program"] == "grasp_force")
    given = build(GraspParameters, table, str(LAUNCH))
    friction = replace(
        given.friction,
        slip_threshold=THRESHOLD_M_S,
        slip_delay=DELAY_S,
    )
    return replace(given, friction=friction, report_period=1.0, health_period=LOOK_S, suspects=False)


class Hand:
    """The controller: a node whose states run compiled, as on a network, or objects that are embedded."""

    def __init__(self, case: Case, *, objects: bool = False) -> None:
        self.names = NAMES[: case.make.fingers]
        settings = settings_of(case)
        self._last: dict[str, ModelHealth] = {}
        if objects:
            make = estimator_factory(settings, self.names, "law")
            self._embedded: GripController | None = GripController(
                self.names, settings=settings, make_estimator=make
            )
            self.controller = self._embedded
            return
        self._embedded = None
        self.node = GraspForce("law", self.names, estimator_factory(settings, self.names, "law"), settings)
        self.node.configure()
        self.node.activate()
        assert self.node.controller is not None
        self.controller = self.node.controller

    def take(self, values: Array, seq: int, now: int, commands: Array) -> None:
        """Take a state of each finger: rows in the order of the fields of a state; write the commands."""
        if self._embedded is not None:
            states = [
                FingertipState(now, name, seq, *row)
                for name, row in zip(self.names, values.tolist(), strict=True)
            ]
            for command in self._embedded.step(states, now):
                commands[self.names.index(command.finger)] = command.normal_force
            return
        node = self.node
        for i, (name, row) in enumerate(zip(self.names, values.tolist(), strict=True)):
            if self.controller.answer(FingertipState(now, name, seq, *row), now) & COMMANDED:
                commands[i] = node.fingers[name].held
        self._listen(node.on_tick(now), commands)

    def _listen(self, answers: Any, commands: Array) -> None:
        for answer in answers:
            if isinstance(answer, ModelHealth):
                self._last[answer.finger] = answer
            elif type(answer).__name__ == "ForceCommand":
                commands[self.names.index(answer.finger)] = answer.normal_force

    def says(self, now: int) -> tuple[str, str]:
        """Return what is said to be wrong, "" if nothing is, and why friction is not probed."""
        found = []
        for name in self.names:
            if self._embedded is not None:
                health = self._embedded.health(name)
            else:
                for answer in self.node.reports(name, now):
                    if isinstance(answer, ModelHealth):
                        self._last[name] = answer
                if name not in self._last:
                    continue
                health = self._last[name]
            if health.condition is not Condition.OK:
                found.append(f"{name} {health.condition.name}")
            if health.channel in ("slip", "slip_speed", "tangential_force"):
                found.append(f"{name} {health.channel}")
        return ", ".join(found), self.controller.friction.why_not_probing


FELT, IN_PLANT = [0, 1, 2, 4], [FORCE, FORCE_X, FORCE_Y, DEPTH]
"""Columns of what is measured, and of the plant."""


class Stage:
    """One fault of the slip channels; what comes in is sound, or what an earlier fault has left of it."""

    def __init__(self, case: Case, fault: Occurrence, keeps: int, rng: np.random.Generator) -> None:
        self._fault, self._fingers, self._start = FAULTS[fault.fault], case.fingers_of(fault), fault.start
        self._flickers = fault.fault == "flicker"
        self._past = [deque([(0.0, 0.0)] * keeps, keeps) for _ in range(case.make.fingers)]
        self._held: dict[int, Said] = {}
        self._rate, self._rng = case.rate, rng

    def has_begun(self, i: int, t: float) -> bool:
        """Return whether the fault spoils the channel of finger i at ``t`` [s]."""
        return i in self._fingers and t >= self._start

    def say(self, t: float, comes: list[Said], true_speeds: list[float]) -> list[Said]:
        """Return what is said at ``t`` [s] of what comes in."""
        for past, said in zip(self._past, comes, strict=True):
            past.append(said)
        says = list(comes)
        for i in self._fingers:
            if t >= self._start:
                says[i] = self._wrong(i, t - self._start, comes, true_speeds[i])
            elif self._flickers:
                says[i] = math.nan, math.nan
        return says

    def _wrong(self, i: int, since: float, comes: list[Said], true_speed: float) -> Said:
        past, other = self._past[i], comes[(i + 1) % len(comes)]
        held = self._held.setdefault(i, past[-1])
        earlier = lambda seconds: past[-1 - round(seconds * self._rate)]  # noqa: E731
        return self._fault(Sound(*past[-1], since, earlier, other, true_speed, held, self._rng))


class Channel:
    """What the slip channels of all fingers say, sound and with the faults of a case."""

    def __init__(self, case: Case, rng: np.random.Generator) -> None:
        n = case.make.fingers
        self._case = case
        self._late = round(DELAY_S * case.rate)
        keeps = self._late + round(0.5 * case.rate) + 1
        self._truths = [deque([(0.0, 0.0)] * keeps, keeps) for _ in range(n)]  # flag and speed, newest last
        self._sound: list[Said] = [(0.0, 0.0)] * n
        self._stages = [Stage(case, fault, keeps, rng) for fault in case.slip_faults]
        self._silent, self._lies = [0.0] * n, [0] * n
        self.contradicted = math.inf
        """[s] since when the channel has contradicted a sound one: 0.2 mm of a slide that it did not tell, or
        ten samples that say what is not."""

    def say(self, t: float, rows: Array, noise: Array) -> list[Said]:
        """Return what every finger says at ``t`` [s]."""
        for i, row in enumerate(rows):
            speed = float(row[SPEED])
            self._truths[i].append((float(speed >= THRESHOLD_M_S), speed))
            flag, speed = self._truths[i][-1 - self._late]
            self._sound[i] = flag, speed + noise[i]
        says = list(self._sound)
        true_speeds = [truths[-1 - self._late][1] for truths in self._truths]
        for stage in self._stages:
            says = stage.say(t, says, true_speeds)
        return says

    def judge(self, t: float, said: list[Said]) -> None:
        """Hold what was ``said`` at ``t`` [s] against what a sound channel says."""
        for i, (flag, speed) in enumerate(said):
            if not any(stage.has_begun(i, t) for stage in self._stages):
                continue
            sound = self._sound[i]
            is_silent = sound[0] >= 0.5 and not (flag >= 0.5 or speed >= 1e-3)
            missed = self._truths[i][-1 - self._late][1] / self._case.rate if is_silent else 0.0
            self._silent[i] = self._silent[i] * 0.99 + missed
            self._lies[i] += sound[0] < 0.5 and (flag >= 0.5 or abs(speed - sound[1]) >= 1e-3)
            if self._silent[i] > 2e-4 or self._lies[i] >= 10:
                self.contradicted = min(self.contradicted, t)


class Sensors:
    """What is measured of forces and displacements, with the faults of a case."""

    def __init__(self, case: Case) -> None:
        gain = case.tangential_gain
        self._case, self._gains = case, np.array([1.0, gain, gain, 1.0])
        self._held: dict[tuple[int, int], Array] = {}
        self._rng = np.random.default_rng([case.seed, 14])

    def measure(self, t: float, rows: Array, noise: Array, values: Array) -> None:
        """Write what is measured at ``t`` [s] into the first columns of ``values``."""
        values[:, :5] = noise[:, :5]
        values[:, FELT] += rows[:, IN_PLANT] * self._gains
        if t <= TOUCH_S:
            values[:, 4] = 1e-3 * (t - TOUCH_S) + noise[:, 4]
        self._scale(t, values)
        for number, fault in enumerate(self._case.sensor_faults):
            if t >= fault.start:
                self._spoil(number, fault, t - fault.start, values)

    def _scale(self, t: float, values: Array) -> None:
        case = self._case
        since = t - (case.start if case.gain_start < 0.0 else case.gain_start)
        if case.gain != 1.0 and since >= 0.0:
            values[:, 1:3] *= case.gain ** min(since / 50.0, 1.0) if case.gain_drifts else case.gain
        for fault in case.slip_faults:
            if fault.fault == "flicker" and 0.0 <= t - fault.start < FLICKER_S:
                values[:, 1:3] *= 3.0

    def _spoil(self, number: int, fault: Occurrence, since: float, values: Array) -> None:
        columns, spoil = columns_of(fault.fault), SENSOR_FAULTS[fault.fault]
        for i in self._case.fingers_of(fault):
            value = values[i, columns]
            held = self._held.setdefault((number, i), value)
            values[i, columns] = spoil(Measured(value, since, held, self._rng))


class Trial:
    """A case while it runs."""

    def __init__(self, case: Case, *, objects: bool = False) -> None:
        self.case, self.told = case, Outcome()
        self.plant, self.hand = Plant(case.make), Hand(case, objects=objects)
        self._loads, self._frictions = load_course(case), friction_course(case)
        sizes = np.hypot(self._loads[:, 0], self._loads[:, 1])
        self._least = self.plant.least_squeeze(sizes, self._frictions)
        n, rng = case.make.fingers, np.random.default_rng([case.seed, 13])
        scales = [NOISE["force"], NOISE["tangential"], NOISE["tangential"], NOISE["torque"], NOISE["depth"]]
        count = round(case.duration * case.rate)
        self._noise = rng.standard_normal((count, n, 6)) * [
            *scales, 0.0 if case.exact else SPEED_NOISE_M_S,
        ]  # fmt: skip
        self._channel, self._sensors = Channel(case, rng), Sensors(case)
        self._values = np.full((n, 9), math.nan)
        self._commands, self._acting = np.zeros(n), np.zeros(n)
        self._waiting: deque[tuple[float, Array]] = deque()
        self._after = case.after if case.after >= 0.0 else case.begins + 5.0
        self._sums = [0.0] * 4  # squeeze and least squeeze, since the lift and since the fault

    def step(self, k: int) -> None:
        """Go on by one sample."""
        case, plant, t = self.case, self.plant, (k + 1) / self.case.rate
        while self._waiting and self._waiting[0][0] <= t:
            self._acting = self._waiting.popleft()[1]
        frictions = self._frictions[k], self._frictions[k + 1]
        plant.advance(1.0 / case.rate, self._drives(t), frictions, self._loads[k : k + 2])
        self._sense(t, plant.rows, self._noise[k])
        self._channel.judge(t, self._said)
        self.told.contradicted = self._channel.contradicted
        self.hand.take(self._values, k + 1, round(t * NS), self._commands)
        self._waiting.append((t + LATENCY_S, self._commands.copy()))
        self._note(t, float(self._least[k + 1]))
        if k % round(LOOK_S * case.rate) == 0 and t > CLOSE_S:
            self._listen(t)

    def _drives(self, t: float) -> Array:
        """Return what the drives follow [N]: at first the hand closes by itself."""
        if t > CLOSE_S:
            return self._acting
        force = min(max((t - TOUCH_S) / (CLOSE_S - TOUCH_S), 0.0), 1.0) * START_FORCE_N
        drives = np.full(len(self._acting), force / (len(self._acting) - 1))
        drives[0] = force
        return drives

    def _sense(self, t: float, rows: Array, noise: Array) -> None:
        self._sensors.measure(t, rows, noise, self._values)
        self._said = self._channel.say(t, rows, noise[:, 5])
        self._values[:, 6:8] = self._said

    def _note(self, t: float, least: float) -> None:
        told, squeeze, sums = self.told, float(self.plant.rows[0, FORCE]), self._sums
        slid = self.plant.slid.tolist()
        told.slid, told.finger = max(told.slid, min(slid)), max(told.finger, *slid)
        if told.slid > SLID_M:
            told.slid_at = min(told.slid_at, t)
        if told.slid > DROPPED_M:
            told.dropped = min(told.dropped, t)
        if t > LIFT_S:
            sums[0] += squeeze
            sums[1] += least
            told.peak = max(told.peak, squeeze)
        if t > max(LIFT_S, self._after):
            sums[2] += squeeze
            sums[3] += least
        told.over_least = sums[0] / sums[1] if sums[1] else math.nan
        told.after_fault = sums[2] / sums[3] if sums[3] else math.nan
        self.row = (t, squeeze, least, min(slid), max(slid))

    def _listen(self, t: float) -> None:
        told = self.told
        wrong, why = self.hand.says(round(t * NS))
        if why and not told.unproven:
            told.unproven = f"{t:.2f} s: {why}"
        if t >= self.case.begins and wrong and told.named == math.inf:
            told.named, told.said = t, f"{wrong}; {why}"
        if t >= told.contradicted and why and told.explained == math.inf:
            told.explained = t


def run(case: Case, *, objects: bool = False, course: list[tuple[float, ...]] | None = None) -> Outcome:
    """Run a case.

    Args:
        case: which.
        objects: whether the controller is embedded, instead of the compiled step of a node.
        course: takes a row for each sample: time [s], squeeze and least squeeze [N], slide of the object and
            of the finger that slid most [m].

    """
    trial = Trial(case, objects=objects)
    for k in range(round(case.duration * case.rate)):
        trial.step(k)
        if course is not None:
            course.append(trial.row)
        if trial.told.dropped < math.inf:
            break
    trial.told.friction = trial.hand.controller.contact("thumb").friction_coefficient.value
    return trial.told


@dataclass(frozen=True)
class World:
    """Between which bounds a case is drawn."""

    mu: tuple[float, float]  # [-] at 5 N
    exponent: float = 0.0  # [-] most by which friction falls with the force
    tangential_gain: tuple[float, float] = (1.0, 1.0)


WORLDS = {"old": World((0.15, 1.5)), "real": World((0.2, 1.1), 0.33, (0.8, 1.05))}
"""old: friction that no force changes, gains that are right. real: what is published of soft fingertips,
drawn independently of any belief."""


def draw(rng: np.random.Generator, fault: str = "", world: World = WORLDS["real"]) -> Case:
    """Draw a case from the whole space."""
    low, high = world.mu
    mu = float(np.exp(rng.uniform(math.log(low), math.log(high))))
    exponent = float(rng.uniform(0.0, world.exponent)) if world.exponent else 0.0
    most = 15.0 * 2.0 * mu * (7.5 / STATED_AT_N) ** -exponent / 1.8 * 0.5
    """[N] load that half of the largest force holds"""
    n = int(rng.integers(2, 6))
    make = Make(
        fingers=n, mu=mu, load=float(rng.uniform(0.4, 1.0)) * min(3.0, most),
        drive=float(np.exp(rng.uniform(math.log(3.0), math.log(80.0)))),
        stiffness=float(np.exp(rng.uniform(math.log(1000.0), math.log(4000.0)))),
        kinetic=float(rng.choice([1.0, 0.9])), seed=int(rng.integers(1, 10_000)), exponent=exponent,
    )  # fmt: skip
    names = [name for name in FAULTS if name not in ("none",)]
    start, which = draw_occurrence(rng, n)
    gain = 1.0 if rng.random() < 0.7 else float(np.exp(rng.uniform(math.log(0.4), math.log(2.5))))
    case = Case(
        make, fault or str(rng.choice(names)), start, which, gain, bool(rng.random() < 0.5),
        rises=int(rng.integers(4, 16)), rise_at=start + float(rng.uniform(-0.1, 0.3)) if start > 2.0 else 0.0,
        exact=bool(rng.random() < 0.3), seed=int(rng.integers(1, 10_000)),
    )  # fmt: skip
    low, high = world.tangential_gain
    return replace(case, tangential_gain=float(rng.uniform(low, high))) if low < high else case


def draw_occurrence(rng: np.random.Generator, fingers: int) -> tuple[float, tuple[int, ...]]:
    """Draw when a fault begins [s], and on which fingers; none = all."""
    start = 0.0 if rng.random() < 0.4 else float(rng.uniform(0.5, 55.0))
    size = int(rng.choice([fingers, fingers, 1, min(2, fingers)]))
    return start, () if size == fingers else tuple(int(i) for i in rng.choice(fingers, size, replace=False))


def without_a_channel(case: Case) -> Case:
    """Return the same without a slip channel: what there is to fall back to.

    Faults of other sensors stay, and what is pressed after the first fault is told of the same time.
    """
    after = case.begins + 5.0 if case.sensor_faults else -1.0
    return replace(case, fault="absent", start=0.0, which=(), also=case.sensor_faults, after=after)
