"""What the tests of drives and of hands in parts share."""

import contextlib
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture
def running(tmp_path):
    """Return what starts the virtual drive of a name."""
    from drives import Running

    with contextlib.ExitStack() as stack:

        def run(name):
            found = Running(name, tmp_path)
            stack.callback(found.close)
            return found

        yield run
