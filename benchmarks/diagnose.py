"""How long a diagnosis of 230 s at 200 Hz takes over the whole catalogue, or of an hour, and how much memory.

Run it twice: the first run also compiles one model for each candidate that is refitted. On more than two
cores: ``taskset -c 0,1 vegrip bench diagnose``.
"""

import json
import resource
import time
from dataclasses import replace

import numpy as np

from validation.diagnosis_trials import Case, make_recording
from vegrip.identification.diagnosis import diagnose
from vegrip.identification.recording import Recording
from vegrip.identification.recording.channels import noise_name
from vegrip.identification.recording.data import join_recordings

ROWS = 46_000  # 230 s at 200 Hz, whatever the rate that the case draws
HOUR_ROWS = 1_800_000  # and an hour at 500 Hz
SMALLEST = {"ROWS": 1_000, "HIDDEN": ((),), "HOUR_ROWS": 2_000}
HIDDEN = ((), ("sensor_lag",), ("adhesion", "second_relaxation"))


def run() -> dict[str, dict[str, float]]:
    """Return the time of a diagnosis beside that of the recording it reads."""
    out = {}
    for hidden in HIDDEN:
        recording = make_recording(Case(hidden, "strong", 0), times=4)
        recording = recording.select(np.arange(len(recording)) < ROWS)
        told = "+".join(hidden) or "nothing"
        out[f"diagnose_{told}_vs_recorded_time"] = _timed(recording, 200.0, hidden)
    out["diagnose_hour_vs_recorded_time"] = _timed(_hour(), 500.0, ())
    return out


def _timed(recording: Recording, rate: float, hidden: tuple[str, ...]) -> dict[str, float]:
    began, spent = time.perf_counter(), time.process_time()
    found = diagnose(recording, threads=2)
    wall, cpu = time.perf_counter() - began, time.process_time() - spent
    length = len(recording) / rate
    return {
        "ours_us": 1e6 * wall,
        "theirs_us": 1e6 * length,
        "ratio": length / wall,
        "cpu_s": cpu,
        "right": float(found.named == list(hidden) and (bool(hidden) or found.verdict == "adequate")),
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
