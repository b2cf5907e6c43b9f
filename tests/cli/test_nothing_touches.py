"""Every command answers in a sentence where nothing touches, nothing moves, or one row is left."""

from pathlib import Path

import numpy as np
import pytest

from vegrip.cli import main
from vegrip.identification.recording import Fingertip, Recording, write_recording

T = 0.01 * np.arange(400)
DEPTH = 1e-3 * np.interp(T, [0.0, 1.0, 2.0, 3.0, 4.0], [0.0, 0.0, 1.0, 0.0, 0.0])
FORCE = 4e4 * DEPTH**1.5 + np.random.default_rng(1).normal(0.0, 2e-3, T.size)
ODD = {
    "the sign of the depth is wrong": (-DEPTH, FORCE),
    "the sign of the force is wrong": (DEPTH, -FORCE),
    "nothing touches": (-DEPTH - 1e-3, FORCE - 4e4 * DEPTH**1.5),
    "nothing moves": (0.0 * DEPTH, 0.0 * FORCE),
    "it is pressed and held": (0.0 * DEPTH + 1e-3, 0.0 * FORCE + 1.2),
}


def recorded(folder: Path, depth, force, rows=slice(None)) -> str:
    columns = {"displacement": depth[rows], "normal_force": force[rows]}
    episode = np.zeros(len(T[rows]), dtype=np.int64)
    made = Recording("odd", T[rows], episode, columns, Fingertip(8e-3), {"normal_force": 2e-3})
    write_recording(made, folder)
    return str(folder)


@pytest.mark.parametrize("what", ODD)
def test_a_diagnosis_says_in_a_sentence_that_the_model_never_touches(what, tmp_path, capsys):
    code = main(["diagnose", recorded(tmp_path / "odd", *ODD[what])])
    told = capsys.readouterr()
    assert code in (0, 3)
    assert code == 0 or told.err.strip().splitlines()[-1].startswith("vegrip: ")
    if what.startswith("the sign of the depth"):
        assert code == 3
        assert "the model never touches in this recording" in told.err
        assert "--negate displacement" in told.err


@pytest.mark.parametrize("rows", [1, 2])
@pytest.mark.parametrize("command", ["fit", "diagnose", "compare"])
def test_a_recording_of_hardly_a_row_is_refused_in_a_sentence(command, rows, tmp_path, capsys):
    assert main([command, recorded(tmp_path / "odd", DEPTH, FORCE, slice(rows))]) == 3
    assert capsys.readouterr().err.strip().splitlines()[-1].startswith("vegrip: ")
