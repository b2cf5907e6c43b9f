"""A report is one file that needs nothing else, and says what was found."""

import json
import re
from pathlib import Path

import pytest

from vegrip.cli import main
from vegrip.identification.samples import SAMPLES
from vegrip.web.check.session import CHECK_FILE
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


def test_the_report_of_a_refinement_tells_data_model_failure_ladder_and_how_to_repeat_it(
    refined: Path,
) -> None:
    file = refined / "report.html"
    assert main(["report", str(refined / "ladder"), "-o", str(file)]) == 0
    text = file.read_text()
    assert is_self_contained(text)
    for said in (
        "1.79 → 1.02",
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
