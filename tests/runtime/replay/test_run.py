"""A recording reaches a node over real frames in simulated time, whole and in order."""

import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

from vegrip.clock import NS
from vegrip.identification.recording import Recording, read_recording
from vegrip.identification.recording.session import read_output
from vegrip.identification.recording.writer import RecordingWriter
from vegrip.messages import FingertipState, ForceCommand, Message, ModelHealth, Reason
from vegrip.runtime import NodeBase
from vegrip.runtime.replay.run import run_through


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
