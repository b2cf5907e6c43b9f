"""Recordings of the test bench with an effect hidden, as in tests/identification/fit."""

import importlib.util
from pathlib import Path

import pytest

_spec = importlib.util.spec_from_file_location("bench", Path(__file__).parents[1] / "fit" / "conftest.py")
_bench = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(_bench)


@pytest.fixture(scope="session")
def bench():
    """Give the recording with a hidden effect (by name, amount, seed), or with none."""
    return _bench.bench_recording
