"""Four ways to make one model of a list of effects, on the base and four effects.

* ``flat``: all sources in one generated module on disk, which numba compiles and caches (this project's way)
* ``memory``: the same text compiled in memory, as closures and exec come to: none for the next process
* ``superset``: every effect that goes together in one module, the absent ones at their null values
* ``plain``: the same source uncompiled

Each in a process of its own, twice, the second time with what the first left on disk. Prints one line a way:
processor time from the list to the first sample in the first and in a later process, and per sample of a run.
``run`` gives ``vegrip bench`` the ratio of the others' time for a first sample in a later process to ours.
"""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

EFFECTS = ("second_relaxation", "mullins_softening", "series_compliance", "sensor_lag")
WAYS = ("flat", "memory", "superset", "plain")
SMALLEST = {"EFFECTS": ("sensor_lag",), "WAYS": ("flat", "memory")}

MEASURE = """
import json, sys, time
import numpy as np, numba
from vegrip.effects import BUILT_IN, effect
from vegrip.errors import ModelError
from vegrip.model import cache, paper_model

numba.njit(lambda x: x)(1.0)  # the compiler itself, loaded
way, names = sys.argv[1], sys.argv[2:]
if way == "memory":
    made = {}
    def in_memory(text):
        if text not in made:
            made[text] = type(sys)("in_memory")
            exec(text.replace("cache=True, ", ""), made[text].__dict__)
        return made[text]
    cache.load = in_memory
model, start = paper_model(0.008), time.process_time()
for name in names:
    model = model.with_effect(effect(name))
added = 0
if way == "superset":
    for other in map(effect, BUILT_IN):
        if other.name in {e.name for e in model.effects}:
            continue
        try:
            wider = model.with_effect(other)
            for p in other.parameters:
                if p.null is not None:
                    wider = wider.with_value(p.symbol, p.null)
            wider.plan
        except ModelError:
            continue
        model, added = wider, added + 1
t = np.arange(200_001) * 1e-3
depth = 1e-3 * (1.0 - np.cos(t))
plain = way == "plain"
model.simulate(t[:2], depth[:2], plain=plain)
first = time.process_time() - start
n = 2_000 if plain else t.size
start = time.process_time()
model.simulate(t[:n], depth[:n], plain=plain)
print(json.dumps({"first_s": first, "sample_ns": (time.process_time() - start) / n * 1e9, "beside": added}))
"""


def measured() -> dict[str, dict[str, float]]:
    """Return the figures of every way."""
    found = {}
    for way in WAYS:
        with tempfile.TemporaryDirectory() as cache:
            cold, warm = _process(way, Path(cache)), _process(way, Path(cache))
        found[way] = {
            "cold_s": cold["first_s"],
            "warm_s": warm["first_s"],
            "sample_ns": warm["sample_ns"],
            "effects_beside": warm["beside"],
        }
    return found


def run() -> dict[str, dict[str, float]]:
    """Return the first sample in a later process: the text in memory, and the superset, over ours."""
    found = measured()
    ours = found["flat"]["warm_s"] * 1e6
    return {
        f"model_flat_vs_{way}": {
            "ours_us": ours,
            "theirs_us": found[way]["warm_s"] * 1e6,
            "ratio": found[way]["warm_s"] * 1e6 / ours,
        }
        for way in WAYS
        if way in {"memory", "superset"}
    }


def _process(way: str, cache: Path) -> Mapping[str, float]:
    environment = {**os.environ, "VEGRIP_CACHE": str(cache)}
    command = [sys.executable, "-c", MEASURE, way, *EFFECTS]
    done = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)
    figures: dict[str, float] = json.loads(done.stdout)
    return figures


if __name__ == "__main__":
    for way, figures in measured().items():
        print(way, json.dumps({name: round(value, 3) for name, value in figures.items()}))
