"""The hot path of the estimator takes no memory that stays, and compiled code takes none of its own."""

import tracemalloc

import numpy as np
import pytest
from numba.core.runtime import _nrt_python, rtsys

from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.messages import FingertipState
from vegrip.model import paper_model

pytestmark = pytest.mark.numba


@pytest.fixture(autouse=True)
def numba_kernels(monkeypatch: pytest.MonkeyPatch) -> None:
    """Look into the kernels as numba compiles them; in C they have no names to ask for."""
    monkeypatch.setenv("VEGRIP_KERNEL", "numba")


def samples(count):
    t = 2e-3 * np.arange(count)
    depth = 1e-3 * np.clip(5.0 * (t - 0.04), 0.0, 1.0) - 1e-5
    force = paper_model(8e-3).simulate(t, depth).normal_force
    for i in range(count):
        yield FingertipState(i * 2_000_000, "tip", i, force[i], 0.1, 0.0, 1e-4, depth[i], slip=0.0)


@pytest.fixture
def counting():
    """Let numba's runtime count what compiled code allocates."""
    before = _nrt_python.memsys_stats_enabled()
    _nrt_python.memsys_enable_stats()
    yield
    if not before:
        _nrt_python.memsys_disable_stats()


@pytest.mark.usefixtures("counting")
def test_compiled_code_allocates_nothing_but_the_headers_of_its_arguments():
    estimator = ContactEstimator(paper_model(8e-3), SensorNoise())
    given = list(samples(300))
    before = rtsys.get_allocation_stats()
    for state in given:
        estimator.assimilate(state)
        estimator.slip_margin()
        estimator.least_force(0.1)
    after = rtsys.get_allocation_stats()
    arrays = 2 + 2 + 1  # handed over by the three calls; numba wraps each in a header while the call lasts
    assert after.alloc - before.alloc == arrays * len(given)
    assert after.free - before.free == arrays * len(given)


def test_what_is_kept_does_not_grow_with_the_samples():
    estimator = ContactEstimator(paper_model(8e-3), SensorNoise())
    given = list(samples(4000))

    def take(part):
        for state in part:
            estimator.assimilate(state)
            estimator.least_force(0.1)
            estimator.contact_estimate()

    take(given[:2000])
    tracemalloc.start()
    take(given[2000:2010])
    first, _ = tracemalloc.get_traced_memory()
    take(given[2010:])
    last, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert last - first < 2000, "bytes after 2000 more samples"
