"""The kernels of a finger as Python runs them, and its two arrays, empty."""

from types import ModuleType

import numpy as np
import pytest

from tests.grip.stages import FINGER, KERNELS
from vegrip.types import Floats


@pytest.fixture(scope="session")
def kernels() -> ModuleType:
    return KERNELS


@pytest.fixture
def f() -> Floats:
    return np.zeros(FINGER.n_reals)


@pytest.fixture
def t() -> np.ndarray:
    return np.zeros(max(end for _, end in FINGER.sections.values()), np.int64)
