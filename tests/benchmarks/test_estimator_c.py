"""The estimator in C, which the compiled step is timed against, is the same estimator."""

import ctypes
import math
import shutil
from pathlib import Path

import numpy as np
import pytest
from vegrip.benchmarks import _c
from vegrip.benchmarks.estimator import DT

from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.estimator.compiled import module_for
from vegrip.estimator.layout import MODE
from vegrip.model import paper_model

NAN = math.nan


def eventful() -> list[tuple[float, float, float, float]]:
    """Time step, force, displacement, radius: a press, losses, a jump, a sensor wrong for good."""
    rng = np.random.default_rng(4)
    t = np.arange(2500) * DT
    depth = np.interp(t, [0.2, 0.6, 2.0, 2.4], [-1e-4, 8e-4, 8e-4, 5e-4])
    force = paper_model(8e-3).simulate(t, depth).normal_force + rng.normal(0.0, 0.01, t.size)
    rows = [(DT, f, d, NAN) for f, d in zip(force, depth + rng.normal(0.0, 5e-6, t.size), strict=True)]
    rows[350] = (DT, NAN, rows[350][2], NAN)
    rows[400:420] = [(DT, f, NAN, NAN) for _, f, _, _ in rows[400:420]]
    rows[500] = (DT, NAN, NAN, NAN)
    rows[600] = (0.7, *rows[600][1:3], 2.5e-3)
    rows[700] = (DT, math.inf, rows[700][2], -1.0)
    rows[1000:1300] = [(DT, NAN if i % 3 else f, NAN, NAN) for i, (_, f, _, _) in enumerate(rows[1000:1300])]
    rows[1600:] = [(DT, f + 0.8, d, NAN) for _, f, d, _ in rows[1600:]]
    return rows


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_the_step_in_c_leaves_every_number_of_the_memory_as_the_compiled_one(tmp_path: Path) -> None:
    estimator = ContactEstimator(paper_model(8e-3), SensorNoise())
    plain = module_for(estimator.model, estimator.layout, plain=True)
    step = _c.compiled(plain, "filter_step", (_c.POINTER, *[_c.FLOAT] * 4), tmp_path).filter_step_many
    step.argtypes = [ctypes.c_long, ctypes.c_void_p, *[ctypes.c_double] * 4]
    ours, theirs = estimator._m.copy(), estimator._m.copy()
    for i, row in enumerate(eventful()):
        estimator._module.filter_step(ours, *row)
        step(1, theirs.ctypes.data, *row)
        assert np.array_equal(ours, theirs, equal_nan=True), f"sample {i}"
    assert ours[estimator.layout.places()["MODE"][0] + MODE.index("RESTARTS")] > 0.0
