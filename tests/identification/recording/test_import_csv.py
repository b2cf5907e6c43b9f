"""Foreign tables become recordings in SI units, or are refused in a sentence."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from vegrip.cli import main
from vegrip.errors import RecordingError, UsageError
from vegrip.identification import samples
from vegrip.identification.recording import Kind, Recording, read_recording
from vegrip.identification.recording.column_map import ColumnMap, read_column_map, with_columns
from vegrip.identification.recording.import_csv import baseline_noise, first_touch, import_csv

MAP = """
[time]
column = "ms"
unit = "ms"
[channels.normal_force]
column = "load"
unit = "mN"
zero = "baseline"
[channels.displacement]
column = "height"
unit = "um"
scale = -1
compliance = 0.5
zero = "contact"
[baseline]
duration = 0.25
[contact]
threshold = 0.05
"""


def table(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "press.csv"
    path.write_text(text)
    return path


def column_map(tmp_path: Path, text: str) -> ColumnMap:
    path = tmp_path / "map.toml"
    path.write_text(text)
    return read_column_map(path)


def test_units_sign_zero_and_compliance_are_applied_in_order(tmp_path: Path) -> None:
    rows = "ms,load,height\n0,7,5000\n100,7,4990\n200,7,4980\n300,107,4900\n400,207,4700\n"
    recording = import_csv(table(tmp_path, rows), column_map(tmp_path, MAP))
    force = np.array([0.0, 0.0, 0.0, 0.1, 0.2])  # (load - 7) mN
    travel = 1e-6 * np.array([0.0, 10.0, 20.0, 100.0, 300.0])  # height falls
    bending = 0.5 * force
    indentation = travel - bending
    np.testing.assert_allclose(recording.t, [0.0, 0.1, 0.2, 0.3, 0.4])
    np.testing.assert_allclose(recording.columns["normal_force"], force, atol=1e-12)
    np.testing.assert_allclose(
        recording.columns["displacement"], indentation - indentation[3], atol=1e-12
    )  # force first above 0.05 N in row 3


def test_the_command_line_maps_and_overrides(tmp_path: Path) -> None:
    path = table(tmp_path, "time,F,z,T\n0,1000,1,77\n1,2000,2,86\n")
    chart = with_columns(
        ColumnMap(),
        ["t=time", "normal_force=F", "displacement=z", "temperature=T"],
        ["normal_force=mN", "displacement=mm", "t=minute", "temperature=degF"],
    )
    recording = import_csv(path, chart, radius=0.01)
    np.testing.assert_allclose(recording.t, [0.0, 60.0])
    np.testing.assert_allclose(recording.columns["normal_force"], [1.0, 2.0])
    np.testing.assert_allclose(recording.columns["displacement"], [1e-3, 2e-3])
    np.testing.assert_allclose(recording.columns["temperature"], [25.0, 30.0])
    assert recording.fingertip.radius == 0.01


def test_scale_and_offset_of_a_map_are_in_si(tmp_path: Path) -> None:
    text = '[channels.temperature]\ncolumn = "T"\nunit = "degF"\nscale = 2.0\noffset = 1.0\n'
    recording = import_csv(table(tmp_path, "t,T\n0,77\n1,86\n"), column_map(tmp_path, text))
    np.testing.assert_allclose(recording.columns["temperature"], [51.0, 61.0])


def test_columns_with_our_names_need_no_map(tmp_path: Path) -> None:
    recording = import_csv(table(tmp_path, "t,normal_force,note\n5,1,a\n6,2,b\n"))
    assert list(recording.columns) == ["normal_force"]
    np.testing.assert_array_equal(recording.t, [0.0, 1.0])
    assert math.isnan(recording.fingertip.radius)


def test_trials_whose_clock_begins_anew_are_put_one_after_the_other(tmp_path: Path) -> None:
    rows = "t,sample,normal_force\n0,RDG 1,1\n1,RDG 1,2\n0,RDG 2,3\n2,RDG 2,4\n"
    chart = with_columns(ColumnMap(), ["episode=sample", "normal_force=normal_force"], [])
    recording = import_csv(table(tmp_path, rows), chart)
    np.testing.assert_array_equal(recording.t, [0.0, 1.0, 6.0, 8.0])  # gap of 5 s
    np.testing.assert_array_equal(recording.episode, [0, 0, 1, 1])


def test_semicolons_and_decimal_commas_are_read(tmp_path: Path) -> None:
    text = '[table]\ndelimiter = ";"\ndecimal = ","\nskip = 2\n[channels.normal_force]\ncolumn = "F"\n'
    path = table(tmp_path, 'made by "X"\n\nt;F;"re;mark"\n0;1,5;"a;b"\n0,5;2,5;\n')
    recording = import_csv(path, column_map(tmp_path, text))
    np.testing.assert_array_equal(recording.t, [0.0, 0.5])
    np.testing.assert_array_equal(recording.columns["normal_force"], [1.5, 2.5])


SECTIONS = """<Tester>
Operator:\tnone
<Touch>
<DATA>
t\tz\tF
0\t1\t9
<END DATA>
<Press>
Speed:\t3
<DATA>
t\tz\tF
0\t1\t2
1\t2\tn/a
2\t3\t4
<END DATA>
<Touch>
0\t1\t9
<Press>
<DATA>
t\tz\tF
0\t5\t6
"""


def sections(tmp_path: Path, text: str, name: str) -> Recording:
    chart = (
        f'[table]\nsection = "{name}"\n[episode]\ncolumn = "section"\n[channels.normal_force]\ncolumn = "F"\n'
    )
    return import_csv(table(tmp_path, text), column_map(tmp_path, chart))


def test_of_a_file_of_many_tables_those_below_one_line_become_the_episodes(tmp_path: Path) -> None:
    found = sections(tmp_path, SECTIONS, "<Press>")
    np.testing.assert_array_equal(found.columns["normal_force"], [2.0, 4.0, 6.0])
    np.testing.assert_array_equal(found.episode, [0, 0, 1])
    assert {f.kind: f.lines for f in found.report.findings if f.lines} == {Kind.NUMBER: [13]}


def test_a_file_without_the_asked_tables_or_with_unlike_ones_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="there is no table below a line '<Pull>'"):
        sections(tmp_path, SECTIONS, "<Pull>")
    unlike = SECTIONS[::-1].replace("F\tz\tt", "z\tF\tt", 1)[::-1]
    with pytest.raises(RecordingError, match="csv:20: the columns are not those of the first table"):
        sections(tmp_path, unlike, "<Press>")


def test_bad_rows_carry_the_line_numbers_of_the_file(tmp_path: Path) -> None:
    path = table(tmp_path, "# x\nt,normal_force\n0,1\n\n1,n/a\n2,\n3,4,5\n4,5")
    chart = column_map(tmp_path, '[table]\nskip = 1\n[channels.normal_force]\ncolumn = "normal_force"\n')
    report = import_csv(path, chart).report
    found = {f.kind: f.lines for f in report.findings if f.lines}
    assert found == {Kind.NUMBER: [5], Kind.MISSING: [6], Kind.FIELDS: [7]}
    assert (report.rows_read, report.rows_kept) == (5, 3)


def test_first_touch_is_not_fooled_by_spikes_before_it() -> None:
    force = np.array([0.0, 0.5, 0.0, -0.5, 0.0, 0.2, 0.6, 1.0, 0.05, 0.0])
    assert first_touch(force, 0.1) == 5
    assert first_touch(force[6:], 0.1) == 0
    assert first_touch(force, 2.0) is None
    assert first_touch(np.full(3, np.nan), 0.1) is None


def test_baseline_noise_is_blind_to_drift_and_spikes() -> None:
    rng = np.random.default_rng(4)
    values = rng.normal(0.0, 0.01, 4000) + np.linspace(0.0, 5.0, 4000)
    values[::100] += 3.0
    assert baseline_noise([values], 100) == pytest.approx(0.01, rel=0.06)
    assert baseline_noise([values[:2000], values[2000:] + 7.0], 100) == pytest.approx(0.01, rel=0.06)
    assert baseline_noise([values[:60], values[60:99]], 100) == 0.0


@pytest.mark.parametrize(("rows", "is_stated"), [(20, False), (100, True)])
def test_the_noise_is_stated_where_the_baselines_of_all_trials_tell_it(
    tmp_path: Path, rows: int, is_stated: bool
) -> None:
    """Nineteen differences tell it to 35 %, and what is stated is believed more than what a fit sees."""
    rng = np.random.default_rng(11)
    lines = ["trial,t,depth,normal_force"]
    for trial in range(6):
        depth = np.r_[np.full(rows, -1e-4), np.linspace(-1e-4, 1e-3, 50)] + 3e-3 * trial
        force = np.r_[np.zeros(rows), np.clip(np.linspace(-0.1, 1.0, 50), 0.0, None)]
        for i, (x, f) in enumerate(zip(depth, force, strict=True)):
            t = 10 * trial + 0.01 * i
            noise = rng.normal(0.0, (3e-6, 0.006))
            lines.append(f"{trial},{t:.2f},{x + noise[0]:.8f},{f + noise[1]:.6f}")
    (tmp_path / "map.toml").write_text(
        '[time]\ncolumn = "t"\n[episode]\ncolumn = "trial"\n[channels.displacement]\ncolumn = "depth"\n'
        'zero = "contact"\n[channels.normal_force]\ncolumn = "normal_force"\nzero = "baseline"\n'
        f"[baseline]\nduration = {0.01 * rows - 0.005}\n"
    )
    recording = import_csv(table(tmp_path, "\n".join(lines)), read_column_map(tmp_path / "map.toml"))
    if is_stated:
        assert recording.sensors == pytest.approx({"displacement": 3e-6, "normal_force": 0.006}, rel=0.15)
    else:
        assert recording.sensors == {}
    touch = [recording.columns["displacement"][recording.episode == i][rows] for i in range(6)]
    assert np.all(np.abs(np.array(touch) - touch[0]) < 1e-4)  # each trial has found its zero


ROWS = "time_s,F\n0,1\n1,2\n"


@pytest.mark.parametrize(
    ("columns", "units", "sentence"),
    [
        (["normal_force=time_s"], [], "say which one it is with --map t=COLUMN"),
        (["t=time_s", "normal_force=force"], [], "there is no column 'force'; there are time_s, F"),
        (["t=time_s", "normal_force=F"], ["normal_force=mm"], "'mm' is not a unit of this quantity"),
        (["t=time_s", "normal_force=F"], ["normal_force=newtron"], "there is no unit 'newtron'"),
        (["t=time_s", "normal_force=F"], ["normal_force=2 mN"], "there is no unit '2 mN'"),
        (["t=time_s", "normal_force=F"], ["normal_force=m("], "there is no unit 'm('"),
        (["t=time_s", "normal_force=F"], ["t=N"], "it needs one like s"),
        (["t=time_s", "normal_force=F"], ["normal_force=g"], "the weight of a gram is gf, of a kilogram kgf"),
        (["t=F"], [], "none of the columns"),
        (["episode=trial", "t=time_s", "normal_force=F"], [], "there is no column 'trial'"),
    ],
)
def test_a_map_that_does_not_fit_the_table_is_refused(
    columns: list[str], units: list[str], sentence: str, tmp_path: Path
) -> None:
    with pytest.raises(RecordingError, match=r"press\.csv") as refused:
        import_csv(table(tmp_path, ROWS), with_columns(ColumnMap(), columns, units))
    assert sentence in str(refused.value)


@pytest.mark.parametrize(
    ("column", "units", "said"),
    [
        ("force_g", [], "import with --unit normal_force=gf"),
        ("force_mN", [], "import with --unit normal_force=mN"),
        ("force_mN", ["normal_force=mN"], ""),
        ("force_N", [], ""),
        ("force_z", [], ""),
        ("force_s", [], ""),  # no unit of a force
    ],
)
def test_a_column_that_ends_like_a_unit_and_is_taken_as_si_is_suspected(
    column: str, units: list[str], said: str, tmp_path: Path
) -> None:
    chart = with_columns(ColumnMap(), ["t=time_s", f"normal_force={column}"], units)
    told = import_csv(table(tmp_path, ROWS.replace("F", column)), chart).report.summary()
    assert said in told
    assert ("ends like a unit" in told) == bool(said)


@pytest.mark.parametrize(
    "header",
    [
        "time_s,displacement_mm,normal_force_mN",
        "time [s],displacement [mm],normal_force (mN)",
        "t,displacement_mm,normal_force_mN",
    ],
)
def test_columns_called_like_channels_with_a_unit_behind_are_taken_in_it(header: str, tmp_path: Path) -> None:
    made = import_csv(
        table(tmp_path, f"{header},force_N,temperature_mN,slip_V\n0.5,0.25,300,9,9,9\n1,0.5,400,9,9,9\n")
    )
    assert made.columns.keys() == {"displacement", "normal_force"}
    assert made.t.tolist() == [0.0, 0.5]
    assert made.columns["displacement"] == pytest.approx([2.5e-4, 5e-4])
    assert made.columns["normal_force"] == pytest.approx([0.3, 0.4])
    assert "displacement in mm, normal_force in mN" in made.report.summary()


@pytest.mark.parametrize(("unit", "first"), [("K", 295.15), ("degF", 71.6), ("degC", 22.0)])
def test_a_temperature_is_taken_in_the_unit_behind_its_name(unit: str, first: float, tmp_path: Path) -> None:
    rows = f"0,{first},1\n0.5,{first},2\n"
    made = import_csv(table(tmp_path, f"t,temperature_{unit},normal_force\n{rows}"))
    assert made.columns["temperature"] == pytest.approx([22.0, 22.0])
    chart = with_columns(ColumnMap(), [f"temperature=bath_{unit}"], [])
    told = import_csv(table(tmp_path, f"t,bath_{unit},normal_force\n{rows}"), chart).report.summary()
    assert (f"--unit temperature={unit}" in told) == (unit != "degC")


@pytest.mark.parametrize(("unit", "factor"), [("mm_s", 1e-3), ("m_s", 1.0), ("mm/s", 1e-3), ("m/s", 1.0)])
def test_a_speed_is_taken_in_the_unit_behind_its_name(unit: str, factor: float, tmp_path: Path) -> None:
    rows = "0,0.5,2,1\n0.5,1.5,2,2\n"
    made = import_csv(table(tmp_path, f"t,slip_speed_{unit},contact_radius_mm,normal_force\n{rows}"))
    assert made.columns["slip_speed"] == pytest.approx([0.5 * factor, 1.5 * factor])
    assert made.columns["contact_radius"] == pytest.approx([2e-3, 2e-3])
    assert Kind.COLUMN not in {one.kind for one in made.report.findings}
    chart = with_columns(ColumnMap(), [f"slip_speed=v_{unit}"], [])
    told = import_csv(table(tmp_path, f"t,v_{unit},x,normal_force\n{rows}"), chart).report.summary()
    assert ("--unit slip_speed=mm/s" in told) == (factor != 1.0)


@pytest.mark.parametrize(("name", "is_force"), [("force_N", True), ("F [mN]", True), ("gap_mm", False)])
def test_a_force_that_was_not_read_is_pointed_out(name: str, is_force: bool, tmp_path: Path) -> None:
    told = import_csv(table(tmp_path, f"t,displacement,{name}\n0,1e-4,2\n0.5,2e-4,3\n")).report.summary()
    assert ("import with --map " in told) is is_force
    assert (f"normal_force={name}" in told) is is_force


def test_names_of_columns_with_a_comma_are_told_apart(tmp_path: Path) -> None:
    path = table(tmp_path, '"Time, s","Fz, gf"\n0,1\n1,2\n')
    with pytest.raises(RecordingError, match="none of the columns 'Time, s', 'Fz, gf' is called like"):
        import_csv(path)
    with pytest.raises(RecordingError, match="there are 'Time, s', 'Fz, gf'"):
        import_csv(path, with_columns(ColumnMap(), ["normal_force=Fz, gf"], []))


def test_a_doubt_of_the_import_is_said_once_when_the_recording_is_read(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    press = samples.recording()
    columns = (press.t, press.episode, -press.columns["displacement"], press.columns["normal_force"])
    rows = "".join(",".join(map(str, row)) + "\n" for row in zip(*columns, strict=True))
    path = table(tmp_path, f"t,episode,displacement,force_mN\n{rows}")
    given = ["--map", "normal_force=force_mN", "--radius", "8 mm"]
    assert main(["import", str(path), "-o", str(tmp_path / "r"), *given]) == 0
    caplog.clear()
    read_recording(tmp_path / "r")
    said = [one.getMessage() for one in caplog.records]
    assert [sum(words in one for one in said) for words in ("ends like a unit", "wrong sign")] == [1, 1]


def test_columns_that_are_not_used_are_named_in_one_line_and_are_no_warning(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = table(tmp_path, "t,normal_force,grip,slip_speed_V,\n0,1,2,3,\n0.5,2,3,4,\n")
    assert main(["import", str(path), "-o", str(tmp_path / "r")]) == 0
    told = capsys.readouterr()
    assert "  column not used: grip, slip_speed_V\n" in told.out
    assert told.err == ""
    assert "doubts" not in read_recording(tmp_path / "r").source
    assert main(["import", str(path), "-o", str(tmp_path / "s"), "--json"]) == 0
    (one,) = json.loads(capsys.readouterr().out)["recordings"]
    found = {finding["kind"]: finding["what"] for finding in one["report"]["findings"]}
    assert found["column"] == "grip, slip_speed_V"


def test_what_is_said_of_a_column_goes_before_the_unit_behind_its_name(tmp_path: Path) -> None:
    path = table(tmp_path, "time_s,normal_force_mN,f\n0,300,2\n1,400,3\n")
    other = import_csv(path, with_columns(ColumnMap(), ["normal_force=f"], []))
    assert other.columns["normal_force"].tolist() == [2.0, 3.0]
    said = import_csv(path, with_columns(ColumnMap(), ["normal_force=normal_force_mN"], ["normal_force=N"]))
    assert said.columns["normal_force"].tolist() == [300.0, 400.0]


@pytest.mark.parametrize(
    ("columns", "units", "sentence"),
    [
        (["force=F"], [], "there is no channel 'force'"),
        (["F"], [], "is not NAME=VALUE"),
        ([], ["force=mN"], "there is no channel 'force'"),
    ],
)
def test_a_wrong_option_is_a_usage_error(columns: list[str], units: list[str], sentence: str) -> None:
    with pytest.raises(UsageError) as refused:
        with_columns(ColumnMap(), columns, units)
    assert sentence in str(refused.value)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("[chanels]\n", "unknown section [chanels]"),
        ("[channels.force]\ncolumn = 'F'\n", "there is no such channel"),
        ("[channels.normal_force]\nunit = 'N'\n", "the key 'column' is missing"),
        ("[channels.normal_force]\ncolumn = 'F'\nzero = 'mean'\n", "must be one of none, first"),
        ("[channels.normal_force]\ncolumn = 'F'\ncompliance = 1.0\n", "belongs to displacement only"),
        ("time = 't'\n", "must be a table"),
        ("[channels]\nnormal_force = 'F'\n", "must be a table with the key 'column'"),
        ("[baseline]\nduration = -1\n", "it must lie in"),
    ],
)
def test_a_wrong_map_is_refused(text: str, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"map\.toml") as refused:
        column_map(tmp_path, text)
    assert sentence in str(refused.value)


@pytest.mark.parametrize(
    ("key", "sentence"),
    [
        ("zero = 'contact'", "a [contact] threshold or a [baseline] duration"),
        ("zero = 'baseline'", "give a [baseline] duration"),
        ("compliance = 1.0", "needs normal_force"),
    ],
)
def test_a_correction_without_what_it_needs_is_refused(key: str, sentence: str, tmp_path: Path) -> None:
    chart = column_map(tmp_path, f"[channels.displacement]\ncolumn = 'z'\n{key}\n")
    with pytest.raises(RecordingError) as refused:
        import_csv(table(tmp_path, "t,z\n0,1\n1,2\n"), chart)
    assert sentence in str(refused.value)
