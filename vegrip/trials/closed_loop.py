"""Hand and controller in one loop of simulated time: no bus, no waiting, the same bits every time.

The controller is the very :class:`~vegrip.grip.GripController` of the node on the bus, and its compiled step
answers every state. What it answers to the states of one period acts on the hand from the next period on,
which is the delay that a bus would bring.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from vegrip.clock import NS
from vegrip.estimator import ContactEstimator
from vegrip.grip.controller import GripController, MakeEstimator
from vegrip.grip.parameters import GraspParameters, estimator_factory
from vegrip.hand_sample import HandSample
from vegrip.messages import ContactEstimate, FingertipState
from vegrip.trials.candidates import BOUND, parameters
from vegrip.trials.known_contact import KnownContact, LeastForce, Plant, least_force
from vegrip.trials.published_friction import TANGENTIAL_GAIN_RANGE, draw_friction
from vegrip.types import Floats
from vegrip.virtual import Disturbance, HandSettings, VirtualHand, disturbances
from vegrip.virtual.disturbance import Wetting
from vegrip.virtual.hand import TRUTHS

SETTLED_S = 1.0
"""[s] from here on the hand carries the object by itself; figures of the comparison start here."""

WORLDS = ("old", "published")
"""old: constant friction that is drawn evenly, and tangential forces as they are. published: friction, its
exponent and the gain of tangential forces as published (:mod:`.published_friction`)."""

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
    world: str = "old"  # one of WORLDS
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
        friction = float(rng.uniform(*FRICTION_RANGE))
        if self.world == "old":
            return replace(hand, tip=replace(tip, friction=friction))
        rng = np.random.default_rng([self.seed, 6])
        _, mu, exponent = draw_friction(rng)
        gain = float(rng.uniform(*TANGENTIAL_GAIN_RANGE))
        tip = replace(tip, friction=mu, friction_exponent=exponent)
        return replace(hand, tip=tip, sensor=replace(hand.sensor, tangential_gain=gain))

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


PERIOD_S = 0.002
SAMPLING_S = 0.01
BELIEF_PERIOD_S = 0.05
STATED_EVERY = 5  # samples of the course

FORCE, FORCE_X, FORCE_Y, TORQUE, FRICTION, RADIUS, K, UTILISATION, SLIP_DISTANCE = (
    TRUTHS.index(name)
    for name in (
        "normal_force", "tangential_force_x", "tangential_force_y", "torque_z", "friction_coefficient",
        "contact_radius", "pressure_exponent", "utilisation", "slip_distance",
    )
)  # fmt: skip

Spoil = Callable[[Floats], None]
"""Changes the sensed values of all fingers in place, (n, 9): what is wrong with the sensors."""


@dataclass
class Course:
    """What happened, sampled every :data:`SAMPLING_S`; columns in the order of ``fingers``."""

    fingers: tuple[str, ...]
    slips: int = 0
    dropped: bool = False
    time: list[float] = field(default_factory=list)  # [s]
    margin: list[Floats] = field(default_factory=list)  # [-] true margins
    force: list[Floats] = field(default_factory=list)  # [N] true normal forces
    command: list[Floats] = field(default_factory=list)  # [N] NaN = none
    slipped: list[int] = field(default_factory=list)  # slips so far
    contact: list[Floats] = field(default_factory=list)
    """True tangential force [N], torque [N m], friction, contact radius [m] and pressure exponent."""
    friction_exponent: float = 0.0  # [-] by which friction falls with the force
    least: LeastForce = least_force  # of the contacts
    stated: list[Floats] = field(default_factory=list)
    """Mean and std of ln mu as stated of each finger, (fingers, 2); NaN without a contact or look."""
    friction: list[tuple[float, float, float]] = field(default_factory=list)
    """What is published of the first finger's friction: time [s], estimate [-], its std [-]."""
    largest_micro_slip: float = 0.0  # [m] of slides of a whole patch that are too short to count as a slip
    lags: tuple[float, ...] = ()  # [s] measured lag of each drive at the end; NaN = not known
    slid: float = 0.0  # [m] the longest way that a patch has slid as a whole, in all

    def since(self, start: float) -> tuple[Floats, Floats, Floats]:
        """Return time (n,) [s], margins (n, fingers) [-] and forces (n, fingers) [N] from ``start`` on."""
        time = np.array(self.time)
        kept = time >= start
        return time[kept], np.array(self.margin)[kept], np.array(self.force)[kept]

    def sample(self, hand: Plant, commands: Iterable[float]) -> None:
        """Add the truth of ``hand``, whose fingers are those of the course, and the commands [N]."""
        truth = hand.truths()
        self.time.append(hand.time)
        self.slipped.append(hand.slips)
        self.margin.append(1.0 - truth[:, UTILISATION])
        self.force.append(truth[:, FORCE])
        pull = np.hypot(truth[:, FORCE_X], truth[:, FORCE_Y])
        rest = truth[:, [FRICTION, RADIUS, K]]
        self.contact.append(np.column_stack([pull, np.abs(truth[:, TORQUE]), rest]))
        self.command.append(np.array(commands))

    def finish(self, hand: Plant) -> None:
        self.slips, self.dropped = hand.slips, hand.dropped
        self.largest_micro_slip = hand.largest_micro_slip
        self.slid = float(hand.truths()[:, SLIP_DISTANCE].max())

    def believe(self, contact: ContactEstimate, time: float) -> None:
        """Note what is published of friction at ``time`` [s], every :data:`BELIEF_PERIOD_S`."""
        mu = contact.friction_coefficient
        if contact.finger != self.fingers[0] or not (contact.in_contact and mu.valid):
            return
        if not self.friction or time >= self.friction[-1][0] + BELIEF_PERIOD_S:
            self.friction.append((time, mu.value, mu.std))


class Loop:
    """Steps a hand and its controller against each other."""

    def __init__(
        self,
        hand: Plant,
        grip: GripController,
        spoil: Spoil | None = None,
        least: LeastForce = least_force,
    ) -> None:
        self.hand, self.grip, self._spoil = hand, grip, spoil
        self.commands = np.full(len(hand.fingers), np.nan)  # [N]
        self.course = Course(hand.fingers, friction_exponent=hand.friction_exponent, least=least)

    def run(self, duration: float) -> Course:
        """Run to ``duration`` [s] of simulated time, or until the object is lost."""
        while self.hand.time < duration - 0.5 * PERIOD_S and not self.hand.dropped:
            self.step()
        self.course.finish(self.hand)
        return self.course

    def step(self) -> None:
        """Advance by one period."""
        hand, course = self.hand, self.course
        samples = hand.advance(PERIOD_S, self.commands)
        for sample in samples:
            if self._spoil is not None:
                self._spoil(sample.values)
        self.answer(samples, round(hand.time * NS))
        if hand.time >= len(course.time) * SAMPLING_S:
            course.sample(hand, self.commands)
            course.stated.append(self.stated())

    def answer(self, samples: Sequence[HandSample], now: int) -> None:
        """Let the controller answer what came at ``now`` [ns]."""
        grip, fingers = self.grip, self.grip.fingers.values()
        is_quiet = not samples
        for sample in samples:
            rows = zip(fingers, sample.values, sample.stamps.tolist(), sample.lost.tolist(), strict=True)
            for finger, values, stamp, lost in rows:
                if lost:
                    is_quiet = True
                elif finger.is_whole:
                    finger.answer_values(values, sample.seq, stamp, now)
                else:
                    grip.answer(FingertipState(stamp, finger.name, sample.seq, *values.tolist()), now)
        for name in grip.names if is_quiet else ():
            grip.watch(name, now)
        self.commands[:] = [finger.held for finger in fingers]

    def stated(self) -> Floats:
        """Return what is stated of the friction of each finger, now and then: it costs what a step costs."""
        stated = np.full((len(self.hand.fingers), 2), np.nan)
        if len(self.course.stated) % STATED_EVERY == 0:
            for row, finger in zip(stated, self.grip.fingers.values(), strict=True):
                estimator = finger.estimator
                if isinstance(estimator, ContactEstimator) and estimator.in_contact:
                    mean, variance = estimator.friction
                    row[:] = self.grip.friction.stated_friction(mean, math.sqrt(variance))
        return stated


def grip_of(
    settings: GraspParameters, fingers: tuple[str, ...], make: MakeEstimator | None = None
) -> GripController:
    """Return a controller of these parameters; ``make`` gives other estimators than theirs."""
    tips = {finger: tip for finger, tip in settings.tips.items() if finger in fingers}
    settings = replace(settings, tips=tips)
    make = make or estimator_factory(settings, fingers, "trial")
    return GripController(fingers, settings=settings, make_estimator=make)


def run_grip(
    hand: Plant,
    settings: GraspParameters,
    duration: float,
    *,
    knows: bool = False,
    spoil: Spoil | None = None,
    least: LeastForce = least_force,
) -> Course:
    """Run a controller to ``duration`` [s], or until the object is lost.

    One that ``knows`` has the truth of friction and contact instead of an estimate; ``least`` is the limit
    of the hand's contacts.
    """
    grip = grip_of(settings, hand.fingers, partial(KnownContact, hand, least=least) if knows else None)
    course = Loop(hand, grip, spoil, least).run(duration)
    course.lags = tuple(map(grip.drive_lag, hand.fingers))
    return course


def run_scenario(scenario: Scenario, name: str, knob: float) -> Course:
    settings = parameters(name, knob, scenario.settings.tip.friction)
    return run_grip(scenario.hand(), settings, scenario.duration, knows=name == BOUND)


@dataclass(frozen=True, slots=True)
class Result:
    """Figures of one run, from the truth of the hand, not from an estimate.

    Grip force is the normal force on the first finger, which equals the sum of what the others press.
    """

    slips: int
    dropped: bool
    mean_grip_force: float  # [N] while the object was held
    peak_grip_force: float  # [N]
    min_margin: float  # [-] least of all fingers; zero or less on the limit surface


def result_of(course: Course, until: float = math.inf) -> Result:
    """Sum up ``course`` from the time on that the hand carries the object.

    Force and margin are those up to ``until`` [s].
    """
    time, margin, force = course.since(SETTLED_S)
    margin, force = margin[time <= until], force[time <= until]
    if not len(force):
        return Result(course.slips, course.dropped, math.nan, math.nan, math.nan)
    return Result(
        slips=course.slips,
        dropped=course.dropped,
        mean_grip_force=float(np.mean(force[:, 0])),
        peak_grip_force=float(np.max(force[:, 0])),
        min_margin=float(np.min(margin)),
    )
