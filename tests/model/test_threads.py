"""Models may be composed in many threads at once."""

from concurrent.futures import ThreadPoolExecutor
from threading import Thread

import numpy as np

from vegrip.effects import BUILT_IN, effect
from vegrip.estimator.compiled import node_text_of
from vegrip.estimator.layout import layout_of
from vegrip.model import BASE, Predictor, cache, paper_model
from vegrip.model.model import text_of


def test_the_text_of_a_model_is_the_same_from_any_number_of_threads():
    names = [name for name in BUILT_IN if name not in BASE]
    base = paper_model(8e-3)

    def text(name):
        return base.with_effect(effect(name)).source([], ["advance"])

    alone = [text(name) for name in names]
    with ThreadPoolExecutor(8) as pool:
        for _ in range(3):
            assert list(pool.map(text, names)) == alone


def test_a_whole_recording_runs_beside_other_threads():
    """While C is in it, Python goes on elsewhere: a counter moves although the call is one."""
    model = paper_model(8e-3)
    t = np.linspace(0.0, 1.0, 1_000_000)
    predict = Predictor(model, {"t": t, "displacement": 1e-3 * t})
    batch, seen = predict._batch, []
    entry = batch._entries["channels"]

    def counted(*arguments):
        before = ticks[0]
        entry(*arguments)
        seen.append(ticks[0] - before)

    ticks, batch._entries["channels"], going = [0], counted, [True]

    def count():
        while going:
            ticks[0] += 1

    other = Thread(target=count)
    other.start()
    try:
        predict(model.vector)
    finally:
        going.clear()
        other.join()
        batch._entries["channels"] = entry
    assert seen[0] > 0


def test_with_numba_a_whole_recording_frees_the_lock_and_a_single_step_keeps_it():
    model = paper_model(8e-3)
    whole = cache.load(text_of(model.effects))
    assert whole.channels.targetoptions["nogil"]
    assert whole.depths.targetoptions["nogil"]
    step = cache.load(node_text_of(model, layout_of(model))).update
    assert not step.targetoptions.get("nogil", False)
