"""``python -m validation.changed_pairs``: what is said of recordings between which a known thing changed.

Both are made on the virtual bench, which shares no physics code with the model, by one fingertip and one set
of sensors; in the second one thing, two or nothing is another by 3 to 20 %, up or down (zeros by that share
of 100 mN and 100 um). Noise, rate, depth and motions are drawn, the motions of each recording anew, in the
styles of the trials of diagnosis: of a bench, short, in use, and one of a bench with one in use.

*Right* is an answer of which what is sure, with one choice from every set, is what changed. A change *shows*
where the true difference gains 20 nats over none. Exit code 1 beyond the goals.
"""

import argparse
import json
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from multiprocessing import get_context
from typing import Any

import numpy as np

from validation.diagnosis_trials.amounts import CATALOGUE_AMOUNTS, UNMODELLED_AMOUNTS, Setting
from validation.diagnosis_trials.cases import SIMULATION_STEP_S, STYLES, Case, _sensors, fingertip
from validation.diagnosis_trials.unmodelled import EVERY
from vegrip.identification.changed import Changed, changed
from vegrip.identification.recording import Fingertip, Recording
from vegrip.virtual.bench.trial import run_trial
from vegrip.virtual.settings import FingertipSettings, SensorSettings

KINDS = (
    ("K",),
    (),
    ("mu",),
    ("gain_normal_force",),
    ("c1",),
    (),
    ("zero_normal_force",),
    ("nu1",),
    ("K", "zero_normal_force"),
    (),
    ("tip_radius",),
    ("zero_displacement",),
    ("gain_tangential_force",),
    ("K", "mu"),
    (),
    ("K", "c1"),
)
MOTIONS = (("laboratory", "laboratory"), ("use", "use"), ("short", "short"), ("laboratory", "use"))
LEAST, MOST = 0.03, 0.2  # of a change
FULL_ZERO = {"zero_normal_force": 0.1, "zero_displacement": 100e-6}  # [N], [m] of which a zero is a share
SHOWS_NATS = 20.0
MIN_RIGHT, MAX_FALSE, MIN_COVERED, MAX_COVERED = 0.95, 0.03, 0.92, 0.98  # the goals


@dataclass(frozen=True)
class Pair:
    """What was made."""

    seed: int
    motions: tuple[str, str]
    truth: dict[str, float]  # logarithm of the ratio by name, of a zero the difference [SI]
    beside: str = ""  # an effect that both recordings have and the paper's model has not


@dataclass(frozen=True)
class Outcome:
    """What was said of it."""

    pair: Pair
    verdict: str
    sentence: str
    is_exact: bool  # named, and nothing beside
    is_right: bool
    is_false: bool  # something is said, and it is not that
    shows: bool
    errors: dict[str, float]  # of what was said rightly, over its standard error


def drawn(count: int, seed: int, beside: str = "") -> Iterator[Pair]:
    """Yield pairs of all kinds and motions in turn."""
    for i in range(count):
        rng = np.random.default_rng([seed, i, 21])
        kind = KINDS[i % len(KINDS)]
        sizes = np.exp(rng.uniform(np.log(LEAST), np.log(MOST), len(kind))) * rng.choice(
            [-1.0, 1.0], len(kind)
        )
        truth = {
            name: float(size * FULL_ZERO[name] if name in FULL_ZERO else np.log1p(size))
            for name, size in zip(kind, sizes, strict=True)
        }
        yield Pair(100_000 * seed + i, MOTIONS[(i // len(KINDS) + i) % len(MOTIONS)], truth, beside)


def made(pair: Pair) -> tuple[Recording, Recording]:
    """Return the recordings of a pair."""
    rng = np.random.default_rng([pair.seed, 7])
    tip = fingertip(rng)
    x_ref = 0.1 * tip.radius  # K is the force there: so a change of the exponent is none of K
    force = tip.reference_force * (x_ref / tip.reference_indentation) ** tip.exponent
    tip = replace(tip, reference_force=force, reference_indentation=x_ref)
    sensors = replace(_sensors(Case((), "strong", pair.seed), rng), force_bias=0.0, displacement_bias=0.0)
    setting = Setting(tip, sensors, 0.16 * tip.radius, 1.0, rng)
    hidden = (
        {pair.beside: {**CATALOGUE_AMOUNTS, **UNMODELLED_AMOUNTS}[pair.beside](setting)}
        if pair.beside
        else {}
    )
    tips = tip, _changed_tip(tip, pair.truth)
    first, second = (
        _recorded(tips[i], tip.radius, sensors, pair.motions[i], 2 * pair.seed + i, hidden) for i in range(2)
    )
    columns = dict(second.columns)
    for name, size in pair.truth.items():
        kind, _, channel = name.partition("_")
        for one in [f"{channel}_x", f"{channel}_y"] if channel == "tangential_force" else [channel]:
            if kind == "gain":
                columns[one] = columns[one] * np.exp(size)
            elif kind == "zero":
                columns[one] = columns[one] + size
    return first, replace(second, columns=columns)


def _changed_tip(tip: FingertipSettings, truth: dict[str, float]) -> FingertipSettings:
    by = {name: float(np.exp(size)) for name, size in truth.items()}
    return replace(
        tip,
        reference_force=tip.reference_force * by.get("K", 1.0),
        amplitudes=(tip.amplitudes[0] * by.get("c1", 1.0),),
        rates=(tip.rates[0] * by.get("nu1", 1.0),),
        friction=tip.friction * by.get("mu", 1.0),
        radius=tip.radius * by.get("tip_radius", 1.0),
    )


def _recorded(
    tip: FingertipSettings,
    radius: float,
    sensors: SensorSettings,
    style: str,
    seed: int,
    hidden: Mapping[str, Mapping[str, float]],
) -> Recording:
    rng = np.random.default_rng([seed, 8])
    episodes = STYLES[style](tip, float(rng.uniform(0.6, 1.0)), rng)
    trial = run_trial(
        tip, episodes, sensors, seed, step=SIMULATION_STEP_S, rings=8, spokes=16, truth=False,
        hidden=hidden, catalogue=EVERY,
    )  # fmt: skip
    columns = dict(trial.columns)
    channels = ("normal_force", "displacement", "tangential_force", "torque_z", "contact_radius")
    stated = {name: float(getattr(sensors, name)) for name in channels}
    t, episode = columns.pop("t"), columns.pop("episode").astype(np.int64)
    return Recording(f"{style} {seed}", t, episode, columns, Fingertip(radius), stated)


def judged(pair: Pair) -> Outcome:
    """Make a pair, and judge what is said of it."""
    found = changed(*made(pair))
    pair_of, truth = found.pair, set(pair.truth)
    sets = [set(one) for one in found.choice.rivals]
    is_right = truth in sets and not found.new_effects
    is_false = found.verdict != "nothing" and not is_right  # something is said, and it is not that
    gain = pair_of.cost(()) - pair_of.cost([name for name in pair_of.questions if name in truth])
    return Outcome(
        pair, found.verdict, found.sentence, is_right and len(sets) == 1, is_right, is_false,
        gain > SHOWS_NATS,
        dict(_errors(found, pair.truth)) if is_right else {},
    )  # fmt: skip


def _errors(found: Changed, truth: dict[str, float]) -> Iterator[tuple[str, float]]:
    for one in found.changes:
        if one.name in truth:
            size = truth[one.name]
            true = size if one.name in FULL_ZERO else one.before * np.expm1(size)
            yield one.name, float((one.after - one.before - true) / one.std)


def summary(outcomes: list[Outcome]) -> dict[str, Any]:
    """Return the figures of the goals."""
    changes = [one for one in outcomes if one.pair.truth]
    shown = [one for one in changes if one.shows]
    none = [one for one in outcomes if not one.pair.truth]
    errors = np.array([error for one in outcomes for error in one.errors.values()])
    return {
        "pairs": len(outcomes),
        "shown": len(shown),
        "right": sum(one.is_right for one in shown) / max(len(shown), 1),
        "named_exactly": sum(one.is_exact for one in shown) / max(len(shown), 1),
        "right_of_all": sum(one.is_right for one in changes) / max(len(changes), 1),
        "nothing": len(none),
        "false_changes": sum(one.verdict != "nothing" for one in none) / max(len(none), 1),
        "false_of_all": sum(one.is_false for one in outcomes) / max(len(outcomes), 1),
        "intervals": errors.size,
        "covered": float(np.mean(np.abs(errors) < 1.96)) if errors.size else 1.0,
    }


def is_reached(told: dict[str, Any]) -> bool:
    is_right = told["right"] >= MIN_RIGHT and told["false_changes"] <= MAX_FALSE
    return bool(is_right and MIN_COVERED <= told["covered"] <= MAX_COVERED)


def main(arguments: list[str] | None = None) -> int:
    """Print a line for each pair that is not named exactly, and the figures."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else None)
    parser.add_argument("-n", "--pairs", type=int, default=96)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--beside", default="", metavar="EFFECT", help="that both have and the model lacks")
    parser.add_argument("--json", action="store_true", help="one JSON object, with every pair")
    given = parser.parse_args(arguments)
    outcomes: list[Outcome] = []
    with ProcessPoolExecutor(given.jobs, get_context("spawn")) as pool:
        every = drawn(given.pairs, given.seed, given.beside)
        for one in pool.map(judged, every) if given.jobs > 1 else map(judged, every):
            outcomes.append(one)
            kind = (
                "exact"
                if one.is_exact
                else "in a set"
                if one.is_right
                else "FALSE"
                if one.is_false
                else "missed"
            )
            truth = ", ".join(f"{name} {size:+.3g}" for name, size in one.pair.truth.items()) or "nothing"
            seen = "" if one.shows or not one.pair.truth else " (does not show)"
            made_by = f"{one.pair.seed:7d} {'/'.join(one.pair.motions):22s}"
            out = sys.stderr if given.json else sys.stdout
            print(f"{kind:9s}{made_by}{truth}{seen} -> {one.sentence}", file=out, flush=True)
    told = summary(outcomes)
    if given.json:
        print(json.dumps({**told, "outcomes": [asdict(one) for one in outcomes]}))  # noqa: T201
    else:
        print(Counter(one.verdict for one in outcomes))  # noqa: T201
        print(*(f"{name:15s}{value:.4g}" for name, value in told.items()), sep="\n")  # noqa: T201
    return 0 if is_reached(told) else 1


if __name__ == "__main__":
    sys.exit(main())
