"""What an exported finger meets in its self-test, its settings, and what it has learned."""

import json
import math
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.export.firmware import Firmware
from vegrip.c99 import host
from vegrip.cli import main
from vegrip.export import Request
from vegrip.export.finger import BROKEN_EVERY, alone, record
from vegrip.grip.controller import GripController
from vegrip.grip.friction_settings import FrictionSettings
from vegrip.grip.settings import ControlSettings
from vegrip.messages import Condition
from vegrip.model import paper_model, read_model, write_model

pytestmark = pytest.mark.skipif(host.compiler() is None, reason="no C compiler")
FRAMES = 260


def test_the_sequence_has_frames_ticks_broken_ones_and_faults() -> None:
    meetings = record(Request(paper_model(8e-3), frames=FRAMES, entry="finger")).meetings
    frames = [meeting for meeting in meetings if meeting.data]
    assert len(frames) == FRAMES
    assert len(frames) < len(meetings)
    assert any(not meeting.data and meeting.command for meeting in meetings), "a command renewed by the clock"
    assert not frames[BROKEN_EVERY - 1].command
    seen = {Condition(meeting.condition) for meeting in meetings}
    assert seen >= {Condition.OK, Condition.DEGRADED, Condition.STALE, Condition.REPLAYED}


def test_a_finger_has_the_friction_that_is_stated() -> None:
    """As a node has it; before, an export took that of its model whatever was stated."""
    stated = ControlSettings(friction=FrictionSettings(coefficient=0.3, coefficient_std=0.05))
    request = Request(paper_model(8e-3), frames=60, entry="finger", control=stated)
    node = GripController(request.fingers, request.model, request.noise, stated)
    own, others = (one.estimator.friction_law for one in (alone(request), node.fingers["thumb"]))
    assert own == others
    assert own[0] == pytest.approx(math.log(0.3 * 0.92))  # as channels of the usual gain feel it


@pytest.mark.long
@pytest.mark.usefixtures("host_alone")
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
    command = ["export", "c", str(tmp_path / "m.toml"), "-o", str(tmp_path / "fw"), "--entry", "finger"]
    for wrong in ("[grip]\ndrive_lag = 0.02\n", "[friction]\nlearning = true\n"):
        (tmp_path / "s.toml").write_text(wrong)
        assert main([*command, "--settings", str(tmp_path / "s.toml")]) == 3
        assert wrong.split()[1] in capsys.readouterr().err


def test_what_a_finger_learned_is_read_with_the_settings_of_its_export(
    firmware: Callable[..., Firmware], tmp_path: Path
) -> None:
    (tmp_path / "s.toml").write_text("[limits]\nmax_force = 7.5\n")
    folder, learned = firmware("finger")[0], tmp_path / "learned.toml"
    command = ["export", "learned", str(folder / "model.toml"), str(folder / "examples/finger.txt")]
    assert main([*command, "-o", str(learned), "--settings", str(tmp_path / "s.toml")]) == 0
    mu, before = (read_model(path).values["mu"] for path in (learned, folder / "model.toml"))
    assert mu.value != before.value
    assert mu.std < before.std


@pytest.mark.long
@pytest.mark.usefixtures("host_alone")
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
