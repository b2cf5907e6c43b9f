"""The kernels as Python runs them, and the memory of a contact that is held under a load."""

from types import ModuleType

import numpy as np
import pytest

from vegrip.estimator import ContactEstimator
from vegrip.estimator.compiled import module_for
from vegrip.model import ContactModel
from vegrip.types import Floats


@pytest.fixture(scope="session")
def kernels(model: ContactModel, compiled: ContactEstimator) -> ModuleType:
    return module_for(model, compiled.layout, plain=True)


@pytest.fixture(scope="session")
def held(model: ContactModel, compiled: ContactEstimator, press: object) -> Floats:
    """Return the memory after a press and a second of holding under half of the load that slips."""
    compiled.reset()
    for state in press(model, [0.0, 0.3, 0.8, 1.8], [-1e-4, -1e-4, 9e-4, 9e-4], share=0.5):
        compiled.assimilate(state)
    memory = np.array(compiled.numbers)
    compiled.reset()
    return memory


@pytest.fixture
def m(held: Floats) -> Floats:
    return held.copy()


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(0)


def covariance(kernels: ModuleType, m: Floats) -> Floats:
    """Return the covariance in the memory, which changes with it."""
    n = kernels.N
    return m[kernels.P0 : kernels.P0 + n * n].reshape(n, n)


@pytest.fixture
def P(kernels: ModuleType, m: Floats) -> Floats:  # noqa: N802
    return covariance(kernels, m)
