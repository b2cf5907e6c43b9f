"""The record and replay nodes: what is sent is what was recorded, at its time."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from vegrip.nodes import record, replay

from vegrip.cli import main
from vegrip.clock import NS
from vegrip.errors import ConfigError, RecordingError
from vegrip.identification.recording import Fingertip, Recording, read_recording, write_recording
from vegrip.identification.recording.writer import RecordingWriter
from vegrip.messages import FingertipState, Lifecycle, NodeStatus
from vegrip.runtime import NodeContext

CONTEXT = NodeContext("node")


def recorded(tmp_path: Path, finger: str = "index") -> Path:
    t = np.array([3.0, 3.01, 3.5, 4.0])
    columns = {"normal_force": np.array([0.0, 1.0, 2.0, np.nan]), "slip": np.zeros(4)}
    write_recording(
        Recording("press", t, np.zeros(4, int), columns, Fingertip(name=finger)), tmp_path / "press"
    )
    return tmp_path / "press"


def played(
    node: replay.ReplayNode, until: float, start: int, step: float = 0.002
) -> list[tuple[int, FingertipState]]:
    """Tick the node from ``start`` [ns] on; return when each state was sent."""
    sent = []
    for now in range(start, start + round(until * NS), round(step * NS)):
        sent += [(now, state) for state in node.on_tick(now) if isinstance(state, FingertipState)]
    return sent


@pytest.mark.parametrize("speed", [1.0, 4.0])
def test_every_state_is_sent_once_when_its_time_has_come(speed: float, tmp_path: Path) -> None:
    settings = {"recording": str(recorded(tmp_path)), "lead": 0.25, "speed": speed}
    node = replay.build(settings, CONTEXT)
    node.configure()
    node.activate()
    begin = 77 * NS
    sent = played(node, 2.0, begin)
    due = [begin + round((0.25 + t / speed) * NS) for t in (0.0, 0.01, 0.5, 1.0)]
    assert [state.stamp for _, state in sent] == due
    assert all(0 <= now - state.stamp < 0.005 * NS for now, state in sent)
    assert [state.seq for _, state in sent] == [0, 1, 2, 3]
    assert [state.normal_force for _, state in sent][:3] == [0.0, 1.0, 2.0]
    assert node.finished


def test_a_sender_that_was_late_catches_up_without_a_burst_and_loses_nothing(tmp_path: Path) -> None:
    t = np.arange(0.0, 1.0, 0.001)
    recording = Recording("press", t, np.zeros(t.size, int), {"normal_force": t}, Fingertip(name="index"))
    write_recording(recording, tmp_path / "dense")
    node = replay.build({"recording": str(tmp_path / "dense"), "lead": 0.0}, CONTEXT)
    node.configure()
    node.activate()
    sent = played(node, 0.1, 0)
    late = round(0.6 * NS)  # half a second without a tick
    counts = [len(list(node.on_tick(now))) for now in range(late, round(1.1 * NS), round(0.002 * NS))]
    assert max(counts) <= 7, "three times as many as in a tick on time"
    assert len(sent) + sum(counts) == t.size
    assert counts[-40:] == [0] * 40, "it is at the recording's end, on time"


def test_a_repeated_replay_counts_on_and_its_stamps_never_run_back(tmp_path: Path) -> None:
    node = replay.build({"recording": str(recorded(tmp_path)), "repeat": True}, CONTEXT)
    node.configure()
    node.activate()
    states = [state for _, state in played(node, 4.0, 0)]
    assert not node.finished
    assert len(states) > 8
    assert [s.seq for s in states] == list(range(len(states)))
    assert np.all(np.diff([s.stamp for s in states]) > 0)


def test_a_single_recording_can_play_another_finger(tmp_path: Path) -> None:
    node = replay.build({"recording": str(recorded(tmp_path, "toe")), "finger": "thumb"}, CONTEXT)
    node.configure()
    node.activate()
    assert {state.finger for _, state in played(node, 2.0, 0)} == {"thumb"}


def test_a_finger_that_the_bus_does_not_know_is_refused(tmp_path: Path) -> None:
    node = replay.build({"recording": str(recorded(tmp_path, "toe"))}, CONTEXT)
    with pytest.raises(ConfigError, match="the bus does not know toe"):
        node.configure()


def test_an_absent_recording_is_refused_when_the_node_is_configured(tmp_path: Path) -> None:
    node = replay.build({"recording": str(tmp_path / "absent")}, CONTEXT)
    with pytest.raises(RecordingError, match="there is no such folder"):
        node.configure()


def test_what_the_record_node_hears_can_be_read(tmp_path: Path) -> None:
    settings = {"folder": str(tmp_path / "s"), "radius": 0.009, "noise": {"normal_force": 0.01}}
    node = record.build(settings, CONTEXT)
    node.configure()
    node.activate()
    for i in range(20):
        assert not list(node.on_message(FingertipState(5 + i, "ring", i, normal_force=float(i)), 0))
    node.deactivate()
    node.cleanup()
    assert node.dropped == 0
    ring = read_recording(tmp_path / "s" / "ring")
    assert ring.columns["normal_force"].tolist() == list(range(20))
    assert (ring.fingertip, ring.sensors) == (Fingertip(0.009, "ring"), {"normal_force": 0.01})


def test_a_record_node_whose_folder_is_deleted_says_what_is_lost(tmp_path: Path) -> None:
    node = record.build({"folder": str(tmp_path / "s")}, CONTEXT)
    node.configure()
    list(node.on_message(FingertipState(5, "ring", 0, normal_force=1.0), 0))
    recorder = node._recorder
    assert recorder is not None
    recorder._stop.set()
    recorder._thread.join()
    recorder._drain()
    recorder.writer.flush()  # what was taken is on disk
    shutil.rmtree(tmp_path / "s")
    node.cleanup()
    assert "1 of 1 rows are lost" in node.failure


def test_a_bus_on_which_no_state_comes_is_said_once_after_five_seconds(tmp_path, caplog) -> None:
    def said(states_at: tuple[float, ...]) -> list[str]:
        caplog.clear()
        node = record.build({"folder": str(tmp_path / str(len(states_at)))}, CONTEXT)
        node.configure()
        for tick in range(1, 200):
            now = tick * NS // 10
            if now / NS in states_at:
                node.on_message(FingertipState(now, "index", tick), now)
            list(node.on_tick(now))
        node.cleanup()
        return [each.getMessage() for each in caplog.records]

    assert said((4.9,)) == []
    (sentence,) = said(())
    assert sentence.startswith("no state has come for 5 s, so nothing is recorded")


@pytest.mark.parametrize("heard", [(), (NodeStatus(7, "grasp_force", 0, Lifecycle.ACTIVE),)])
def test_a_recording_without_a_state_ends_in_one_sentence_and_no_success(
    heard, tmp_path, monkeypatch, capsys
) -> None:
    folder = tmp_path / "grasp"

    def run(node) -> None:
        with RecordingWriter(Path(node.parameters["folder"])) as writer:
            for message in heard:
                writer.write(message)

    monkeypatch.setattr("vegrip.runtime.process.run_node", run)
    assert main(["record", "-o", str(folder)]) == 4
    assert f"{folder} holds no hand: no state of a finger came" in capsys.readouterr().err
    heard = (FingertipState(7, "index", 1),)
    assert main(["record", "-o", str(folder), "--force"]) == 0
    assert capsys.readouterr().err == f"{folder}: index\n"
