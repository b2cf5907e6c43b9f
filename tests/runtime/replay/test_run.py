"""A recording reaches a node over real frames in simulated time, whole and in order."""

import math
from collections.abc import Iterable
from pathlib import Path

import can
import numpy as np
import pytest

from vegrip.cli import main
from vegrip.clock import NS, SimulatedClock
from vegrip.errors import ConfigError
from vegrip.identification.recording import Fingertip, Recording, read_recording
from vegrip.identification.recording.can_frames import read_log
from vegrip.identification.recording.log_names import LOGS_OR_CANDUMP
from vegrip.identification.recording.session import read_output
from vegrip.identification.recording.writer import RecordingWriter
from vegrip.identification.samples import FOREIGN_DATABASE, FOREIGN_LOG, SAMPLES
from vegrip.messages import FingertipState, ForceCommand, Message, ModelHealth, Reason
from vegrip.runtime import NodeBase
from vegrip.runtime.replay.run import play_frames, read_settings, run_through, with_recording
from vegrip.transport.codec import Frame
from vegrip.transport.codec.frame import EXTENDED


class Listener(NodeBase):
    """Remembers what it is told and when; answers each state with a command."""

    def __init__(self) -> None:
        super().__init__("grasp_force")
        self.heard: list[tuple[int, FingertipState]] = []
        self.ticks: list[int] = []

    def on_message(self, message: Message, now: int) -> Iterable[Message]:
        assert isinstance(message, FingertipState)
        self.heard.append((now, message))
        n = len(self.heard)
        return [ForceCommand(now, message.finger, n, 1.0, 0.0, Reason.HOLD, now + NS // 10)]

    def on_tick(self, now: int) -> Iterable[Message]:
        self.ticks.append(now)
        return ()


def recording(t: Iterable[float], **columns: Iterable[float]) -> Recording:
    t = np.array(list(t))
    values = {name: np.array(list(column)) for name, column in columns.items()}
    return Recording("r", t, np.zeros(len(t), dtype=np.int64), values)


def test_every_state_arrives_when_it_was_measured_in_single_precision() -> None:
    t = np.array([5.0, 5.004, 5.0041, 6.5])
    force = np.array([1e-9 / 3, math.pi, math.nan, -1.0])
    node = Listener()
    outcome = run_through(node, {"thumb": recording(t, normal_force=force)})
    stamps = np.array([now for now, _ in node.heard])
    np.testing.assert_allclose((stamps - stamps[0]) / NS, t - t[0], atol=1e-9)
    assert [state.stamp for _, state in node.heard] == stamps.tolist()  # stamped on arrival
    received = np.array([state.normal_force for _, state in node.heard])
    np.testing.assert_array_equal(received.astype(np.float32), force.astype(np.float32))
    assert outcome.rejected == {}
    assert (outcome.fingers["thumb"].samples, outcome.fingers["thumb"].commands) == (4, 4)


def test_the_loop_ticks_between_the_states_as_in_real_time() -> None:
    node = Listener()
    run_through(node, {"thumb": recording([0.0, 0.1], slip=[0.0, 0.0])})
    steps = np.diff(node.ticks)
    assert len(node.ticks) >= 500  # 1 s before the first state and 0.1 s after it, every 2 ms
    assert set(steps.tolist()) == {2_000_000}


def test_fingers_come_in_the_order_of_their_stamps() -> None:
    fingers = {
        "thumb": recording([0.0, 0.2, 0.4], slip=[0.0, 0.0, 0.0]),
        "index": recording([0.1, 0.2, 0.3], slip=[1.0, 1.0, 1.0]),
    }
    node = Listener()
    outcome = run_through(node, fingers)
    assert [state.finger for _, state in node.heard] == ["thumb", "index", "thumb", "index", "index", "thumb"]
    assert [summary.samples for summary in outcome.fingers.values()] == [3, 3]
    assert 0.0 < outcome.bus_load < 0.01


def test_what_is_written_has_the_time_of_the_recording(tmp_path: Path) -> None:
    t = [3.0, 3.25, 4.0]
    with RecordingWriter(tmp_path / "s") as writer:
        run_through(Listener(), {"thumb": recording(t, slip=[0.0, 1.0, 0.0])}, writer=writer)
    np.testing.assert_array_equal(read_recording(tmp_path / "s" / "thumb").t, t)
    np.testing.assert_array_equal(read_output(tmp_path / "s" / "thumb" / "force_command.csv")["t"], t)


def test_what_classic_can_cannot_carry_is_counted_not_hidden() -> None:
    node = Listener()
    outcome = run_through(node, {"thumb": recording([0.0, 0.1], normal_force=[100.0, 1.0])}, fd=False)
    assert [state.normal_force for _, state in node.heard][1] == 1.0
    assert math.isnan(node.heard[0][1].normal_force)  # beyond 32.767 N: not measured
    assert outcome.rejected == {"clipped normal_force": 1}


def test_the_summary_counts_what_the_node_says() -> None:
    class Doubter(Listener):
        def on_message(self, message: Message, now: int) -> Iterable[Message]:
            super().on_message(message, now)
            yield ModelHealth(now, "thumb", len(self.heard), nis=2.0, rejected=len(self.heard))

    outcome = run_through(Doubter(), {"thumb": recording([0.0, 0.1], slip=[0.0, 0.0])})
    told = outcome.as_dict()["fingers"]["thumb"]
    assert (told["rejected"], told["conditions"]) == (2, {"missing": 2})
    assert told["nis"] is None  # never in contact
    assert told["duration"] == pytest.approx(0.1)
    assert told["highest_command"] is None


def press(radius: float) -> Recording:
    sensors = {"normal_force": 0.02, "slip_speed": 1e-3}
    columns = {"normal_force": np.zeros(1)}
    return Recording("p", np.zeros(1), np.zeros(1, int), columns, Fingertip(radius), sensors)


def test_radius_and_noise_come_from_the_recording() -> None:
    settings = with_recording({}, {"index": press(0.008)})
    assert settings == {"noise": {"normal_force": 0.02}, "tips": {"index": {"radius": 0.008}}}


@pytest.mark.parametrize(
    "said",
    [
        {"tip": {"radius": 0.01}},
        {"tip": {"model": "m.toml"}},
        {"tips": {"index": {"radius": 0.01}}},
        {"tips": {"index": {"model": "m.toml"}}},
    ],
)
def test_a_radius_in_the_settings_stands(said: dict[str, object]) -> None:
    settings = with_recording(said, {"index": press(0.008)})
    assert {key: settings[key] for key in said} == said


def test_noise_in_the_settings_stands() -> None:
    settings = with_recording({"noise": {"normal_force": 1.0}}, {"index": press(math.nan)})
    assert settings == {"noise": {"normal_force": 1.0}, "tips": {}}


def test_a_model_file_is_looked_for_beside_the_settings(tmp_path: Path) -> None:
    (tmp_path / "node.toml").write_text('[tip]\nmodel = "model.toml"\n')
    assert read_settings(tmp_path / "node.toml") == {"tip": {"model": str(tmp_path / "model.toml")}}
    assert read_settings(None) == {}
    with pytest.raises(ConfigError, match="no such file"):
        read_settings(tmp_path / "absent.toml")


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
    expected = [one for one in read_log(gripper / FOREIGN_LOG).frames if one.arbitration_id < 0x400]
    with can.Bus(interface="vegrip", channel="played", bitrate=1_000_000) as listener:
        assert main(["replay", FOREIGN_LOG, "--map", "hand.toml", "--speed", "50"]) == 0
        heard = []
        while len(heard) < len(expected) and (message := listener.recv(5.0)) is not None:
            heard.append(message)
    assert [(m.arbitration_id, bytes(m.data)) for m in heard] == [(f[0], f.data) for f in expected]
    assert f"played {len(expected)} frames of TIP_L, TIP_R" in capsys.readouterr().out


@pytest.mark.parametrize("suffix", LOGS_OR_CANDUMP)
def test_every_kind_of_log_is_one_by_its_name(tmp_path, capsys, suffix):
    (tmp_path / f"a{suffix}").touch()
    assert main(["replay", str(tmp_path / f"a{suffix}")]) == 2
    assert "give the map of its hand" in " ".join(capsys.readouterr().err.split())


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
