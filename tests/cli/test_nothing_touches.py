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


@pytest.mark.parametrize(
    "what", [pytest.param(one, marks=pytest.mark.long) if "force" in one else one for one in ODD]
)
def test_a_diagnosis_says_in_a_sentence_that_the_model_never_touches(what, tmp_path, capsys):
    code = main(["diagnose", recorded(tmp_path / "odd", *ODD[what])])
    told = capsys.readouterr()
    assert code in (0, 3)
    assert code == 0 or told.err.strip().splitlines()[-1].startswith("vegrip: ")
    if what.startswith("the sign of the depth"):
        assert code == 3
        assert "the model never touches in this recording" in told.err
        assert "--negate displacement" in told.err


EVERY = {
    "fit": ["fit", "ODD", "-o", "model.toml"],
    "diagnose": ["diagnose", "ODD"],
    "compare": ["compare", "ODD"],
    "report": ["report", "ODD", "-o", "report.html"],
    "refine": ["refine", "ODD", "-o", "model.toml"],
    "draft": ["draft", "ODD", "-o", "law.py"],
    "experiment": ["experiment", "ODD"],
    "add": ["add", "adhesion", "ODD", "-o", "model.toml"],
    "fleet": ["fleet", "ODD", "--processes", "1"],
    "replay": ["replay", "ODD", "--through"],
}
ROWS = {"one row is left": slice(1), "two rows are left": slice(2)}


@pytest.mark.parametrize("what", ["nothing touches", "nothing moves", *ROWS])
@pytest.mark.parametrize("command", EVERY)
def test_every_command_says_so_in_a_sentence_and_leaves_no_file_behind(
    command, what, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    recorded(tmp_path / "ODD", *ODD.get(what, (DEPTH, FORCE)), ROWS.get(what, slice(None)))
    code = main(EVERY[command])
    told = capsys.readouterr()
    if command == "fleet":  # of many recordings it names each
        assert code == 0
        assert "1 of 1: ODD: failed" in told.err
    elif command == "replay":  # no model is compared, and the node says what it lacks
        assert code == 0
    else:
        assert code == 3
        assert told.err.strip().splitlines()[-1].startswith("vegrip: odd ")
        assert [path.name for path in tmp_path.iterdir()] == ["ODD"]
