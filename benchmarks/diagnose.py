"""How long a diagnosis of 230 s at 200 Hz takes over the whole catalogue, and how much memory.

Run it twice: the first run also compiles one model for each candidate that is refitted.
"""

import json
import resource
import time

import numpy as np

from vegrip.diagnosis import diagnose
from vegrip.diagnosis.evaluate import Case, recorded
from vegrip.recording import Recording

LENGTH = 46_000  # rows


def run() -> dict[str, dict[str, float]]:
    """Return the time of a diagnosis beside that of the recording it reads."""
    out = {}
    for hidden in ((), ("sensor_lag",)):
        recording = long_enough(recorded(Case(hidden, "strong", 0)))
        began = time.perf_counter()
        found = diagnose(recording, threads=2)
        ours = time.perf_counter() - began
        out[f"diagnose_{recording.name}_vs_recorded_time"] = {
            "ours_us": 1e6 * ours,
            "theirs_us": 1e6 * len(recording) / 200.0,
            "ratio": len(recording) / 200.0 / ours,
            "right": float(found.named == list(hidden)),
            "peak_memory_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
        }
    return out


def long_enough(recording: Recording) -> Recording:
    """Repeat the episodes until there are LENGTH rows."""
    times = -(-LENGTH // len(recording))
    later = recording.t[-1] + 20.0
    t = np.concatenate([recording.t + i * later for i in range(times)])
    episode = np.concatenate([recording.episode + i * (recording.episode.max() + 1) for i in range(times)])
    columns = {name: np.tile(values, times) for name, values in recording.columns.items()}
    whole = Recording(recording.name, t, episode, columns, recording.fingertip, recording.sensors)
    return whole.select(np.arange(t.size) < LENGTH)


if __name__ == "__main__":
    print(json.dumps(run(), indent=2))
