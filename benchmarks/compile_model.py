"""From a list of effects to the first result: compiled, and from the cache in a new process.

The model of the paper and four effects; composing, checking, writing and one simulated sample included,
importing Python packages not. Theirs is the compilation, ours the same model from the cache in another
process; both in processor time, as other work on the machine counts in wall time.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

TIMES = 3
SMALLEST = {"TIMES": 1}
EFFECTS = ("second_relaxation", "mullins_softening", "series_compliance", "sensor_lag")

MEASURE = """
import json, sys, time
import numpy as np, numba
from vegrip.effects import effect
from vegrip.model import paper_model
numba.njit(lambda x: x)(1.0)  # the compiler itself, loaded
base = paper_model(0.008)
effects = [effect(name) for name in sys.argv[1:]]
wall, start = time.perf_counter(), time.process_time()
model = base
for one in effects:
    model = model.with_effect(one)
model.simulate([0.0, 0.01], [0.0, 1e-4])
print(json.dumps([time.process_time() - start, time.perf_counter() - wall]))
"""


def run() -> dict[str, dict[str, float]]:
    with tempfile.TemporaryDirectory() as cache:
        theirs, wall = min(_seconds(Path(cache, str(i))) for i in range(TIMES))
        ours, ours_wall = min(_seconds(Path(cache, "0")) for _ in range(TIMES))
    figures = {"ours_us": ours * 1e6, "theirs_us": theirs * 1e6, "ratio": theirs / ours}
    return {
        "load_model_vs_compile": {**figures, "ours_wall_us": ours_wall * 1e6, "theirs_wall_us": wall * 1e6}
    }


def _seconds(cache: Path) -> tuple[float, float]:
    environment = {**os.environ, "VEGRIP_CACHE": str(cache)}
    command = [sys.executable, "-c", MEASURE, *EFFECTS]
    done = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)
    cpu, wall = json.loads(done.stdout)
    return cpu, wall


if __name__ == "__main__":
    print(json.dumps(run(), indent=1))
