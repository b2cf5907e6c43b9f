"""Tables as laboratories write them: thousands, minus signs, lines of units, times of all kinds, headers."""

from pathlib import Path

import numpy as np
import pytest

from vegrip.cli import main
from vegrip.errors import RecordingError
from vegrip.identification.recording.cell_numbers import plain_number
from vegrip.identification.recording.column_map import ColumnMap, TableMap, TimeMap, with_columns
from vegrip.identification.recording.import_csv import import_csv
from vegrip.identification.recording.mended_times import is_differences, mended
from vegrip.identification.recording.report import Kind, LoadReport

ROWS = 300
T = 0.01 * np.arange(ROWS)
DEPTH = np.interp(np.arange(ROWS), [0, 40, 150, 260, 300], [0.0, 0.0, 1000.0, 0.0, 0.0])  # [um]
FORCE = 1200.0 * (DEPTH / 1000.0) ** 1.5  # [mN]
MAPS = ["t=time", "displacement=depth", "normal_force=force"], ["displacement=um", "normal_force=mN"]


def written(path: Path, cell, delimiter=";", times=T, decimals=3) -> Path:
    rows = [
        delimiter.join((f"{t:.{decimals}f}".replace(".", cell(0.5)[1]), cell(d), cell(f)))
        for t, d, f in zip(times, DEPTH, FORCE, strict=True)
    ]
    path.write_text("\n".join([delimiter.join(("time", "depth", "force")), *rows]) + "\n", encoding="utf-8")
    return path


def read(path: Path, **table):
    chart = with_columns(ColumnMap(table=TableMap(**table)), *MAPS)
    return import_csv(path, chart, radius=8e-3)


def german(value: float, digits: int) -> str:
    return f"{value:,.{digits}f}".translate(str.maketrans(",.", ".,"))


@pytest.mark.parametrize(
    ("cell", "delimiter"),
    [
        (lambda v: german(v, 1), ";"),
        (lambda v: f"{v:,.1f}", ";"),
        (lambda v: f"{v:,.1f}", "\t"),
        (lambda v: f"{v:,.1f}".replace(",", "\u202f"), ";"),
        (lambda v: f"{v:,.1f}".replace(",", "'"), "\t"),
        (lambda v: f"{v:,.2f}".replace(",", " "), ","),
    ],
)
def test_marks_between_thousands_are_no_decimal_signs(cell, delimiter, tmp_path):
    found = read(written(tmp_path / "a.csv", cell, delimiter))
    np.testing.assert_allclose(found.columns["normal_force"], 1e-3 * FORCE, atol=1e-4)
    assert found.report.rows_lost == 0


@pytest.mark.parametrize("mark", [".", ","])
def test_a_mark_in_whole_numbers_is_read_as_what_makes_the_column_smooth(mark, tmp_path):
    head = [mark.join(("time;depth", "")).rstrip(mark) + ";force"]
    rows = [
        f"{10 * i};{f'{d:,.0f}'.replace(',', mark)};{f'{f:,.0f}'.replace(',', mark)}"
        for i, (d, f) in enumerate(zip(DEPTH, FORCE, strict=True))
    ]
    (tmp_path / "a.csv").write_text("\n".join([*head, *rows]) + "\n")
    found = read(tmp_path / "a.csv")
    np.testing.assert_allclose(found.columns["normal_force"], 1e-3 * np.round(FORCE), atol=1e-9)
    assert "stands between thousands" in found.report.summary()


def test_three_decimals_beside_whole_numbers_stay_decimals(tmp_path):
    force = [f"{v:.3f}" if i % 2 else f"{v:.0f}" for i, v in enumerate(np.linspace(2.0, 9.0, 200))]
    rows = [f"{0.01 * i:.2f},0,{f}" for i, f in enumerate(force)]
    (tmp_path / "a.csv").write_text("\n".join(["time,depth,force", *rows]) + "\n")
    np.testing.assert_allclose(
        read(tmp_path / "a.csv").columns["normal_force"], 1e-3 * np.array(force, float)
    )


def test_what_can_be_read_in_two_ways_is_asked_for(tmp_path, capsys):
    rows = [f"{i},0,{f}" for i, f in enumerate(["7", "1.250", "9", "2.125"] * 20)]
    (tmp_path / "a.csv").write_text("\n".join(["time,depth,force", *rows]) + "\n")
    arguments = [part for each in MAPS[0] for part in ("--map", each)]
    assert main(["import", str(tmp_path / "a.csv"), "-o", str(tmp_path / "r"), *arguments]) == 3
    assert "--thousands . reads it as thousands" in capsys.readouterr().err
    for mark, largest in ((".", 2125.0), ("none", 9.0)):
        out = str(tmp_path / f"r{mark}")
        assert main(["import", str(tmp_path / "a.csv"), "-o", out, *arguments, "--thousands", mark]) == 0
        capsys.readouterr()
        assert read(tmp_path / "a.csv", thousands=mark).columns["normal_force"].max() == 1e-3 * largest


@pytest.mark.parametrize(
    ("cell", "decimal", "plain"),
    [
        ("\u22121.5", ".", "-1.5"),
        ("\u20131,5", ",", "-1.5"),
        ("1 234", ".", "1234"),
        ("1.234.567", ".", "1234567"),
    ],
)
def test_a_number_is_what_a_reader_sees(cell, decimal, plain):
    assert plain_number(cell, decimal) == plain


@pytest.mark.parametrize("cell", ["12 34", "1,2345", "1'23", "OL"])
def test_what_is_no_number_stays_as_it_is(cell):
    with pytest.raises(ValueError, match="could not convert"):
        float(plain_number(cell))


@pytest.mark.parametrize("units", ["(min),(mm),(kN)", "[min],[mm],[kN]", "min,mm,kN", "<min>,<mm>,<kN>"])
def test_the_line_of_units_says_the_units(units, tmp_path):
    rows = [f"{t / 60:.8f},{d / 1e3:.5f},{f / 1e6:.9f}" for t, d, f in zip(T, DEPTH, FORCE, strict=True)]
    (tmp_path / "a.csv").write_text("\n".join(["time,depth,force", units, *rows]) + "\n")
    found = import_csv(tmp_path / "a.csv", with_columns(ColumnMap(), MAPS[0], []), radius=8e-3)
    assert found.duration == pytest.approx(2.99, abs=1e-4)
    np.testing.assert_allclose(found.columns["normal_force"], 1e-3 * FORCE, atol=1e-5)
    said = import_csv(tmp_path / "a.csv", with_columns(ColumnMap(), MAPS[0], ["displacement=m"]), radius=8e-3)
    assert "displacement in m as said, not in mm" in said.report.summary()


def test_a_line_of_unknown_units_is_asked_about(tmp_path):
    (tmp_path / "a.csv").write_text(
        "time,depth,force\n[Std],[mm],[N]\n" + "0,1,2\n1,1,2\n2,1,2\n3,1,2\n4,1,2\n5,1,2\n"
    )
    with pytest.raises(
        RecordingError, match="'Std', which is no unit of t that is known; say it with --unit t=UNIT"
    ):
        import_csv(tmp_path / "a.csv", with_columns(ColumnMap(), MAPS[0], []))


def test_the_header_is_the_line_above_the_numbers_that_go_on(tmp_path):
    head = (
        "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\t\t\n\t\t\t\nChannels\t2\t\t\n"
        "Samples\t300\t300\t\nTime\t11:20:01.12\t11:20:01.12\t\nX0\t0.0\t0.0\t\nDelta_X\t0.01\t0.01\t\n"
        "***End_of_Header***\t\t\t\n"
    )
    rows = [f"{t:.6f}\t{d:.6f}\t{f:.6f}\t" for t, d, f in zip(T, DEPTH, FORCE, strict=True)]
    (tmp_path / "a.lvm").write_text(head + "\n".join(["time\tdepth\tforce\tComment", *rows]) + "\n")
    assert len(read(tmp_path / "a.lvm")) == ROWS


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("0.00,0.1,3.1\n0.01,0.2,3.2\n", "the table has no header"),
        (
            "time,depth,force\n0,01,0,100,4,1\n0,02,0,100,4,2\n0,03,0,100,4,2\n",
            "decimal commas between commas",
        ),
        ("0;0;0\n1;2;3\n", "the table has no header"),
    ],
)
def test_a_table_that_says_not_what_it_is_is_refused_with_the_reason(text, said, tmp_path):
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(RecordingError, match=said):
        read(tmp_path / "a.csv")


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.tdms", b"TDSm\x0e\0\0\0", "LabVIEW's TDMS"),
        ("a.xlsx", b"PK\x03\x04" + bytes(40), "a workbook"),
        ("a.h5", b"\x89HDF\r\n\x1a\n", "HDF5"),
        ("a.csv", b"timestamp,arbitration_id,extended,remote,error,dlc,data\n", "can.logconvert a.csv a.blf"),
    ],
)
def test_a_file_of_another_kind_is_named_with_the_way_to_a_table(name, content, said, tmp_path):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(RecordingError, match=said):
        read(tmp_path / name)


@pytest.mark.parametrize("begin", [-2.5, -0.005, 1.7e9])
def test_times_may_begin_anywhere(begin, tmp_path):
    found = read(written(tmp_path / "a.csv", lambda v: f"{v:.3f}", ",", times=begin + T))
    np.testing.assert_allclose(found.t, T, atol=1e-6)


def test_rows_of_one_stamp_are_spread_where_all_stamps_have_as_many(tmp_path):
    coarse = np.arange(ROWS) // 5 * 0.05
    found = read(written(tmp_path / "a.csv", lambda v: f"{v:.3f}", ",", times=coarse))
    np.testing.assert_allclose(found.t, T, atol=1e-6)
    assert "300 rows have 60 time stamps" in found.report.summary()


def test_rows_of_uneven_stamps_are_spread_when_asked(tmp_path):
    coarse = np.where(T > 1.0, np.floor(T / 0.25) * 0.25, np.floor(T / 0.03) * 0.03)
    path = written(tmp_path / "a.csv", lambda v: f"{v:.3f}", ",", times=coarse)
    assert read(path).report.share_lost > 0.1
    chart = with_columns(ColumnMap(time=TimeMap(spread=True)), *MAPS)
    assert len(import_csv(path, chart, radius=8e-3)) == ROWS


@pytest.mark.parametrize(
    ("t", "are"),
    [
        (np.r_[0.0, np.full(99, 0.01)], True),
        (0.01 + 0.003 * np.sin(np.arange(200)), True),
        (np.floor(np.arange(300) / 100), False),
        (np.zeros(100), False),
        (np.r_[np.arange(100), np.arange(100)] * 0.01, False),
        (np.full(200, 1.7e9), False),
    ],
)
def test_times_that_do_not_grow_are_differences(t, are):
    assert is_differences(t) is are


def test_differences_are_summed(tmp_path):
    found = read(written(tmp_path / "a.csv", lambda v: f"{v:.3f}", ",", times=np.r_[0.0, np.diff(T)]))
    np.testing.assert_allclose(found.t, T, atol=1e-9)


def test_a_clock_that_is_set_back_in_a_log_goes_on_and_one_wild_stamp_is_left():
    report = LoadReport()
    back = np.r_[T[:150], T[150:] - 3600.0]
    np.testing.assert_allclose(mended(back, report, is_in_order=True), T, atol=1e-9)
    assert report.count(Kind.NOTE) == 0
    assert "the clock was set back 1 x" in report.summary()
    wild = T.copy()
    wild[100] = 1e6
    np.testing.assert_array_equal(mended(wild, LoadReport(), is_in_order=True), wild)


def test_trials_that_lie_over_each_other_are_asked_about(tmp_path, capsys):
    path = written(tmp_path / "a.csv", lambda v: f"{v:.3f}", ",", times=np.r_[T[:150], T[:150]])
    arguments = [part for each in MAPS[0] for part in ("--map", each)]
    assert main(["import", str(path), "-o", str(tmp_path / "r"), *arguments, "--accept-losses"]) == 3
    assert "--map episode=COLUMN" in capsys.readouterr().err


def test_a_step_with_a_time_of_the_test_is_doubted(tmp_path):
    since = np.geomspace(0.1, 100.0, 60)
    for begin, is_doubted in ((0.0, False), (120.0, True), (45.0, True)):
        rows = [f"{begin + t:.4f}\t{1e4 * t**-0.1:,.2f}" for t in since]
        (tmp_path / "a.txt").write_text("\n".join(["Time [s]\tRelaxation Modulus [Pa]", *rows]) + "\n")
        found = import_csv(tmp_path / "a.txt", is_step=True)
        assert len(found) >= 60
        assert any("after the step" in f.what for f in found.report.findings) is is_doubted


def test_a_missing_baseline_is_asked_for_in_the_form_of_the_question(tmp_path, capsys):
    path = written(tmp_path / "a.csv", lambda v: f"{v:.3f}", ",")
    arguments = [part for each in MAPS[0] for part in ("--map", each)]
    for zero in ("contact", "baseline"):
        typed = ["--zero", f"displacement={zero}"]
        assert main(["import", str(path), "-o", str(tmp_path / "r"), *arguments, *typed]) == 3
        assert "--baseline SECONDS" in capsys.readouterr().err


STEP = "[step]\n{name}\n{time}\tGap\tForce\ns\tmm\tN\n{rows}\n"


def test_tables_below_a_line_may_have_a_line_of_units_each(tmp_path):
    rows = "\n".join(
        f"{t:.2f}\t{d / 1e3:.4f}\t{f / 1e3:.5f}" for t, d, f in zip(T, DEPTH, FORCE, strict=True)
    )
    text = "".join(STEP.format(name=name, time="Step time", rows=rows) for name in ("Press", "Pull"))
    (tmp_path / "a.txt").write_text(f"Instrument\tRSA\n\n{text}")
    maps = ["t=Step time", "displacement=Gap", "normal_force=Force", "episode=section"]
    chart = with_columns(ColumnMap(table=TableMap(section="[step]")), maps, [])
    found = import_csv(tmp_path / "a.txt", chart, radius=8e-3)
    assert (len(found), sorted(set(found.episode.tolist()))) == (2 * ROWS, [0, 1])
    assert found.columns["displacement"].max() == pytest.approx(1e-3)


def test_tables_of_different_columns_are_said_to_be_that(tmp_path):
    text = "".join(
        STEP.format(name=time, time=time, rows="0.00\t1.0\t2.0\n0.01\t1.1\t2.1")
        for time in ("Time", "Step time")
    )
    (tmp_path / "a.txt").write_text(text)
    chart = with_columns(
        ColumnMap(table=TableMap(section="[step]")), ["t=Step time", "normal_force=Force"], []
    )
    with pytest.raises(RecordingError, match="give each kind of table as a file of its own"):
        import_csv(tmp_path / "a.txt", chart)


def test_a_column_that_stands_twice_refuses_nothing_where_it_is_not_asked_for(tmp_path):
    rows = "".join(f"{t:.2f},{d:.1f},{f:.1f},,\n" for t, d, f in zip(T, DEPTH, FORCE, strict=True))
    (tmp_path / "a.csv").write_text(f"time,depth,force,note,note\n{rows}")
    assert len(read(tmp_path / "a.csv")) == ROWS
    (tmp_path / "b.csv").write_text(f"time,depth,force,force,note\n{rows}")
    with pytest.raises(RecordingError, match="the column 'force' stands twice; rename one"):
        read(tmp_path / "b.csv")


@pytest.mark.parametrize("stamp", ["11:20:01.120", "2024-05-02T11:20:01", "11:20:01,120"])
def test_a_time_of_a_calendar_is_said_to_be_that(stamp, tmp_path):
    (tmp_path / "a.csv").write_text(f"time;depth;force\n{stamp};1;2\n{stamp};1;3\n")
    with pytest.raises(RecordingError, match=r"is a (date|time of day), .*; write it as a number"):
        read(tmp_path / "a.csv")
