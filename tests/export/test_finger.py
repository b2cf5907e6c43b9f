"""The exported finger builds anywhere, and answers frames with the bytes that the node answers."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.export.worst_inputs import assert_search_finds_more_than_recorded
from vegrip.c99 import host
from vegrip.cli import main
from vegrip.export import Exported, Request, write_export
from vegrip.export.finger_vectors import BROKEN_EVERY, record
from vegrip.export.measure import STRICT
from vegrip.grip.friction_settings import FrictionSettings
from vegrip.grip.settings import ControlSettings
from vegrip.messages import Condition
from vegrip.model import paper_model, read_model, write_model

pytestmark = pytest.mark.skipif(host.compiler() is None, reason="no C compiler")
SOURCES = ("lh_finger.c", "lh_vectors.c", "lh_selftest.c")
FRAMES = 260


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Exported]:
    folder = tmp_path_factory.mktemp("firmware")
    request = Request(paper_model(8e-3), prefix="lh", frames=FRAMES, entry="finger")
    return folder, write_export(request, folder)


def run(*command: str | Path, where: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(list(map(str, command)), cwd=where, capture_output=True, text=True, check=False)


def test_every_command_is_that_of_the_node_to_the_bit(exported: tuple[Path, Exported]) -> None:
    test = exported[1].measured.host_run
    assert test is not None
    assert test.passed
    assert test.frames == FRAMES
    assert test.equal == test.numbers > 3 * FRAMES
    assert test.largest == 0.0


def test_the_sequence_has_frames_ticks_broken_ones_and_faults() -> None:
    meetings = record(Request(paper_model(8e-3), frames=FRAMES, entry="finger")).meetings
    frames = [meeting for meeting in meetings if meeting.data]
    assert len(frames) == FRAMES
    assert len(frames) < len(meetings)
    assert any(not meeting.data and meeting.command for meeting in meetings), "a command renewed by the clock"
    assert not frames[BROKEN_EVERY - 1].command
    seen = {Condition(meeting.condition) for meeting in meetings}
    assert seen >= {Condition.OK, Condition.DEGRADED, Condition.STALE, Condition.REPLAYED}


def test_a_finger_alone_learns_friction_by_itself_whatever_the_hand_shares() -> None:
    friction = FrictionSettings(shared=True, probing=True)
    control = ControlSettings(friction=friction)
    alone, plain = (
        record(Request(paper_model(8e-3), frames=60, entry="finger", control=one))
        for one in (control, ControlSettings())
    )
    assert [meeting.command for meeting in alone.meetings] == [meeting.command for meeting in plain.meetings]


def test_a_wrong_limit_fails_the_self_test(exported: tuple[Path, Exported], tmp_path: Path) -> None:
    folder = exported[0]
    text = (folder / "lh_finger.c").read_text()
    wrong = re.sub(r"(#define LH_K_REASON_RAISE )1\b", r"\g<1>2", text)
    assert wrong != text
    (tmp_path / "lh_finger.c").write_text(wrong)
    sources = [tmp_path / "lh_finger.c", *SOURCES[1:]]
    compiler = str(host.compiler())
    built = run(compiler, *host.EXACT, f"-I{folder}", *sources, "-o", tmp_path / "t", "-lm", where=folder)
    assert built.returncode == 0, built.stderr
    done = run(tmp_path / "t", where=folder)
    assert done.returncode == 1
    assert "FAIL" in done.stdout


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("source", [*SOURCES, "examples/linux.c", "examples/bare_metal.c"])
def test_no_compiler_warns(
    compiler: str, source: str, exported: tuple[Path, Exported], tmp_path: Path
) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"no {compiler}")
    done = run(
        compiler, *host.EXACT, "-O2", *STRICT, "-I.", "-c", source, "-o", tmp_path / "o", where=exported[0]
    )
    assert done.returncode == 0, done.stderr
    assert not done.stderr


def test_no_undefined_behaviour(exported: tuple[Path, Exported], tmp_path: Path) -> None:
    checks = ("-fsanitize=undefined,address,float-cast-overflow", "-fno-sanitize-recover=all", "-g", "-O1")
    compiler = str(host.compiler())
    built = run(compiler, *host.EXACT, *checks, *SOURCES, "-o", tmp_path / "t", "-lm", where=exported[0])
    assert built.returncode == 0, built.stderr
    done = run(tmp_path / "t", where=exported[0])
    assert done.returncode == 0, done.stdout + done.stderr


def test_cppcheck_finds_nothing(exported: tuple[Path, Exported]) -> None:
    if shutil.which("cppcheck") is None:
        pytest.skip("no cppcheck")
    rules = (
        "--enable=warning,performance,portability",
        "--suppress=ignoredReturnValue",
        "--error-exitcode=1",
    )
    done = run("cppcheck", "-q", "--std=c99", *rules, *SOURCES, where=exported[0])
    assert done.returncode == 0, done.stderr


def test_it_runs_on_an_emulated_cortex_m7(exported: tuple[Path, Exported]) -> None:
    if shutil.which("arm-none-eabi-gcc") is None or shutil.which("qemu-system-arm") is None:
        pytest.skip("no arm-none-eabi-gcc or no qemu-system-arm")
    run_there = exported[1].measured.cortex_run
    assert run_there is not None
    assert run_there.passed
    assert run_there.frames == FRAMES


def test_a_search_finds_calls_that_take_more_than_the_recorded_ones(exported: tuple[Path, Exported]) -> None:
    assert_search_finds_more_than_recorded(*exported, "frame")


def test_the_hand_has_the_fingers_that_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(host, "compiler", lambda: None)
    write_model(paper_model(8e-3), tmp_path / "m.toml")
    command = ["export", "c", str(tmp_path / "m.toml"), "-o", str(tmp_path / "fw"), "--entry", "finger"]
    assert main([*command, "--fingers", "index,thumb", "--json"]) == 0
    capsys.readouterr()
    assert (
        "#define VG_FINGERS 2 /* of a grasp, by number: index, thumb */"
        in (tmp_path / "fw" / "vg_finger.h").read_text()
    )
    for wrong in ("thumb,thumb", "", "a,b,c,d,e,f,g,h,i"):
        assert main([*command, "--force", "--fingers", wrong]) == 2
        assert "--fingers" in capsys.readouterr().err


def test_settings_that_a_finger_cannot_follow_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_model(paper_model(8e-3), tmp_path / "m.toml")
    (tmp_path / "s.toml").write_text("[grip]\ndrive_lag = 0.02\n")
    command = ["export", "c", str(tmp_path / "m.toml"), "-o", str(tmp_path / "fw"), "--entry", "finger"]
    assert main([*command, "--settings", str(tmp_path / "s.toml")]) == 3
    assert "drive_lag" in capsys.readouterr().err


def test_what_a_finger_learned_is_read_with_the_settings_of_its_export(
    exported: tuple[Path, Exported], tmp_path: Path
) -> None:
    (tmp_path / "s.toml").write_text("[limits]\nmax_force = 7.5\n")
    folder, learned = exported[0], tmp_path / "learned.toml"
    command = ["export", "learned", str(folder / "model.toml"), str(folder / "examples/finger.txt")]
    assert main([*command, "-o", str(learned), "--settings", str(tmp_path / "s.toml")]) == 0
    mu, before = (read_model(path).values["mu"] for path in (learned, folder / "model.toml"))
    assert mu.value != before.value
    assert mu.std < before.std


def test_nothing_that_firmware_has_not(exported: tuple[Path, Exported]) -> None:
    text = (exported[0] / "lh_finger.c").read_text() + (exported[0] / "lh_finger.h").read_text()
    code = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    assert set(re.findall(r"#include\s*[<\"](\S+)[>\"]", code)) == {
        "lh_finger.h", "math.h", "stddef.h", "stdbool.h", "stdint.h",
    }  # fmt: skip
    assert not re.search(r"\b(malloc|calloc|free|printf|goto|setjmp|errno)\b", code)


def test_the_command_takes_the_settings_of_the_control(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_model(paper_model(8e-3), tmp_path / "m.toml")
    (tmp_path / "s.toml").write_text("[limits]\nmax_force = 7.5\n[grip]\nwanted_margin = 0.25\n")
    command = ["export", "c", str(tmp_path / "m.toml"), "-o", str(tmp_path / "fw"), "--entry", "finger"]
    assert main([*command, "--settings", str(tmp_path / "s.toml"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["passed"]
    assert told["largest_difference"] == 0.0
    assert told["frames"] == 500
    assert "7.5" in (tmp_path / "fw" / "vg_finger.c").read_text()
    assert read_model(tmp_path / "fw" / "model.toml").values["K"].value == pytest.approx(
        read_model(tmp_path / "m.toml").values["K"].value
    )
    (tmp_path / "s.toml").write_text("[suspects]\nx = 1\n")
    assert main([*command, "--settings", str(tmp_path / "s.toml"), "--force"]) == 3
    assert "[fail_safe]" in capsys.readouterr().err
