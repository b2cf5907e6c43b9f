"""A small recording that several tests of the command line share; nobody writes into it."""

from pathlib import Path

import pytest

from vegrip.model import paper_model, write_model
from vegrip.recording import write_recording
from vegrip.samples import RADIUS, recording


@pytest.fixture(scope="session")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the sample recording `press`, its model `press.toml`, and a table `raw.csv`."""
    folder = tmp_path_factory.mktemp("bench")
    write_recording(recording(), folder / "press")
    write_model(paper_model(RADIUS), folder / "press.toml")
    (folder / "raw.csv").write_text("t,normal_force\n0,1\n0.1,2\n0.2,1.5\n")
    return folder
