"""How often the live health cries wolf, and how soon it sees what is hidden, on independent fingertips.

``python -m validation.health_detection --first 100 --fingers 8 --contacts 40`` draws virtual
fingertips, fits each a model to eight contacts in which nothing is hidden, lets the node's estimator with
that model feel further contacts with nothing and with something hidden, and prints what its health said.
``--suspects`` also asks which effect is behind it, as the node would.
"""

import argparse
import json
import sys
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace

import numpy as np

from validation.diagnosis_trials.amounts import CATALOGUE_AMOUNTS, Setting
from vegrip.clock import NS
from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.estimator.memory import CHANNELS
from vegrip.grip.background_diagnosis import KeptStates, SampleRing, diagnose_in_subprocess
from vegrip.identification.fit import fit
from vegrip.identification.recording import Fingertip, Recording
from vegrip.identification.simulate import Protocol, Segment
from vegrip.identification.simulate.bench import Benches, Hidden
from vegrip.messages import FingertipState
from vegrip.model import ContactModel
from vegrip.virtual import FingertipSettings, HandSettings, random_fingertip
from vegrip.virtual.settings import SensorSettings

NO_EFFECT = "nothing"
UNSEEN = (
    "load_dependent_friction",
    "rate_dependent_friction",
    "friction_ageing",
    "wet_contact",
    "cross_talk",
    "contact_radius_law",
    "pressure_profile",
    "temperature_shift",
)
"""Effects that change nothing here: nothing is rubbed or warmed, and the radius is not measured."""
HIDDEN_NAMES = (NO_EFFECT, *(name for name in CATALOGUE_AMOUNTS if name not in UNSEEN))
STATE_RATE_HZ = 250.0  # [Hz] of the states
REPORT_PERIOD_S = 0.2  # [s] from one report of the health to the next
FIT = 8  # contacts from which the model is fitted
MAX_DEPTH_RADII = 0.16  # of the radius
SENSOR_SETTINGS = SensorSettings(rate=STATE_RATE_HZ, force_bias=0.0, displacement_bias=0.0)


@dataclass(frozen=True)
class Detections:
    """What the health said in one run.

    Attributes:
        hidden: name of the effect, or "nothing".
        finger: number, the seed of the fingertip.
        duration: [s].
        failing: share of the reports that say that the model fails.
        alarms: how often it began to say so.
        first: [s] until it first did; None: never.
        cells: channel and regime -> number of reports that told them.
        left: what a refit of the plain model leaves of these very states, in units of the noise; 1 is noise,
            and cannot show what is hidden there.
        suspect: the effect that was named; None = no diagnosis was made.

    """

    hidden: str
    finger: int
    duration: float
    failing: float
    alarms: int
    first: float | None
    cells: dict[str, int]
    left: float
    suspect: str | None


def contacts(radius: float, count: int, seed: int) -> Protocol:
    """Return grasps of all kinds: fast and slow, short and long, light and firm, some gripped anew."""
    rng = np.random.default_rng(seed)
    away = -0.025 * radius
    segments = [Segment(0.5, depth=away)]
    for _ in range(count):
        depth = rng.uniform(0.06, MAX_DEPTH_RADII) * radius
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


def strong(name: str, tip: FingertipSettings, seed: int) -> Hidden:
    """Return as much of an effect as the trials of the diagnosis call strong; nothing for "nothing"."""
    if name == NO_EFFECT:
        return {}
    rng = np.random.default_rng([seed, 11])
    return {
        name: dict(
            CATALOGUE_AMOUNTS[name](Setting(tip, SENSOR_SETTINGS, MAX_DEPTH_RADII * tip.radius, 1.0, rng))
        )
    }


def run_estimator(tip: FingertipSettings, count: int, seed: int, hidden: Hidden) -> list[FingertipState]:
    """Return what ``tip`` feels in ``count`` contacts."""
    hand = HandSettings(tip=tip, sensor=SENSOR_SETTINGS, spread=0.0)
    benches = Benches(("index",), hand, contacts(tip.radius, count, seed), seed, hidden)
    return benches.step(benches.duration)


def as_recording(tip: FingertipSettings, states: list[FingertipState]) -> Recording:
    """Return every other state as a recording."""
    states = states[::2]
    t = np.array([s.stamp for s in states]) / NS
    columns = {c: np.array([getattr(s, c) for s in states]) for c in ("displacement", "normal_force")}
    sensors = {"normal_force": SENSOR_SETTINGS.normal_force, "displacement": SENSOR_SETTINGS.displacement}
    return Recording("felt", t, np.zeros(t.size, dtype=np.int64), columns, Fingertip(tip.radius), sensors)


def fit_finger(tip: FingertipSettings, seed: int) -> ContactModel:
    """Return the model of ``tip`` from contacts in which nothing is hidden."""
    return fit(as_recording(tip, run_estimator(tip, FIT, seed, {}))).model


def watch_finger(hidden: str, finger: int, count: int, *, ask: bool) -> Detections:
    """Let the estimator feel ``count`` contacts; return what its health said."""
    tip = plain_fingertip(finger)
    model = fit_finger(tip, 1000 + finger)
    estimator, evidence = ContactEstimator(model, SensorNoise()), SampleRing()
    touching: list[bool] = []
    reports: list[tuple[float, str]] = []
    next_look = 0
    states = run_estimator(tip, count, finger, strong(hidden, tip, finger))
    for state in states:
        estimator.assimilate(state)
        touching.append(estimator.in_contact)
        if state.stamp >= next_look:
            next_look = state.stamp + round(REPORT_PERIOD_S * NS)
            health = estimator.health()
            reports.append((state.stamp / NS, f"{health.channel}, {health.regime}" if health.channel else ""))
    values = np.array([[*(getattr(one, name) for name in CHANNELS), 0.0] for one in states])
    values[:, -1] = touching
    stamps, numbers = (np.array([getattr(one, name) for one in states]) for name in ("stamp", "seq"))
    evidence.note(KeptStates("felt", stamps, numbers, values))
    failing = [(time, cell) for time, cell in reports if cell]
    said = np.array([bool(cell) for _, cell in reports])
    return Detections(
        hidden,
        finger,
        duration=states[-1].stamp / NS,
        failing=float(np.mean(said)),
        alarms=int(np.count_nonzero(said[1:] & ~said[:-1])) + int(said[0]),
        first=failing[0][0] if failing else None,
        cells=dict(Counter(cell for _, cell in failing).most_common()),
        left=fit(as_recording(tip, states)).error,
        suspect=diagnose_in_subprocess(evidence.columns(), model, asdict(SensorNoise()))
        if ask and failing
        else None,
    )


def _watched(job: tuple[str, int, int, bool]) -> Detections:
    hidden, finger, count, ask = job
    return watch_finger(hidden, finger, count, ask=ask)


def main(arguments: list[str] | None = None) -> int:
    """Run all and print a line for each, then the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else None)
    parser.add_argument("--first", type=int, default=0, help="number of the first fingertip")
    parser.add_argument("--fingers", type=int, default=4)
    parser.add_argument("--contacts", type=int, default=20)
    parser.add_argument("--hidden", nargs="*", default=list(HIDDEN_NAMES), choices=list(HIDDEN_NAMES))
    parser.add_argument("--suspects", action="store_true")
    parser.add_argument("--processes", type=int, default=1)
    given = parser.parse_args(arguments)
    fingers = range(given.first, given.first + given.fingers)
    jobs = [(h, f, given.contacts, given.suspects) for f in fingers for h in given.hidden]
    seen = []
    with ProcessPoolExecutor(given.processes) as pool:
        for one in pool.map(_watched, jobs):
            seen.append(one)
            print(json.dumps(asdict(one)), file=sys.stderr, flush=True)  # noqa: T201
    for line in table(seen):
        print(line)  # noqa: T201
    return 0


def table(seen: list[Detections]) -> Iterator[str]:
    """Yield the lines of the table: a line for each effect."""
    yield (
        f"{'hidden':24s}{'refit leaves':>13s}{'minutes':>9s}{'alarms/h':>10s}{'seen in':>10s}"
        f"{'after':>7s}{'of reports':>12s}{'named':>9s}  mostly in"
    )
    for name in dict.fromkeys(one.hidden for one in seen):
        runs = [one for one in seen if one.hidden == name]
        alarms = [one for one in runs if one.first is not None]
        hours = sum(one.duration for one in runs) / 3600.0
        rate = sum(one.alarms for one in runs) / hours
        after = f"{np.median([one.first for one in alarms]):.0f} s" if alarms else "-"
        cells = Counter[str]()
        for one in alarms:
            cells.update(one.cells)
        mostly = "; ".join(cell for cell, _ in cells.most_common(2))
        asked = [one for one in alarms if one.suspect is not None]
        named = f"{sum(one.suspect == name for one in asked)} of {len(asked)}" if asked else "-"
        left = float(np.median([one.left for one in runs]))
        share = 100.0 * float(np.mean([one.failing for one in runs]))
        yield (
            f"{name:24s}{left:13.2f}{60.0 * hours:9.1f}{rate:10.1f}{f'{len(alarms)} of {len(runs)}':>10s}"
            f"{after:>7s}{f'{share:.0f} %':>12s}{named:>9s}  {mostly or '-'}"
        )


if __name__ == "__main__":
    sys.exit(main())
