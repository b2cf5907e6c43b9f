"""How long a diagnosis of 230 s at 200 Hz takes over the whole catalogue, and how much memory.

Run it twice: the first run also compiles one model for each candidate that is refitted. On more than two
cores: ``taskset -c 0,1 vegrip bench diagnose``.
"""

import json
import resource
import time

import numpy as np

from validation.diagnosis_trials import Case, make_recording
from vegrip.identification.diagnosis import diagnose

ROWS = 46_000  # 230 s at 200 Hz, whatever the rate that the case draws
SMALLEST = {"ROWS": 1_000, "HIDDEN": ((),)}
HIDDEN = ((), ("sensor_lag",), ("adhesion", "second_relaxation"))


def run() -> dict[str, dict[str, float]]:
    """Return the time of a diagnosis beside that of the recording it reads."""
    out = {}
    for hidden in HIDDEN:
        recording = make_recording(Case(hidden, "strong", 0), times=4)
        recording = recording.select(np.arange(len(recording)) < ROWS)
        began, spent = time.perf_counter(), time.process_time()
        found = diagnose(recording, threads=2)
        wall, cpu = time.perf_counter() - began, time.process_time() - spent
        length = len(recording) / 200.0
        out[f"diagnose_{'+'.join(hidden) or 'nothing'}_vs_recorded_time"] = {
            "ours_us": 1e6 * wall,
            "theirs_us": 1e6 * length,
            "ratio": length / wall,
            "cpu_s": cpu,
            "right": float(found.named == list(hidden)),
            "peak_memory_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
        }
    return out


if __name__ == "__main__":
    print(json.dumps(run(), indent=2))
