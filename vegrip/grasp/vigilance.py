"""How often the live health cries wolf, and how soon it sees what is hidden, on independent fingertips.

``python -m vegrip.grasp.vigilance --fingers 8 --contacts 40`` draws fingertips of the virtual hand, fits each
a model to eight contacts in which nothing is hidden, lets the node's estimator with that model feel further
contacts with nothing and with something hidden, and prints what its health said. ``--suspects`` also asks who
is behind it, as the node would.
"""

import argparse
import json
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace

import numpy as np

from vegrip.clock import NS
from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.fit import fit
from vegrip.grasp.suspicion import Evidence, look_elsewhere
from vegrip.messages import FingertipState
from vegrip.model import ContactModel
from vegrip.recording import Fingertip, Recording
from vegrip.simulate import Protocol, Segment
from vegrip.simulate.bench import Benches
from vegrip.virtual import FingertipSettings, HandSettings, random_fingertip
from vegrip.virtual.settings import SensorSettings

HIDDEN: Mapping[str, Mapping[str, Mapping[str, float]]] = {
    "nothing": {},
    "adhesion": {"adhesion": {"force": 0.05}},
    "second_relaxation": {"second_relaxation": {"amplitude": 0.15, "rate": 0.2}},
    "series_compliance": {"series_compliance": {"compliance": 2e-4}},
    "sensor_lag": {"sensor_lag": {}},
    "mullins_softening": {"mullins_softening": {}},
    "displacement_backlash": {"displacement_backlash": {}},
}
RATE = 250.0  # [Hz] of the states
LOOK = 0.2  # [s] from one report of the health to the next
FIT = 8  # contacts from which the model is fitted
SENSORS = SensorSettings(rate=RATE, force_bias=0.0, displacement_bias=0.0)


@dataclass(frozen=True)
class Seen:
    """What the health said in one run."""

    hidden: str
    finger: int
    duration: float  # [s]
    failing: float  # share of the reports that say the model fails
    first: float | None  # [s] until the first of them
    cell: str  # channel and regime that were told most often
    suspect: str | None  # who was named; None = nobody was asked


def contacts(radius: float, count: int, seed: int) -> Protocol:
    """Return grasps of all kinds: fast and slow, short and long, light and firm, some gripped anew."""
    rng = np.random.default_rng(seed)
    away = -0.025 * radius
    segments = [Segment(0.5, depth=away)]
    for _ in range(count):
        depth = rng.uniform(0.06, 0.16) * radius
        rise, fall = rng.choice([0.1, 0.3, 1.0], 2)
        segments += [Segment(float(rise), depth=depth), Segment(rng.uniform(0.3, 4.0))]
        if rng.random() < 0.5:
            segments += [Segment(0.2, depth=depth * rng.uniform(0.5, 1.1)), Segment(rng.uniform(0.3, 2.0))]
        segments += [Segment(float(fall), depth=away), Segment(rng.uniform(0.5, 2.0))]
    return Protocol("grasps", (tuple(segments),), 0.0)


def plain_fingertip(seed: int) -> FingertipSettings:
    """Return a fingertip that the paper's model can describe: one relaxation time, stiff bristles."""
    rng = np.random.default_rng(seed)
    amplitude, rate = float(rng.uniform(0.1, 0.35)), float(rng.uniform(0.8, 5.0))
    return replace(random_fingertip(rng), amplitudes=(amplitude,), rates=(rate,), bristle_stiffness=1e10)


def felt(tip: FingertipSettings, count: int, seed: int, hidden: str) -> list[FingertipState]:
    """Return what ``tip`` feels in ``count`` contacts."""
    hand = HandSettings(tip=tip, sensor=SENSORS, spread=0.0)
    benches = Benches(("index",), hand, contacts(tip.radius, count, seed), seed, HIDDEN[hidden])
    return benches.step(benches.duration)


def fitted(tip: FingertipSettings, seed: int) -> ContactModel:
    """Return the model of ``tip`` from contacts in which nothing is hidden."""
    states = felt(tip, FIT, seed, "nothing")[::2]
    t = np.array([s.stamp for s in states]) / NS
    columns = {c: np.array([getattr(s, c) for s in states]) for c in ("displacement", "normal_force")}
    sensors = {"normal_force": SENSORS.normal_force, "displacement": SENSORS.displacement}
    return fit(
        Recording("felt", t, np.zeros(t.size, dtype=np.int64), columns, Fingertip(tip.radius), sensors)
    ).model


def watched(hidden: str, finger: int, count: int, *, ask: bool) -> Seen:
    """Let the estimator feel ``count`` contacts; return what its health said."""
    tip = plain_fingertip(finger)
    model = fitted(tip, 1000 + finger)
    estimator, evidence = ContactEstimator(model, SensorNoise()), Evidence()
    reports: list[tuple[float, str]] = []
    next_look = 0
    states = felt(tip, count, finger, hidden)
    for state in states:
        estimator.assimilate(state)
        evidence.note(state, estimator.in_contact)
        if state.stamp >= next_look:
            next_look = state.stamp + round(LOOK * NS)
            health = estimator.health()
            reports.append((state.stamp / NS, f"{health.channel}, {health.regime}" if health.channel else ""))
    failing = [(time, cell) for time, cell in reports if cell]
    suspect = look_elsewhere(evidence.columns(), model, asdict(SensorNoise())) if ask and failing else None
    often = Counter(cell for _, cell in failing).most_common(1)
    return Seen(
        hidden,
        finger,
        states[-1].stamp / NS,
        len(failing) / len(reports),
        failing[0][0] if failing else None,
        often[0][0] if often else "",
        suspect,
    )


def _watched(job: tuple[str, int, int, bool]) -> Seen:
    hidden, finger, count, ask = job
    return watched(hidden, finger, count, ask=ask)


def main(arguments: list[str] | None = None) -> int:
    """Run all and print a line for each, then the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else None)
    parser.add_argument("--fingers", type=int, default=4)
    parser.add_argument("--contacts", type=int, default=20)
    parser.add_argument("--hidden", nargs="*", default=list(HIDDEN), choices=list(HIDDEN))
    parser.add_argument("--suspects", action="store_true")
    parser.add_argument("--processes", type=int, default=1)
    given = parser.parse_args(arguments)
    jobs = [(h, f, given.contacts, given.suspects) for f in range(given.fingers) for h in given.hidden]
    seen = []
    with ProcessPoolExecutor(given.processes) as pool:
        for one in pool.map(_watched, jobs):
            seen.append(one)
            print(json.dumps(asdict(one)), file=sys.stderr, flush=True)  # noqa: T201
    for line in _table(seen, given.hidden):
        print(line)  # noqa: T201
    return 0


def _table(seen: list[Seen], names: list[str]) -> Iterator[str]:
    yield f"{'hidden':24s}{'minutes':>8s}{'seen in':>9s}{'of reports':>12s}{'after':>9s}  mostly in; named"
    for name in names:
        runs = [one for one in seen if one.hidden == name]
        alarms = [one for one in runs if one.first is not None]
        minutes = sum(one.duration for one in runs) / 60.0
        share = float(np.mean([one.failing for one in runs]))
        after = f"{np.median([one.first for one in alarms]):.0f} s" if alarms else "-"
        cell = Counter(one.cell for one in alarms).most_common(1)
        asked = [one for one in alarms if one.suspect is not None]
        named = f"; {sum(one.suspect == name for one in asked)} of {len(asked)}" if asked else ""
        yield (
            f"{name:24s}{minutes:8.1f}{len(alarms):5d} of {len(runs):d}{100.0 * share:10.1f} %{after:>9s}"
            f"  {cell[0][0] if cell else '-'}{named}"
        )


if __name__ == "__main__":
    sys.exit(main())
