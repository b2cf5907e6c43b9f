"""How often a diagnosis is right, on recordings of the virtual bench, whose hidden effects it knows.

``python -m vegrip.diagnosis.evaluate --seeds 2`` makes recordings of random fingertips with each hidden
effect that the bench has, strong and weak, and with none, diagnoses each and prints what was named. The bench
shares no physics code with the model, and several of its laws have another form than the catalogue's.
"""

import argparse
import json
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from functools import partial

import numpy as np

from vegrip.diagnosis.diagnosis import diagnose
from vegrip.recording import Fingertip, Recording
from vegrip.virtual.hidden import HIDDEN
from vegrip.virtual.protocol import Episode, Segment, standard_protocol
from vegrip.virtual.settings import FingertipSettings, SensorSettings, random_fingertip
from vegrip.virtual.trial import run_trial

SIZES = {"strong": 1.0, "weak": 0.3}
SENSORS = SensorSettings(rate=200.0, radius_sensor=True, force_bias=2e-3)
CLEAR = Segment(0.3, depth=-1.5e-4)
AMOUNTS = {
    "adhesion": ("force",), "second_relaxation": ("amplitude",), "power_law_relaxation": ("amplitude",),
    "series_compliance": ("compliance",), "displacement_backlash": ("width",), "permanent_set": ("share",),
    "mullins_softening": ("loss",), "sensor_lag": ("time",), "cross_talk": ("share",),
    "force_drift": ("rate",), "load_dependent_friction": ("exponent",), "friction_ageing": ("growth",),
    "wet_contact": ("loss",), "rate_dependent_friction": ("growth",),
}  # fmt: skip
"""What makes a hidden effect weak: the parameters that are scaled."""
INVERSE = {"exponential_stiffness": ("length",), "layer_over_core": ("thickness",)}
"""And those that are divided."""


@dataclass(frozen=True)
class Case:
    """One recording: hidden effects and their size, and the seed of fingertip and noise."""

    hidden: tuple[str, ...]
    size: str
    seed: int


@dataclass(frozen=True)
class Outcome:
    """What came of it."""

    case: Case
    verdict: str
    named: tuple[str, ...]
    indistinguishable: tuple[tuple[str, ...], ...]
    before: float
    after: float
    seconds: float

    @property
    def right(self) -> bool:
        """Whether exactly what is hidden was named, or a set that holds it."""
        hidden = set(self.case.hidden)
        if not hidden:
            return self.verdict == "adequate"
        if self.verdict == "named":
            return set(self.named) == hidden
        return self.verdict == "ambiguous" and all(
            any(one in group for group in self.indistinguishable) or one in self.named for one in hidden
        )


def settings(case: Case) -> dict[str, dict[str, float]]:
    """Return the hidden effects' parameters."""
    factor = SIZES[case.size]
    out: dict[str, dict[str, float]] = {}
    for name in case.hidden:
        known = {f: getattr(HIDDEN[name], f) for f in (*AMOUNTS.get(name, ()), *INVERSE.get(name, ()))}
        out[name] = {f: v * factor for f, v in known.items() if f in AMOUNTS.get(name, ())}
        out[name] |= {f: v / factor for f, v in known.items() if f in INVERSE.get(name, ())}
    return out


def recorded(case: Case) -> Recording:
    """Make the recording of a case."""
    rng = np.random.default_rng(1000 + case.seed)
    tip = random_fingertip(rng)
    tip = replace(
        tip, amplitudes=tip.amplitudes[:1], rates=(float(rng.uniform(0.8, 5.0)),), bristle_stiffness=1e10
    )
    trial = run_trial(tip, protocol(tip), SENSORS, case.seed, hidden=settings(case), rings=8, spokes=16)
    sensors = {
        name: float(getattr(SENSORS, name))
        for name in ("normal_force", "displacement", "tangential_force", "torque_z", "contact_radius")
    }
    columns = {name: values for name, values in trial.columns.items() if name not in ("t", "episode")}
    name = "+".join(case.hidden) or "nothing"
    episode = trial.columns["episode"].astype(np.int64)
    return Recording(name, trial.columns["t"], episode, columns, Fingertip(tip.radius), sensors)


def protocol(tip: FingertipSettings) -> tuple[Episode, ...]:
    """Return the standard protocol, each episode with clear air before and after."""
    return tuple((CLEAR, *episode, CLEAR) for episode in standard_protocol(tip, size=0.8))


def outcome(case: Case, threads: int = 1) -> Outcome:
    """Make the recording of a case and diagnose it."""
    recording = recorded(case)
    began = time.perf_counter()
    found = diagnose(recording, threads=threads)
    sets = tuple(tuple(group) for group in found.indistinguishable)
    spent = time.perf_counter() - began
    error = found.error
    return Outcome(case, found.verdict, tuple(found.named), sets, error["before"], error["after"], spent)


def cases(seeds: int, sizes: list[str], names: list[str]) -> Iterator[Case]:
    """Yield the cases: nothing, then every effect in every size."""
    for seed in range(seeds):
        yield Case((), "strong", seed)
        for size in sizes:
            for name in names:
                yield Case(tuple(name.split("+")), size, seed)


def main(arguments: list[str] | None = None) -> int:
    """Run the cases and print what was named, then the counts."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else None)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--sizes", nargs="*", default=list(SIZES), choices=list(SIZES))
    parser.add_argument("--effects", nargs="*", default=list(HIDDEN), help="a+b for both together")
    parser.add_argument("--processes", type=int, default=1)
    given = parser.parse_args(arguments)
    outcomes = []
    with ProcessPoolExecutor(given.processes) as pool:
        work = partial(outcome, threads=1)
        for one in pool.map(work, cases(given.seeds, given.sizes, given.effects)):
            outcomes.append(one)
            print(json.dumps({**asdict(one), "right": one.right}), file=sys.stderr, flush=True)  # noqa: T201
    none = [one for one in outcomes if not one.case.hidden]
    told = {
        "nothing_hidden": len(none),
        "false_alarms": sum(not one.right for one in none),
        "hidden": len(outcomes) - len(none),
        "right": sum(one.right for one in outcomes if one.case.hidden),
        "wrong_name": sum(one.verdict == "named" and not one.right for one in outcomes if one.case.hidden),
        "by_size": {
            size: [sum(o.right for o in outcomes if o.case.size == size and o.case.hidden),
                   sum(1 for o in outcomes if o.case.size == size and o.case.hidden)]
            for size in given.sizes
        },
    }  # fmt: skip
    print(json.dumps(told))  # noqa: T201
    return 0


if __name__ == "__main__":
    sys.exit(main())
