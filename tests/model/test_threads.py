"""Models may be composed in many threads at once."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from vegrip.effects import BUILT_IN, effect
from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.model import BASE, Predictor, paper_model


def test_the_text_of_a_model_is_the_same_from_any_number_of_threads():
    names = [name for name in BUILT_IN if name not in BASE]
    base = paper_model(8e-3)

    def text(name):
        return base.with_effect(effect(name)).source([], ["advance"])

    alone = [text(name) for name in names]
    with ThreadPoolExecutor(8) as pool:
        for _ in range(3):
            assert list(pool.map(text, names)) == alone


def test_a_whole_recording_runs_beside_other_threads_and_a_single_step_keeps_the_lock(monkeypatch):
    monkeypatch.setenv("VEGRIP_KERNEL", "numba")
    model = paper_model(8e-3)
    t = np.linspace(0.0, 1.0, 50)
    whole = Predictor(model, {"t": t, "displacement": 1e-3 * t})._module
    for entry in (whole.channels, whole.depths):
        assert entry.targetoptions["nogil"]
    step = ContactEstimator(model, SensorNoise())._module.update
    assert not step.targetoptions.get("nogil", False)
