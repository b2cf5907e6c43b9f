"""How long a diagnosis takes over the whole catalogue, of minutes or an hour, and how much memory.

Each recording is diagnosed in a process of its own, whose peak memory is told; ``right`` is 1 where the
verdict is the one that is due. Run it twice: the first run also compiles one model for each candidate that
is refitted. On more than two cores: ``taskset -c 0,1 vegrip bench diagnose``; on a machine that does other
things, the seconds of processor time (``cpu_s``) are what compares.
"""

import json
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import numpy as np

from validation.diagnosis_trials import Case, make_recording
from vegrip.effects import effect, names
from vegrip.identification.diagnosis import diagnose
from vegrip.identification.recording import Fingertip, Recording
from vegrip.identification.recording.channels import noise_name
from vegrip.identification.recording.data import join_recordings
from vegrip.model import paper_model

MINUTES = (46_000, 200.0)  # rows of 230 s at so many a second, whatever the rate that the case draws
FIVE_MINUTES = (150_000, 500.0)
CASES = {
    (): MINUTES,
    ("sensor_lag",): MINUTES,
    ("adhesion", "second_relaxation"): MINUTES,
    ("mullins_softening",): FIVE_MINUTES,
    ("crack",): FIVE_MINUTES,
}
BRIEF = {("cogging", "short"): 3, ("speed_band", "use"): 3}  # in no catalogue, and its style -> seed
PROTOCOLS = 4  # one after another, which last longer than the minutes
HOUR_ROWS = 1_800_000  # at 500 Hz
HOUR_PROTOCOLS = 17  # two hundred grasps, before the first is repeated
TISSUE_ROWS = 118_000  # at 100 Hz
TISSUE_HOLDS = 4
TISSUE_FORCE_NOISE_N = 1e-5
SMALLEST = {
    "CASES": {}, "PROTOCOLS": 1, "BRIEF": {}, "HOUR_ROWS": 1_000, "HOUR_PROTOCOLS": 1,
    "TISSUE_ROWS": 1_000,
}  # fmt: skip


class Told(NamedTuple):
    """What a diagnosis took, and its answer."""

    wall: float  # [s]
    cpu: float  # [s]
    memory: float  # [MB] at the peak
    verdict: str
    named: list[str]


def run() -> dict[str, dict[str, float]]:
    """Return the time of a diagnosis beside that of the recording it reads."""
    out = {}
    for hidden, (rows, rate) in CASES.items():
        recording = make_recording(Case(hidden, "strong", 0), times=PROTOCOLS * max(rows // MINUTES[0], 1))
        recording = recording.select(np.arange(len(recording)) < rows)
        told = "+".join(hidden) or "nothing"
        out[f"diagnose_{told}_vs_recorded_time"] = _timed(recording, rate, hidden)
    for (name, style), seed in BRIEF.items():
        recording = make_recording(Case((name,), "strong", seed, style=style))
        rate = 1.0 / float(np.median(np.diff(recording.t)))
        out[f"diagnose_{name}_{style}_vs_recorded_time"] = _timed(recording, rate, (name,))
    out["diagnose_tissue_vs_recorded_time"] = _timed(_tissue(), 100.0, None)
    out["diagnose_hour_vs_recorded_time"] = _timed(_hour(), 500.0, ())
    return out


def _timed(recording: Recording, rate: float, hidden: tuple[str, ...] | None) -> dict[str, float]:
    """Diagnose a recording; of one with nothing ``hidden`` that is due, any answer is right."""
    with ProcessPoolExecutor(1, get_context("spawn")) as alone:
        told = alone.submit(_diagnosed, recording).result()
    length = len(recording) / rate
    in_catalogue = "named" if set(hidden or ()) <= set(names()) else "unexplained"
    verdict = in_catalogue if hidden else "adequate"
    is_right = told.verdict == verdict and told.named == [*(hidden or ())] * (verdict == "named")
    return {
        "ours_us": 1e6 * told.wall,
        "theirs_us": 1e6 * length,
        "ratio": length / told.wall,
        "cpu_s": told.cpu,
        "right": float(hidden is None or is_right),
        "peak_memory_mb": told.memory,
    }


def _diagnosed(recording: Recording) -> Told:
    began, spent = time.perf_counter(), time.process_time()
    found = diagnose(recording, threads=2)
    verdict = found.verdict
    wall, cpu = time.perf_counter() - began, time.process_time() - spent
    return Told(wall, cpu, _peak_memory(), verdict, found.named)


def _peak_memory() -> float:
    """Return the peak of this process [MB]; ``ru_maxrss`` is that of the one which started it, if more."""
    told = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
    return next(float(line.split()[1]) for line in told if line.startswith("VmHWM")) / 1024.0


def _hour() -> Recording:
    """Return two hundred grasps again and again until an hour is full, each time with other noise."""
    once = make_recording(Case((), "strong", 0, style="use"), times=HOUR_PROTOCOLS, quiet=True)
    rng = np.random.default_rng(0)

    def again() -> Recording:
        noise = {name: once.sensors.get(noise_name(name), 0.0) for name in once.columns}
        added = {name: std * rng.standard_normal(len(once)) for name, std in noise.items()}
        return replace(once, columns={name: once.columns[name] + added[name] for name in added})

    hour = join_recordings([again() for _ in range(-(-HOUR_ROWS // len(once)))], "hour")
    return hour.select(np.arange(len(hour)) < HOUR_ROWS)


def _tissue() -> Recording:
    """Return holds of five minutes that begin on the surface and never part: no air, and no noise stated.

    As tissue on bone, it stiffens with depth, relaxes at more times than one, drains, and its force is late.
    """
    rows = TISSUE_ROWS // TISSUE_HOLDS
    t = 0.01 * np.arange(rows)
    model = paper_model(1e-3)
    for name in ("exponential_stiffness", "power_law_relaxation", "poroelastic_drainage", "sensor_lag"):
        model = model.with_effect(effect(name))
    model = model.with_value("tau", 0.016)
    rng = np.random.default_rng(0)
    depths = [1e-4 * np.minimum(t / 0.8, 1.0) * (1.0 + 0.1 * i) + 2e-5 for i in range(TISSUE_HOLDS)]
    forces = [model.simulate(t, depth).sensed_force for depth in depths]
    noise = TISSUE_FORCE_NOISE_N * rng.standard_normal(rows * TISSUE_HOLDS)
    columns = {"displacement": np.concatenate(depths), "normal_force": np.concatenate(forces) + noise}
    clock = np.concatenate([t + (t[-1] + 300.0) * i for i in range(TISSUE_HOLDS)])
    return Recording("tissue", clock, np.repeat(np.arange(TISSUE_HOLDS), rows), columns, Fingertip(1e-3), {})


if __name__ == "__main__":
    print(json.dumps(run(), indent=2))
