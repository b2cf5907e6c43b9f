import tempfile

import pytest


@pytest.fixture
def runtime(monkeypatch):
    """A runtime folder of this test alone, with a path short enough for sockets."""
    with tempfile.TemporaryDirectory(prefix="vg-") as folder:
        monkeypatch.setenv("VEGRIP_RUNTIME_DIR", f"{folder}/r")
        yield folder
