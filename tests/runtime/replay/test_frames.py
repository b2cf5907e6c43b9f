"""A CAN log played on a bus."""

import can
import pytest

from vegrip.cli import main
from vegrip.clock import NS, SimulatedClock
from vegrip.identification.recording.can_log import frames_of
from vegrip.identification.samples import FOREIGN_DATABASE, FOREIGN_LOG, SAMPLES
from vegrip.runtime.replay.run import play_frames
from vegrip.transport.codec import Frame
from vegrip.transport.codec.frame import EXTENDED

FRAMES = [
    Frame(0x123, b"a", False, 7 * NS),
    Frame(0x1234567 | EXTENDED, b"bc", False, 8 * NS),
    Frame(0x124, bytes(12), True, 8 * NS + 1),
]


@pytest.mark.parametrize("speed", [1.0, 4.0])
def test_each_frame_is_sent_as_it_was_when_its_time_has_come(speed):
    clock, sent = SimulatedClock(5), []
    assert play_frames(FRAMES, lambda one: sent.append((clock.now(), one)), clock, speed) == 3
    assert [at for at, _ in sent] == [5, 5 + round(NS / speed), 5 + round((NS + 1) / speed)]
    assert [(m.arbitration_id, m.is_extended_id, m.is_fd, bytes(m.data)) for _, m in sent] == [
        (0x123, False, False, b"a"),
        (0x1234567, True, False, b"bc"),
        (0x124, False, True, bytes(12)),
    ]


@pytest.fixture
def gripper(runtime, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in (FOREIGN_DATABASE, FOREIGN_LOG):
        SAMPLES[name].write(tmp_path / name)
    windows = ["--rest", "0..2", "--press", "2..5", "--shear", "5..8", "--twist", "8..10", "--json"]
    bus = ["--channel", "played", "--interface", "vegrip"]
    assert main(["connect", FOREIGN_DATABASE, "-o", "hand.toml", "--log", FOREIGN_LOG, *windows, *bus]) == 0
    return tmp_path


def test_a_log_reaches_whoever_listens_on_the_bus_of_its_map(gripper, capsys):
    capsys.readouterr()
    expected = [frame for frame in frames_of(gripper / FOREIGN_LOG) if frame.arbitration_id < 0x400]
    with can.Bus(interface="vegrip", channel="played", bitrate=1_000_000) as listener:
        assert main(["replay", FOREIGN_LOG, "--map", "hand.toml", "--speed", "50"]) == 0
        heard = []
        while len(heard) < len(expected) and (message := listener.recv(5.0)) is not None:
            heard.append(message)
    assert [(m.arbitration_id, bytes(m.data)) for m in heard] == [(f[0], f.data) for f in expected]
    assert f"played {len(expected)} frames of TIP_L, TIP_R" in capsys.readouterr().out


BAD = {
    "no map": ([FOREIGN_LOG], 2, "give the map of its hand, or a launch file that names one, by --map"),
    "another log": (["other.log", "--map", "hand.toml"], 2, "none of its frames is one that hand.toml reads"),
    "through": ([FOREIGN_LOG, "--map", "hand.toml", "--through"], 2, "leave out --through and --finger"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_log_that_cannot_be_played_gets_one_sentence(gripper, capsys, name):
    (gripper / "other.log").write_text("(1.0) can0 7FF#00\n")
    arguments, code, sentence = BAD[name]
    capsys.readouterr()
    assert main(["replay", *arguments]) == code
    assert sentence in " ".join(capsys.readouterr().err.split())
