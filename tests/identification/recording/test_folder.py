"""A recording survives the disk bit for bit, and whatever is wrong with a file is said with its line."""

import gzip
import logging
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.identification.recording.drawn import check_same, recordings
from vegrip.errors import RecordingError
from vegrip.identification.recording import Kind, Recording, read_recording, write_recording

HIDDEN = (
    "adhesion",
    "load-dependent-friction",
    "nothing",
    "second-relaxation",
    "sensor-lag",
    "series-compliance",
)
TOML = "[fingertip]\nradius = 0.01\n[sensors]\nnormal_force = 0.01\n"
HEADER = "t,episode,displacement,normal_force\n"


def folder_with(tmp_path: Path, rows: str, toml: str = TOML, header: str = HEADER) -> Path:
    folder = tmp_path / "press"
    folder.mkdir()
    (folder / "recording.toml").write_text(toml)
    (folder / "recording.csv").write_text(header + rows)
    return folder


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(recording=recordings(), compressed=st.booleans())
def test_what_is_written_is_read_back_bit_for_bit(
    recording: Recording, compressed: bool, tmp_path: Path
) -> None:
    write_recording(recording, tmp_path / "r", compressed=compressed)
    again = read_recording(tmp_path / "r")
    check_same(again, recording)
    assert again.report.rows_lost == 0


@pytest.mark.parametrize("name", HIDDEN)
def test_a_recording_made_elsewhere_loads_whole(name: str, measured: Callable[[str], Path]) -> None:
    folder = measured("hidden-effects") / name
    recording = read_recording(folder)
    with gzip.open(folder / "recording.csv.gz", "rt") as file:
        lines = file.read().splitlines()
    assert len(recording) == recording.report.rows_read == len(lines) - 1
    assert not recording.report.findings
    assert len(set(recording.episode.tolist())) == 23
    assert 0.005 < recording.fingertip.radius < 0.02
    assert list(recording.columns) == lines[0].split(",")[2:]
    last = dict(zip(lines[0].split(","), map(float, lines[-1].split(",")), strict=True))
    assert {key: values[-1] for key, values in recording.columns.items()}.items() <= last.items()


def test_every_bad_row_is_named_by_line_and_counted(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    rows = [
        "0.0,0,0.0,0.1",  # line 2
        "0.1,0,0.0",  # 3: a field short
        "0.2,0,zero,0.1",  # 4: not a number
        "0.3,0,inf,0.1",  # 5: infinite
        "0.4,0,nan,0.1",  # 6: kept, missing
        "0.5,0,,0.1",  # 7: kept, missing
        "nan,0,0.0,0.1",  # 8: no time
        "0.5,0,0.0,0.2",  # 9: the stamp of line 7 again
        "0.3,0,0.0,0.2",  # 10: backwards
        "0.6,0.5,0.0,0.2",  # 11: no whole episode
        "0.7,0,0.0,0.2",
        "0.8,1_0,0.0,0.2",  # 13: no number, whatever Python thinks
    ]
    folder = folder_with(tmp_path, "\n".join(rows) + "\n")
    with caplog.at_level(logging.WARNING):
        recording = read_recording(folder)
    report = recording.report
    found = {(f.kind, f.what): f.lines for f in report.findings}
    assert found == {
        (Kind.FIELDS, ""): [3],
        (Kind.NUMBER, "displacement"): [4],
        (Kind.NUMBER, "episode"): [13],
        (Kind.INFINITE, "displacement"): [5],
        (Kind.MISSING, "displacement"): [6, 7],
        (Kind.NO_TIME, ""): [8, 11],
        (Kind.DUPLICATE, ""): [9],
        (Kind.BACKWARDS, ""): [10],
    }
    assert (report.rows_read, report.rows_kept, len(recording)) == (12, 4, 4)
    np.testing.assert_array_equal(recording.t, [0.0, 0.4, 0.5, 0.7])
    assert "4 of 12 rows kept" in caplog.text


def test_one_wild_stamp_costs_one_row(tmp_path: Path) -> None:
    folder = folder_with(tmp_path, "0.0,0,0,1\n900.0,0,0,2\n0.1,0,0,3\n0.2,0,0,4\n")
    recording = read_recording(folder)
    assert recording.columns["normal_force"].tolist() == [1, 3, 4]
    assert [f.lines for f in recording.report.findings] == [[3]]


def test_a_last_line_without_its_end_is_reported_not_trusted(tmp_path: Path) -> None:
    recording = read_recording(folder_with(tmp_path, "0.0,0,0.001,1.25\n0.1,0,0.001,1.2"))
    assert len(recording) == 1
    assert recording.report.count(Kind.CUT) == 1


@pytest.mark.parametrize(
    ("row", "what"),
    [
        ("0.0,0,0.001,1200.0", "normal_force outside"),  # millinewtons
        ("0.0,0,2.5,1.0", "displacement outside"),  # millimetres
        ("0.0,0,0.012,1.0", "displacement larger than the fingertip's radius of 0.01 m"),
    ],
)
def test_values_in_a_wrong_unit_are_kept_and_doubted(row: str, what: str, tmp_path: Path) -> None:
    recording = read_recording(folder_with(tmp_path, row + "\n"))
    assert len(recording) == 1
    doubts = [f for f in recording.report.findings if f.kind is Kind.IMPLAUSIBLE]
    assert any(what in f.what and f.lines == [2] for f in doubts)


def test_time_in_milliseconds_is_doubted(tmp_path: Path) -> None:
    recording = read_recording(folder_with(tmp_path, "".join(f"{100 * i},0,0,0\n" for i in range(60))))
    assert "t advances by 100 s a row" in recording.report.summary()


def test_an_unknown_radius_is_nan_and_said(tmp_path: Path) -> None:
    recording = read_recording(folder_with(tmp_path, "0,0,0,0\n", toml="[fingertip]\n"))
    assert math.isnan(recording.fingertip.radius)
    assert "radius is unknown" in recording.report.summary()


@pytest.mark.parametrize(
    ("toml", "header", "rows", "sentence"),
    [
        ("[fingertip\n", HEADER, "0,0,0,0\n", "not valid TOML"),
        ("[fingertip]\nradius = 8\n", HEADER, "0,0,0,0\n", "'radius' is 8; it must lie in 1e-09 .. 1 m"),
        ("[fingertip]\nradius = '8 mm'\n", HEADER, "0,0,0,0\n", "it must be a float in m"),
        ("[sensors]\nforce = 1.0\n", HEADER, "0,0,0,0\n", "unknown sensor 'force'"),
        ("[sensors]\ntorque_z = 0\n", HEADER, "0,0,0,0\n", "must be a positive standard deviation"),
        ("sensors = 3\n", HEADER, "0,0,0,0\n", "must be a table"),
        (TOML, "", "", "is empty"),
        (TOML, HEADER, "", "a header and no rows"),
        (TOML, HEADER, "x,y,z,u\n", "no usable row"),
        (TOML, HEADER, "0,0,,\n", "no channel holds a single value"),
        (TOML, "time,force_N\n", "0,0\n", "`vegrip import`"),
        (TOML, "episode,normal_force\n", "0,0\n", "there is no column 't'"),
        (TOML, "t,normal_force,normal_force\n", "0,0,0\n", "stands twice"),
    ],
)
def test_what_cannot_be_read_is_refused_in_a_sentence(
    toml: str, header: str, rows: str, sentence: str, tmp_path: Path
) -> None:
    with pytest.raises(RecordingError, match="press") as refused:
        read_recording(folder_with(tmp_path, rows, toml, header))
    assert sentence in str(refused.value)


def test_a_damaged_file_names_its_line_and_the_remedy(tmp_path: Path) -> None:
    folder = folder_with(tmp_path, "")
    (folder / "recording.csv").unlink()
    whole = gzip.compress((HEADER + "0.0,0,0.0,0.1\n" * 5000).encode())
    (folder / "recording.csv.gz").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(
        RecordingError, match=r"recording\.csv\.gz:\d+: the compressed file is damaged or cut"
    ):
        read_recording(folder)
    (folder / "recording.csv.gz").unlink()
    (folder / "recording.csv").write_bytes(b"\x7fELF\x02\x01\x01\x00\x00")
    with pytest.raises(RecordingError, match=r"recording\.csv:1: is not a text file"):
        read_recording(folder)
    (folder / "recording.csv").write_bytes(HEADER.encode() + b"0.0,0,0.0,\xff\xfe\n")
    with pytest.raises(RecordingError, match="is not a text file in UTF-8"):
        read_recording(folder)


def test_an_absent_folder_or_table_is_said(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="no such folder"):
        read_recording(tmp_path / "absent")
    folder = folder_with(tmp_path, "0,0,0,0\n")
    (folder / "recording.csv.gz").write_bytes(b"")
    with pytest.raises(RecordingError, match="holds both"):
        read_recording(folder)
    (folder / "recording.csv.gz").unlink()
    (folder / "recording.csv").unlink()
    with pytest.raises(RecordingError, match=r"there is no recording\.csv"):
        read_recording(folder)
    (folder / "recording.toml").unlink()
    with pytest.raises(RecordingError, match="no such file"):
        read_recording(folder)


@pytest.mark.parametrize(
    ("key", "remedy"), [("version = 0", "known are name"), ("stert = 5", "did you mean start?")]
)
def test_a_key_that_is_not_used_is_said(key: str, remedy: str, tmp_path: Path, caplog) -> None:
    found = read_recording(folder_with(tmp_path, "0,0,0,0\n1,0,0,1\n", f"{key}\n{TOML}"))
    assert f"{key.partition(' ')[0]!r} in recording.toml is not used" in found.report.summary()
    assert remedy in caplog.text


def test_a_misspelt_key_of_the_fingertip_is_said_with_the_right_one(tmp_path: Path, caplog) -> None:
    about = TOML.replace("radius", "raduis")
    assert about != TOML
    read_recording(folder_with(tmp_path, "0,0,0,0\n1,0,0,1\n", about))
    assert "did you mean radius?" in caplog.text


def test_a_folder_of_recordings_is_none_and_names_them(tmp_path: Path) -> None:
    for finger in ("thumb", "index"):
        (tmp_path / finger).mkdir()
        (tmp_path / finger / "recording.toml").write_text(TOML)
    with pytest.raises(RecordingError, match="holds the recordings index, thumb; give one of them"):
        read_recording(tmp_path)
