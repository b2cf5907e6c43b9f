"""The kernels of a finger as Python runs them, and its two arrays, empty."""

from functools import cache
from types import ModuleType

import numpy as np
import pytest

from vegrip.estimator.layout import layout_of
from vegrip.grip.compiled import finger_module
from vegrip.grip.layout import FingerLayout
from vegrip.model import paper_model
from vegrip.types import Floats

MODEL = paper_model(8e-3)
LAYOUT = layout_of(MODEL)
FINGER = FingerLayout(LAYOUT.size, LAYOUT.lasting, late=3, history=5, is_shared=True)


@cache
def text() -> ModuleType:
    """Return the compiled text as Python runs it."""
    return finger_module(MODEL, LAYOUT, FINGER, mode="python")


@pytest.fixture(scope="session")
def kernels() -> ModuleType:
    return text()


@pytest.fixture
def f() -> Floats:
    return np.zeros(FINGER.n_reals)


@pytest.fixture
def t() -> np.ndarray:
    return np.zeros(max(end for _, end in FINGER.sections.values()), np.int64)
