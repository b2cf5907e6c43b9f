"""A small recording that several tests of the command line share; nobody writes into it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from vegrip.identification.recording import Recording, write_recording
from vegrip.identification.samples import SAMPLE_RADIUS_M, recording
from vegrip.model import paper_model, write_model


def first_presses() -> Recording:
    """Return what is enough to try a command on: the shallow press and the light pull."""
    whole = recording()
    rows = np.isin(whole.episode, (3, 4))
    columns = {name: values[rows] for name, values in whole.columns.items()}
    return replace(whole, t=whole.t[rows], episode=whole.episode[rows], columns=columns)


@pytest.fixture(scope="session")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with two presses of the sample as `press`, its model `press.toml`, and a table `raw.csv`."""
    folder = tmp_path_factory.mktemp("bench")
    write_recording(first_presses(), folder / "press")
    write_model(paper_model(SAMPLE_RADIUS_M), folder / "press.toml")
    (folder / "raw.csv").write_text("t,normal_force\n0,1\n0.1,2\n0.2,1.5\n")
    return folder
