"""The cases of a trial, and their recordings.

A case is the names of what is hidden, a size and a seed; everything else - fingertip, noise, protocol,
temperatures - is drawn from the seed. The bench shares no physics code with the model, and several of its
laws have another form than the catalogue's.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from validation.diagnosis_trials.amounts import (
    CATALOGUE_AMOUNTS,
    DRAWN_BY_NAME,
    UNMODELLED_AMOUNTS,
    WEAK,
    Setting,
)
from validation.diagnosis_trials.faults import NO_FAULTS, STAMP_JITTER_S, Faults, uneven_rows
from validation.diagnosis_trials.unmodelled import EVERY
from vegrip.identification.blind import KINDS
from vegrip.identification.recording import Fingertip, Recording
from vegrip.identification.recording.checks import longest_increasing
from vegrip.virtual.bench.protocol import AIR_SEGMENT, Episode, Segment, hold, slip, standard_protocol
from vegrip.virtual.bench.trial import run_trial
from vegrip.virtual.hidden import Clocked
from vegrip.virtual.settings import FingertipSettings, SensorSettings, random_fingertip

MIX = (("none", 6), ("one", 8), ("pair", 3), ("outside", 3))
"""How many of twenty trials are of each kind."""

STRENGTHS = {"strong": 1.0, "weak": WEAK}
SEEN_IN_RADIUS = {"contact_radius_law", "shear_shrinking"}
FELT_AS_WARMTH = {"temperature_shift", "warm_peak"}
CLEAR_S = 0.3  # [s] well above the surface before and after each episode
RESIDUAL_NOISE_SHARE = 1e-3  # of the noise, where there should be none
SIMULATION_STEP_S = 2.5e-3  # [s] of the simulation: 0.1 mN of error


@dataclass(frozen=True)
class Case:
    """One recording to be made."""

    hidden: tuple[str, ...]
    size: str
    seed: int
    places: int = 1  # that are pressed, in turn
    style: str = "laboratory"  # of the motion
    faults: Faults = NO_FAULTS  # of the recording

    @property
    def kind(self) -> str:
        """none, one, pair or outside (of any catalogue)."""
        if len(self.hidden) > 1:
            return "pair"
        return "none" if not self.hidden else "one" if self.hidden[0] in CATALOGUE_AMOUNTS else "outside"

    @property
    def key(self) -> str:
        """What names it in a file of results."""
        places = f" {self.places} places" if self.places > 1 else ""
        style = f" {self.style}" if self.style != "laboratory" else ""
        faults = f" {self.faults}".rstrip()
        return f"{'+'.join(self.hidden) or 'nothing'} {self.size} {self.seed}{places}{style}{faults}"


def draw_cases(
    count: int,
    seed: int = 0,
    kinds: Sequence[str] = KINDS,
    only: Sequence[str] = (),
    places: int = 1,
    style: str = "laboratory",
    faults: Faults = NO_FAULTS,
) -> Iterator[Case]:
    """Yield ``count`` cases of all ``kinds``, every effect in turn; ``only``: with one of these effects.

    Several ``places`` are pressed with nothing hidden that goes by the hour, which they would have in common.
    """
    turn = [kind for kind, share in MIX for _ in range(share) if kind in kinds]
    np.random.default_rng(0).shuffle(turn)
    names = {kind: _names(kind, only, places) for kind in kinds}
    done = dict.fromkeys(kinds, 0)
    for i in range(count):
        kind = turn[i % len(turn)]
        n, choice = done[kind], names[kind]
        done[kind] += 1
        hidden = choice[n % len(choice)]
        size = "weak" if kind == "one" and (n // len(choice) + n) % 2 else "strong"
        yield Case(hidden, size, 100_000 * seed + i, places, style, faults)


def _names(kind: str, only: Sequence[str], places: int) -> list[tuple[str, ...]]:
    if kind == "none":
        return [()]
    amounts = UNMODELLED_AMOUNTS if kind == "outside" else CATALOGUE_AMOUNTS
    drawn = [name for name in amounts if name not in DRAWN_BY_NAME or name in only]
    known = [name for name in drawn if places == 1 or not issubclass(EVERY[name], Clocked)]
    every: list[tuple[str, ...]] = list(combinations(known, 2 if kind == "pair" else 1))
    chosen = [names for names in every if not only or set(only) & set(names)] or every
    np.random.default_rng(1).shuffle(chosen)
    return [tuple(names) for names in chosen]


def make_recording(
    case: Case, times: int = 1, only: Collection[str] | None = None, *, quiet: bool = False
) -> Recording:
    """Make the recording of a case, with the protocol run through so many ``times``.

    ``only``: hide no more than these of its effects, all else the same; ``quiet``: next to no noise, though
    that of the sensors is stated.
    """
    rng = np.random.default_rng([case.seed, 7])
    tip = fingertip(rng)
    sensors = _sensors(case, rng)
    part = float(rng.uniform(0.6, 1.0))
    episodes = STYLES[case.style](tip, part, rng) * times
    warm = _temperatures(case, len(episodes), rng)
    setting = Setting(tip, sensors, 0.2 * part * tip.radius, STRENGTHS[case.size], rng)
    every = {name: {**CATALOGUE_AMOUNTS, **UNMODELLED_AMOUNTS}[name](setting) for name in case.hidden}
    hidden = {name: amount for name, amount in every.items() if only is None or name in only}
    taken = _quietened(sensors) if quiet else sensors
    if case.faults.jitter:
        taken = replace(taken, rate=1.0 / SIMULATION_STEP_S, jitter=STAMP_JITTER_S)
    trial = run_trial(
        [_elsewhere(tip, case.seed, place) for place in places_of(case, len(episodes))],
        episodes,
        taken,
        case.seed,
        hidden=hidden,
        catalogue=EVERY,
        temperature=warm,
        step=SIMULATION_STEP_S,
        rings=8,
        spokes=16,
        truth=False,
    )
    stated = {
        name: float(getattr(sensors, name))
        for name in ("normal_force", "displacement", "tangential_force", "torque_z", "contact_radius")
    }
    columns = trial.columns
    if case.faults.jitter:
        rows = uneven_rows(columns["t"].size, round(taken.rate / sensors.rate), case.seed)
        rows = rows[longest_increasing(columns["t"][rows])]
        columns = {name: values[rows] for name, values in columns.items()}
    t, episode = columns.pop("t"), columns.pop("episode").astype(np.int64)
    made = Recording(case.key, t, episode, columns, Fingertip(tip.radius), stated)
    return case.faults.spoil(made, episodes[0], setting.depth, case.seed)


def fingertip(rng: np.random.Generator) -> FingertipSettings:
    """Draw the fingertip of a case, the first of all that is drawn of ``make_recording``'s generator."""
    return replace(
        random_fingertip(rng),
        amplitudes=(float(rng.uniform(0.1, 0.35)),),
        rates=(float(np.exp(rng.uniform(np.log(0.8), np.log(5.0)))),),
        bristle_stiffness=1e10,
    )


def places_of(case: Case, episodes: int) -> tuple[int, ...]:
    """Return the number of the place that each episode presses."""
    return tuple(i % case.places for i in range(episodes))


def _elsewhere(tip: FingertipSettings, seed: int, place: int) -> FingertipSettings:
    """Return what another place of the same material is like: tens of percent stiffer or softer."""
    if not place:
        return tip
    rng = np.random.default_rng([seed, 17, place])
    return replace(
        tip,
        reference_force=tip.reference_force * float(np.exp(rng.normal(0.0, 0.3))),
        exponent=tip.exponent + float(rng.normal(0.0, 0.05)),
        amplitudes=tuple(float(c * np.exp(rng.normal(0.0, 0.15))) for c in tip.amplitudes),
        rates=tuple(float(nu * np.exp(rng.normal(0.0, 0.15))) for nu in tip.rates),
    )


def laboratory(tip: FingertipSettings, size: float, rng: np.random.Generator) -> tuple[Episode, ...]:
    """Return the standard protocol in any order, some episodes twice."""
    episodes = list(standard_protocol(tip, size=size))
    if rng.random() < 0.5:
        order = rng.permutation(len(episodes))
        episodes = [episodes[i] for i in order]
    again = rng.choice(len(episodes), size=int(rng.integers(0, 3)), replace=False)
    episodes += [episodes[i] for i in again]
    return _in_clear_air(episodes, 0.2 * size * tip.radius)


def short(tip: FingertipSettings, size: float, rng: np.random.Generator) -> tuple[Episode, ...]:
    """Return five presses and five slips, half a minute in all."""
    depth = 0.2 * size * tip.radius
    presses = [hold(part * depth, 1.5, float(rng.uniform(0.05, 0.5))) for part in rng.uniform(0.3, 1.0, 5)]
    slips = [
        slip(
            _force(tip, float(rng.uniform(0.3, 0.8)) * depth),
            float(rng.uniform(0.1, 1.0)),
            pull=0.4 * depth * float(rng.uniform(0.5, 3.0)),
            spin=0.6 * float(rng.random() < 0.3),
        )
        for _ in range(5)
    ]
    return _in_clear_air([*presses, *slips], depth)


def use(tip: FingertipSettings, size: float, rng: np.random.Generator) -> tuple[Episode, ...]:
    """Return a dozen grasps: closing at any speed, grips that change, loads that sometimes slip."""
    depth = 0.2 * size * tip.radius

    def grip() -> Segment:
        part, seconds = float(rng.uniform(0.3, 1.0)), float(rng.uniform(0.05, 0.8))
        if rng.random() < 0.4:
            return Segment(seconds, force=_force(tip, 0.7 * part * depth))
        return Segment(seconds, depth=part * depth)

    def grasp() -> Episode:
        first, speed = float(rng.uniform(0.3, 1.0)), float(np.exp(rng.uniform(np.log(0.5), np.log(20.0))))
        held = [one for _ in range(4) for one in (grip(), Segment(float(rng.uniform(0.05, 0.8))))]
        slides = rng.random() < 0.5
        pull = Segment(
            0.8, pull_x=0.4 * depth * float(rng.uniform(0.5, 3.0)), spin=0.6 * float(rng.random() < 0.25)
        )
        load = [pull, Segment(0.2)] if slides else []
        release = Segment(float(rng.uniform(0.05, 0.5)), depth=0.0)
        return (AIR_SEGMENT, Segment(first / speed, depth=first * depth), *held, *load, release, AIR_SEGMENT)

    return _in_clear_air([grasp() for _ in range(12)], depth)


STYLES = {"laboratory": laboratory, "short": short, "use": use}


def _force(tip: FingertipSettings, depth: float) -> float:
    return float(tip.reference_force * (depth / tip.reference_indentation) ** tip.exponent)


def _in_clear_air(episodes: Sequence[Episode], depth: float) -> tuple[Episode, ...]:
    away = Segment(CLEAR_S, depth=-0.1 * depth)
    return tuple((away, *episode, away) for episode in episodes)


def _sensors(case: Case, rng: np.random.Generator) -> SensorSettings:
    """Draw the noise; a camera sees the radius in half of the recordings, and where only it would show."""
    louder = float(np.exp(rng.uniform(np.log(0.5), np.log(2.0))))
    shaky = float(np.exp(rng.uniform(np.log(0.4), np.log(1.6))))
    sees = bool(rng.random() < 0.5) or bool(SEEN_IN_RADIUS & set(case.hidden))
    return SensorSettings(
        rate=float(rng.choice([100.0, 100.0, 200.0])),
        normal_force=0.01 * louder,
        tangential_force=0.01 * louder,
        displacement=5e-6 * shaky,
        radius_sensor=sees,
        force_bias=2e-3,
    )


def _quietened(sensors: SensorSettings) -> SensorSettings:
    noises = ("normal_force", "tangential_force", "torque_z", "displacement", "contact_radius")
    return replace(sensors, **{name: RESIDUAL_NOISE_SHARE * getattr(sensors, name) for name in noises})


def _temperatures(case: Case, count: int, rng: np.random.Generator) -> list[float]:
    """Draw the temperature of each episode: the same, or up and down again."""
    swing = float(rng.uniform(3.0, 6.0))
    phase = float(rng.uniform(0.0, 2.0 * np.pi))
    varies = bool(rng.random() < 0.5) or bool(FELT_AS_WARMTH & set(case.hidden))
    turns = 2.0 * np.pi * 1.5 * np.arange(count) / count + phase
    warm = 25.0 + swing * np.sin(turns) + rng.normal(0.0, 0.5, count)
    return [float(one) for one in warm] if varies else [22.0] * count
