"""A report is one file that needs nothing else, and says what was found."""

import json
import math
import re
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip.cli import main
from vegrip.effects import effect
from vegrip.identification.samples import SAMPLES
from vegrip.model import paper_model, write_model
from vegrip.plotting import runs
from vegrip.web.axes import BOTTOM, LEFT, RIGHT, TOP, Axes, extent, log_ticks, ticks
from vegrip.web.check.session import CHECK_FILE, Rung, Session, save
from vegrip.web.markup import document, listed, table

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def refined(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("refined")
    SAMPLES["press"].write(folder / "press")
    assert main(["refine", str(folder / "press"), "--report", str(folder / "ladder"), "--json"]) == 0
    return folder


def is_self_contained(text: str) -> bool:
    return not re.search(r"""(?:src|href)\s*=|url\(|@import|<script|<link""", text)


@pytest.mark.long
def test_the_report_of_a_refinement_tells_data_model_failure_ladder_and_how_to_repeat_it(
    refined: Path,
) -> None:
    file = refined / "report.html"
    assert main(["report", str(refined / "ladder"), "-o", str(file)]) == 0
    text = file.read_text()
    assert is_self_contained(text)
    for said in (
        "1.78 → 1.02",
        "a pull that it lacks",
        "+ adhesion",
        "SHA-256",
        "3045",
        "could not be seen: no temperature was recorded",
        "vegrip refine",
        "numba",
    ):
        assert said in text, said


def test_the_report_of_a_recording_is_that_of_its_refinement(refined: Path) -> None:
    files = [refined / "one.html", refined / "other.html"]
    assert main(["report", str(refined / "press"), "-o", str(files[0])]) == 0
    assert main(["report", str(refined / "ladder"), "-o", str(files[1])]) == 0
    one, other = (re.sub(r"<pre.*?</pre>", "", file.read_text()) for file in files)
    numbers = [re.findall(r"class=.huge.>(.*?)<", text) for text in (one, other)]
    assert numbers[0] == numbers[1] != []


def test_a_file_is_not_written_over_without_being_told(
    refined: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = refined / "kept.html"
    file.write_text("mine")
    assert main(["report", str(refined / "ladder"), "-o", str(file)]) == 3
    assert file.read_text() == "mine"


@pytest.fixture
def checked(refined: Path, tmp_path: Path) -> Path:
    """The folder of a check that found what the refinement did."""
    told = json.loads((refined / "ladder" / "report.json").read_text())
    session = Session(str(refined / "press"))
    start, end = (rung["error"] for rung in told["ladder"])
    session.add(Rung("0-start.toml", None, None, start, told["before"], told["diagnosis"]))
    last = Rung("1-adhesion.toml", "adhesion", 0, end, told["after"], told["diagnosis"], told["parameters"])
    session.add(last)
    save(session, tmp_path)
    write_model(paper_model(tip_radius=0.008).with_effect(effect("adhesion")), tmp_path / last.model)
    return tmp_path


def test_the_report_of_a_check_cites_the_laws_of_the_model_that_is_looked_at(checked: Path) -> None:
    assert main(["report", str(checked), "-o", str(checked / "check.html")]) == 0
    text = (checked / "check.html").read_text()
    assert is_self_contained(text)
    assert "1.78 → 1.02" in text
    for key in ("TiezziKao2007", "DerjaguinMullerToporov1975", "MaugisBarquins1978"):
        assert f"@article{{{key}," in text


def test_a_check_whose_model_is_gone_is_one_sentence(
    checked: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (checked / "1-adhesion.toml").unlink()
    assert main(["report", str(checked), "-o", str(checked / "check.html")]) == 3
    said = capsys.readouterr().err
    assert "1-adhesion.toml" in said
    assert "Traceback" not in said


def test_an_account_of_an_older_version_says_how_to_make_it_again(
    refined: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    told = json.loads((refined / "ladder" / "report.json").read_text())
    del told["effects"]
    (tmp_path / "report.json").write_text(json.dumps(told))
    assert main(["report", str(tmp_path), "-o", str(tmp_path / "old.html")]) == 3
    said = " ".join(capsys.readouterr().err.split())
    assert "lacks effects; make it again with `vegrip refine --report`" in said


@pytest.mark.parametrize("name", ["report.json", CHECK_FILE, "session.toml"])
@pytest.mark.parametrize("text", ["", "{}", "[1]", "\x00", '{"recording": "nowhere"}'])
def test_a_damaged_folder_is_one_sentence(
    tmp_path: Path, name: str, text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).write_text(text)
    assert main(["report", str(tmp_path), "-o", str(tmp_path / "out.html")]) == 3
    assert "Traceback" not in capsys.readouterr().err
    assert not (tmp_path / "out.html").exists()


def test_a_folder_of_nothing_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", str(tmp_path), "--json"]) == 3
    assert "is neither a recording" in capsys.readouterr().err


def test_what_files_say_cannot_become_markup() -> None:
    text = document("<b>", table(["<i>"], [["<u>"]]) + listed(["<s>"]), "<q>")
    assert not re.search(r"<(b|i|u|s|q)>", text.replace("<b>vegrip</b>", ""))


def test_a_run_is_told_with_margins_slips_reasons_and_latencies(tmp_path: Path) -> None:
    write_run(tmp_path)
    assert main(["report", str(tmp_path), "-o", str(tmp_path / "run.html"), "--json"]) == 0
    text = (tmp_path / "run.html").read_text()
    assert is_self_contained(text)
    assert "2 slips were felt" in text
    assert "the lowest bound of a margin was -0.10, at thumb" in text
    assert "hold 60 %" in text
    assert "1.50" in text  # ms, p99


def write_run(folder: Path) -> None:
    (folder / "session.toml").write_text('began = "2026-01-01T00:00:00+00:00"\nclosed = true\n')
    (folder / "thumb").mkdir()
    reasons = ["hold", "slip", "slip", "hold", "hold", "slip", "hold", "hold", "hold", "raise"]
    rows = [f"{0.1 * i:g},{i},{2 + 0.1 * i:g},0,{reason},1" for i, reason in enumerate(reasons)]
    (folder / "thumb" / "force_command.csv").write_text(
        "\n".join(["t,seq,normal_force,adjustment,reason,expires", *rows]) + "\n"
    )
    bounds = [0.3, 0.2, -0.1, 0.1, 0.3]
    rows = [f"{0.2 * i:g},{i},0.5,0.1,1,0,{bound},0.95,1,," for i, bound in enumerate(bounds)]
    head = "t,seq,margin,margin_std,margin_valid,margin_age,lower_bound,confidence,force_reserve,"
    head += "time_to_slip,earliest_slip"
    (folder / "thumb" / "slip_margin.csv").write_text("\n".join([head, *rows]) + "\n")
    (folder / "diagnostics.csv").write_text(
        "t,node,seq,state,rate_in,rate_out,latency_p50,latency_p99,latency_max,lateness_max,deadline_misses,dropped,"
        "rejected\n0.5,grasp,1,active,500,500,400,1500,2000,100,0,0,\n"
    )


def test_the_account_of_a_refinement_is_json_that_other_programs_read(refined: Path) -> None:
    told = json.loads((refined / "ladder" / "report.json").read_text())
    assert [rung["effect"] for rung in told["ladder"]] == [None, "adhesion"]
    assert told["after"]["error"] < told["before"]["error"]


ENDS = st.floats(-1e6, 1e6)


@given(ENDS, st.floats(1e-6, 1e6))
def test_ticks_lie_within_the_axis_evenly_and_are_few(low: float, width: float) -> None:
    found = ticks((low, low + width))
    tolerance = 1e-9 * (abs(low) + width)
    assert all(low - tolerance <= tick <= low + width + tolerance for tick in found)
    assert len(found) <= 8
    steps = [b - a for a, b in pairwise(found)]
    assert not steps or max(steps) - min(steps) <= 1e-6 * max(steps) + tolerance


def test_logarithmic_ticks_are_one_two_five() -> None:
    assert log_ticks((0.9, 20.0)) == [1.0, 2.0, 5.0, 10.0, 20.0]


@given(st.lists(st.floats(allow_nan=True, allow_infinity=True), max_size=5))
def test_an_extent_is_finite_and_holds_what_is_finite(values: list[float]) -> None:
    low, high = extent([v for v in values if not math.isfinite(v) or abs(v) < 1e100])
    assert low < high
    assert all(low <= v <= high for v in values if math.isfinite(v) and abs(v) < 1e100)


def test_the_ends_of_the_axes_are_the_corners_of_the_frame() -> None:
    axes = Axes((1.0, 3.0), (-2.0, 2.0), "x [s]", "y [N]", (300, 200))
    axes.points([1.0, 3.0], [-2.0, 2.0], "blue")
    places = re.findall(r'cx="([\d.]+)" cy="([\d.]+)"', axes.svg("test"))
    assert [tuple(map(float, place)) for place in places] == [(LEFT, 200 - BOTTOM), (300 - RIGHT, TOP)]


def test_text_cannot_become_markup() -> None:
    drawn = Axes((0.0, 1.0), (0.0, 1.0), "<script>", '"><b>').svg('"><script>alert(1)</script>')
    assert "<script" not in drawn
    assert "<b>" not in drawn


def test_no_line_is_drawn_over_a_time_in_which_nothing_was_measured() -> None:
    from vegrip.web.figures import over_time

    time = [0.0, 0.1, 0.2, 3.0, 3.1, 3.2]
    names = ("measured_low", "measured_high", "model_low", "model_high")
    columns = {"time": time} | {name: [1.0] * 6 for name in names}
    told = {"columns": columns, "unit": "N", "noise": 0.1}
    whole = told | {"columns": columns | {"time": [0.1 * i for i in range(6)]}}
    blue = 'stroke="var(--blue)"'
    assert over_time("normal_force", told).count(blue) == 2
    assert over_time("normal_force", whole).count(blue) == 1


@given(st.lists(st.floats(0.0, 1e6), max_size=20, unique=True).map(sorted))
def test_runs_are_all_columns_once_and_in_their_order(times: list[float]) -> None:
    assert [t for run in runs(times) for t in times[run]] == times
