"""What is left out is counted by reason with its time, named first, and refused from a tenth on."""

import json
from pathlib import Path

import numpy as np
import pytest

from vegrip.cli import main
from vegrip.errors import RecordingError
from vegrip.identification.recording import read_recording
from vegrip.identification.recording.import_file import import_recording
from vegrip.identification.recording.report import SHOWN, Kind, LoadReport, account

ROWS = 400
T = 0.01 * np.arange(ROWS)
FORCE = np.interp(np.arange(ROWS), [0, 40, 200, 360, 400], [0.0, 0.0, 1200.0, 0.0, 0.0])
MAPPED = ["--map", "t=time", "--map", "normal_force=force", "--unit", "normal_force=mN"]


def table(path: Path, lost: np.ndarray, word: str = "OL") -> Path:
    cells = [word if gone else f"{f:.1f}" for f, gone in zip(FORCE, lost, strict=True)]
    rows = (f"{t:.2f},{cell}" for t, cell in zip(T, cells, strict=True))
    path.write_text("\n".join(["time,force", *rows]) + "\n")
    return path


def imported(path: Path, *arguments: str) -> int:
    return main(["import", str(path), "-o", str(path.with_suffix("")), *MAPPED, *arguments])


def test_a_few_rows_are_counted_and_no_warning(tmp_path, capsys):
    path = table(tmp_path / "a.csv", np.isin(np.arange(ROWS), [50, 90]))
    assert imported(path, "--json") == 0
    captured = capsys.readouterr()
    told = json.loads(captured.out)["rows"]
    assert (told["in"], told["used"]) == (ROWS, ROWS - 2)
    assert told["left_out"] == {"number": {"count": 2, "seconds": pytest.approx(0.02)}}
    assert captured.err == ""


@pytest.mark.parametrize(
    ("lost", "part"),
    [
        (np.arange(ROWS) % 40 == 3, "10 of 400 rows are left out (2.5 %)"),
        (0.97 * FORCE.max() < FORCE, "with them the peak of normal_force"),
        (abs(T - 2.0) < 0.04, "with them the peak of normal_force"),
    ],
)
def test_more_than_one_in_a_hundred_or_a_peak_is_a_warning_before_all_else(lost, part, tmp_path, capsys):
    path = table(tmp_path / "a.csv", lost)
    assert imported(path) == 0
    told = capsys.readouterr().err.splitlines()[0]
    assert part in told
    assert "--thousands says what stands between thousands" in told


def test_empty_cells_at_a_peak_or_in_more_than_one_row_in_a_hundred_are_a_warning(tmp_path, capsys):
    for lost, part in ((abs(T - 2.0) < 0.04, "with them its peak"), (np.arange(ROWS) % 30 == 3, "14 of 400")):
        assert imported(table(tmp_path / "a.csv", lost, ""), "--force") == 0
        told = capsys.readouterr().err.splitlines()[0]
        assert part in told
        assert "normal_force has no value in" in told
    assert imported(table(tmp_path / "a.csv", np.arange(ROWS) % 10 != 3, ""), "--force") == 0
    assert capsys.readouterr().err == ""  # a slower sensor


def test_the_peak_of_each_press_counts(tmp_path):
    twice = np.r_[FORCE, 0.6 * FORCE]
    gone = np.arange(ROWS + 195, ROWS + 206)
    kept = np.setdiff1d(np.arange(2 * ROWS), gone)
    report = LoadReport(rows_read=2 * ROWS, rows_kept=kept.size)
    report.add(Kind.NUMBER, "force", gone)
    report.place_losses(0.01 * kept, kept, {"normal_force": twice[kept]}, np.zeros(kept.size))
    assert report.lost_parts == ["the peak of normal_force"]


def test_a_whole_second_is_named_with_its_time(tmp_path, capsys):
    report = LoadReport(rows_read=5000, rows_kept=4880)
    kept = np.r_[0:1000, 1120:5000]
    report.add(Kind.NUMBER, "force", range(1000, 1120))
    report.place_losses(0.01 * kept, kept, {"normal_force": np.ones(kept.size)}, np.zeros(kept.size))
    assert "all from 9.99 to 11.19 s" in report.warnings()[0]
    assert account([report])["left_out"]["number"]["seconds"] == pytest.approx(1.2)


def test_a_row_beside_a_hold_at_the_peak_is_no_lost_peak():
    report = LoadReport(rows_read=1000, rows_kept=997)
    kept = np.r_[0:500, 503:1000]
    report.add(Kind.NUMBER, "force", range(500, 503))
    report.place_losses(0.01 * kept, kept, {"normal_force": np.ones(kept.size)}, np.zeros(kept.size))
    assert report.warnings() == []


@pytest.mark.parametrize("share", [0.101, 0.5])
def test_a_tenth_is_refused_and_nothing_written_until_it_is_accepted(share, tmp_path, capsys):
    path = table(tmp_path / "a.csv", np.arange(ROWS) % 1000 < share * ROWS)
    assert imported(path) == 3
    (told,) = capsys.readouterr().err.splitlines()
    assert "--accept-losses goes on without them" in told
    assert not (tmp_path / "a").exists()
    assert imported(path, "--accept-losses") == 0
    assert "rows are left out" in capsys.readouterr().err
    read_recording(tmp_path / "a")


def test_what_an_import_doubted_is_said_by_every_command_that_reads_it(tmp_path, caplog, capsys):
    path = table(tmp_path / "a.csv", np.arange(ROWS) < 0.2 * ROWS)
    assert imported(path, "--accept-losses") == 0
    again = read_recording(tmp_path / "a")
    assert "80 of 400 rows are left out" in caplog.text
    assert "80 of 400 rows" in str(again.source["doubts"])


def test_a_force_of_the_wrong_sign_is_doubted_by_every_command_that_reads_it(tmp_path, caplog):
    depth = FORCE / 1200.0
    rows = (f"{t:.2f},{-f:.1f},{d:.4f}" for t, f, d in zip(T, FORCE, depth, strict=True))
    (tmp_path / "a.csv").write_text("\n".join(["time,force,depth", *rows]) + "\n")
    assert imported(tmp_path / "a.csv", "--map", "displacement=depth", "--unit", "displacement=mm") == 0
    read_recording(tmp_path / "a")
    assert "import with --negate normal_force" in caplog.text


def test_one_row_of_five_says_nothing_of_the_rest(tmp_path):
    report = LoadReport(rows_read=5, rows_kept=4)
    report.add(Kind.NUMBER, "force", [3])
    report.refuse("a.csv", accepted=False)
    report = LoadReport(rows_read=30, rows_kept=27)
    report.add(Kind.NUMBER, "force", [3, 4, 5])
    with pytest.raises(RecordingError, match="3 of 30 rows"):
        report.refuse("a.csv", accepted=False)


NOTHING = np.zeros(ROWS, dtype=bool)


def test_of_several_tables_every_row_left_out_is_counted_with_its_time(tmp_path, capsys):
    tables = [table(tmp_path / "a.csv", np.arange(ROWS) % 40 == 3), table(tmp_path / "b.csv", NOTHING)]
    assert imported(tables[1], str(tables[0]), "--json") == 0
    told = json.loads(capsys.readouterr().out)["rows"]
    assert told["in"] - told["used"] == 10
    assert told["left_out"] == {"number": {"count": 10, "seconds": pytest.approx(0.1)}}
    joined = import_recording(*tables, columns={"t": "time", "normal_force": "force"})
    assert joined.report.count(Kind.NUMBER) == joined.report.rows_lost == 10
    (finding,) = (one for one in joined.report.findings if one.kind.lost)
    assert (finding.what, len(finding.lines)) == ("a: force", SHOWN)


@pytest.mark.parametrize(
    ("lost", "part"),
    [
        (np.arange(ROWS) % 40 == 3, "a: 10 of 400 rows are left out (2.5 %)"),
        (abs(T - 2.0) < 0.04, "with them the peak of normal_force"),
    ],
)
def test_a_loss_that_is_a_warning_of_one_table_is_one_among_several(lost, part, tmp_path, caplog, capsys):
    a, b, c = (table(tmp_path / f"{name}.csv", NOTHING) for name in "abc")
    table(a, lost)
    assert imported(b, str(a), str(c)) == 0
    (told,) = capsys.readouterr().err.splitlines()
    assert "a: " in told
    assert part in told
    assert part in str(read_recording(tmp_path / "b").source["doubts"])
    assert part in caplog.text


def test_a_silence_in_one_of_several_tables_is_a_warning(tmp_path, capsys):
    lines = table(tmp_path / "a.csv", NOTHING).read_text().splitlines()
    (tmp_path / "a.csv").write_text("\n".join([*lines[:101], *lines[251:]]) + "\n")
    assert imported(table(tmp_path / "b.csv", NOTHING), str(tmp_path / "a.csv")) == 0
    assert "a: nothing came from 0.99 to 2.5 s" in capsys.readouterr().err
    paths = tmp_path / "b.csv", tmp_path / "a.csv"
    joined = import_recording(*paths, columns={"t": "time", "normal_force": "force"})
    assert any("a: nothing came from 0.99 to 2.5 s" in one for one in joined.report.missing)
