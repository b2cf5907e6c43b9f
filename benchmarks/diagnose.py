"""How long a diagnosis takes over the whole catalogue, of minutes or an hour, and how much memory.

Run it twice: the first run also compiles one model for each candidate that is refitted. On more than two
cores: ``taskset -c 0,1 vegrip bench diagnose``.
"""

import json
import resource
import time
from dataclasses import replace

import numpy as np

from validation.diagnosis_trials import Case, make_recording
from vegrip.effects import names
from vegrip.identification.diagnosis import diagnose
from vegrip.identification.recording import Recording
from vegrip.identification.recording.channels import noise_name
from vegrip.identification.recording.data import join_recordings

MINUTES = (46_000, 200.0)  # rows of 230 s at so many a second, whatever the rate that the case draws
FIVE_MINUTES = (150_000, 500.0)
CASES = {
    (): MINUTES,
    ("sensor_lag",): MINUTES,
    ("adhesion", "second_relaxation"): MINUTES,
    ("mullins_softening",): FIVE_MINUTES,
    ("crack",): FIVE_MINUTES,
}
HOUR_ROWS = 1_800_000  # at 500 Hz
SMALLEST = {"CASES": {(): (1_000, 200.0)}, "HOUR_ROWS": 2_000}


def run() -> dict[str, dict[str, float]]:
    """Return the time of a diagnosis beside that of the recording it reads."""
    out = {}
    for hidden, (rows, rate) in CASES.items():
        recording = make_recording(Case(hidden, "strong", 0), times=4 * max(rows // MINUTES[0], 1))
        recording = recording.select(np.arange(len(recording)) < rows)
        told = "+".join(hidden) or "nothing"
        out[f"diagnose_{told}_vs_recorded_time"] = _timed(recording, rate, hidden)
    out["diagnose_hour_vs_recorded_time"] = _timed(_hour(), 500.0, ())
    return out


def _timed(recording: Recording, rate: float, hidden: tuple[str, ...]) -> dict[str, float]:
    began, spent = time.perf_counter(), time.process_time()
    found = diagnose(recording, threads=2)
    wall, cpu = time.perf_counter() - began, time.process_time() - spent
    length = len(recording) / rate
    in_catalogue = "named" if set(hidden) <= set(names()) else "unexplained"
    verdict = in_catalogue if hidden else "adequate"
    return {
        "ours_us": 1e6 * wall,
        "theirs_us": 1e6 * length,
        "ratio": length / wall,
        "cpu_s": cpu,
        "right": float(found.verdict == verdict and found.named == [*hidden] * (verdict == "named")),
        "peak_memory_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
    }


def _hour() -> Recording:
    """Return two hundred grasps again and again until an hour is full, each time with other noise."""
    once = make_recording(Case((), "strong", 0, style="use"), times=17, quiet=True)
    rng = np.random.default_rng(0)

    def again() -> Recording:
        noise = {name: once.sensors.get(noise_name(name), 0.0) for name in once.columns}
        added = {name: std * rng.standard_normal(len(once)) for name, std in noise.items()}
        return replace(once, columns={name: once.columns[name] + added[name] for name in added})

    hour = join_recordings([again() for _ in range(-(-HOUR_ROWS // len(once)))], "hour")
    return hour.select(np.arange(len(hour)) < HOUR_ROWS)


if __name__ == "__main__":
    print(json.dumps(run(), indent=2))
