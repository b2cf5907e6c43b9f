"""``vegrip import``: a recording and a report, or one sentence and exit code 3 (2 for a wrong option)."""

import gzip
import json
from pathlib import Path

import numpy as np
import pytest

from vegrip.cli import main
from vegrip.identification.recording import read_recording

Capsys = pytest.CaptureFixture[str]
GOOD = "time_s,force_mN,z\n0,1000,0.5\n0.1,2000,x\n0.2,3000,0.7\n"
MAPPED = ["--map", "t=time_s", "--map", "normal_force=force_mN", "--unit", "normal_force=mN"]


def test_a_table_becomes_a_recording_and_a_report(tmp_path: Path, capsys: Capsys) -> None:
    (tmp_path / "a.csv").write_text(GOOD)
    out = tmp_path / "rec"
    arguments = [*MAPPED, "--map", "displacement=z", "--unit", "displacement=mm", "--radius", "8 mm"]
    assert main(["import", str(tmp_path / "a.csv"), "-o", str(out), *arguments, "--json"]) == 0
    (told,) = json.loads(capsys.readouterr().out)["recordings"]
    assert told["columns"]["normal_force"] == {"unit": "N", "min": 1.0, "max": 3.0, "noise": None}
    assert (told["rows"], told["radius"]) == (2, 0.008)
    assert told["report"]["rows_lost"] == 1
    assert told["report"]["findings"] == [{"kind": "number", "what": "z", "count": 1, "lines": [3]}]
    recording = read_recording(out)
    np.testing.assert_allclose(recording.columns["displacement"], [0.5e-3, 0.7e-3])


def test_the_report_is_shown_to_people_too(tmp_path: Path, capsys: Capsys) -> None:
    (tmp_path / "a.csv").write_text(GOOD)
    assert (
        main(
            ["import", str(tmp_path / "a.csv"), "-o", str(tmp_path / "r"), *MAPPED, "--map", "displacement=z"]
        )
        == 0
    )
    shown = capsys.readouterr().out
    assert "2 of 3 rows kept" in shown
    assert "line 3" in shown
    assert "radius unknown" in shown


def press(path: Path, content: bytes) -> str:
    path.write_bytes(content)
    return str(path)


ZIPPED = gzip.compress(b"time_s,force_mN\n" + b"0,1\n" * 9000, mtime=0)


@pytest.mark.parametrize(
    ("content", "name", "arguments", "code", "sentence"),
    [
        (None, "a.csv", MAPPED, 3, "there is no such file"),
        (GOOD.encode(), "a.csv", [*MAPPED, "--unit", "t=mm"], 3, "'mm' is not a unit of this quantity"),
        (GOOD.encode(), "a.csv", ["--unit", "t=s"], 3, "none of the columns"),
        (b"\x7fELF\0\0\0", "a.csv", MAPPED, 3, "is not a text file"),
        (ZIPPED[:-20], "a.csv.gz", MAPPED, 3, "the compressed file is damaged or cut"),
        (b"no gzip", "a.csv.gz", MAPPED, 3, "the compressed file is damaged or cut"),
        (b"time_s,force_mN\nnan,1\n,2\n", "a.csv", MAPPED, 3, "no usable row"),
        (GOOD.encode(), "a.csv", [*MAPPED, "--radius", "big"], 3, "give a length like '8 mm'"),
        (GOOD.encode(), "a.csv", [*MAPPED, "--radius", "8 N"], 3, "is not a unit of this quantity"),
        (GOOD.encode(), "a.csv", [*MAPPED, "--map-file", "absent.toml"], 3, "there is no such file"),
        (GOOD.encode(), "a.csv", ["--map", "force=force_mN"], 2, "there is no channel 'force'"),
    ],
)
def test_bad_input_gets_one_sentence(
    content: bytes | None,
    name: str,
    arguments: list[str],
    code: int,
    sentence: str,
    tmp_path: Path,
    capsys: Capsys,
) -> None:
    if content is not None:
        press(tmp_path / name, content)
    assert main(["import", str(tmp_path / name), "-o", str(tmp_path / "out"), *arguments]) == code
    shown = capsys.readouterr()
    assert sentence in shown.err
    assert len(shown.err.strip().splitlines()) == 1 or "rows kept" in shown.err
    assert "Traceback" not in shown.err + shown.out
    assert not (tmp_path / "out").exists()


def test_rows_that_run_backwards_are_reported(tmp_path: Path, capsys: Capsys) -> None:
    path = press(tmp_path / "a.csv", b"t,normal_force\n0,1\n1,1\n0.5,1\n2,1\n")
    assert main(["import", path, "-o", str(tmp_path / "out")]) == 0
    assert "time runs backwards (1 x, line 4)" in capsys.readouterr().out


def test_a_folder_that_cannot_be_written_is_said(tmp_path: Path, capsys: Capsys) -> None:
    (tmp_path / "file").write_text("")
    path = press(tmp_path / "a.csv", b"t,normal_force\n0,1\n")
    assert main(["import", path, "-o", str(tmp_path / "file" / "out")]) == 3
    assert "cannot be written" in capsys.readouterr().err
