"""What a node has met, recorded once."""

import pytest

from validation.compiled_finger import Log, record
from vegrip.c99 import host


@pytest.fixture(scope="session")
def hand_log() -> Log:
    """Return the frames of five fingers that close, lift and hold, 200 Hz."""
    return record(None, 1.6, "hand")


@pytest.fixture(scope="session")
def mode() -> str:
    """Return what runs the compiled step here: C where that is possible, else plain Python."""
    return "c" if host.compiler() is not None else "python"
