"""A running node asked from outside, over its sockets."""

import json
import threading
import time
from collections import Counter
from dataclasses import dataclass

import msgpack
import pytest
import zmq
from hypothesis import given
from hypothesis import strategies as st

from tests.pair import pair
from vegrip.cli import main
from vegrip.clock import WallClock
from vegrip.config import parameter
from vegrip.errors import ConfigError, InputError, UsageError
from vegrip.messages import FingertipState, ForceCommand, GraspPhase, GraspStatus, Lifecycle
from vegrip.runtime import registry
from vegrip.runtime.control_socket import ControlServer, NodeCalls
from vegrip.runtime.echo import EchoNode, EchoParameters
from vegrip.runtime.lifecycle import (
    TRANSITIONS,
    allowed_transitions,
    describe_parameters,
    route,
    state_after,
    with_value,
)
from vegrip.runtime.registry import Entry, ask
from vegrip.runtime.runner import LoopSettings, Runner
from vegrip.runtime.telemetry import Telemetry
from vegrip.runtime.telemetry_socket import TelemetryReader, TelemetrySocket
from vegrip.transport.codec.msgpack_codec import MsgpackCodec
from vegrip.transport.sender_clock import ClockEstimate


@dataclass(frozen=True)
class Inner:
    gain: float = parameter(1.0, unit="1", low=0.0, high=2.0, doc="of the loop")


@dataclass(frozen=True)
class Outer:
    inner: Inner = parameter(Inner())
    seed: int = parameter(0, live=False)


class Running:
    """An echo node with its loop in a thread."""

    def __init__(self):
        self.entry = Entry("/left/echo", "echo", "left")
        endpoint, self.outside = pair()
        self.node = EchoNode("echo", EchoParameters())
        beside = Counter()
        self.sink = TelemetrySocket(self.entry.telemetry, MsgpackCodec("left"), ("thumb",), beside)
        self.telemetry = Telemetry(self.sink)
        settings = LoopSettings(tick_period=0.001)
        self.runner = Runner(
            self.node, endpoint, WallClock(), settings, self.telemetry, self.entry.name, beside
        )
        self.server = ControlServer(self.entry.control, NodeCalls(self.runner, self.sink.topics), beside)
        self.telemetry.start()
        self.runner.start()
        self.thread = threading.Thread(target=self.runner.run)
        self.thread.start()

    def close(self):
        self.runner.stop()
        self.thread.join()
        self.server.close()
        self.telemetry.close()


@pytest.fixture
def running(runtime):
    running = Running()
    yield running
    running.close()


def test_a_parameter_is_set_within_its_bounds_while_the_node_runs(running):
    rows = ask(running.entry, "set_parameter", name="normal_force", value=2.5)
    assert {row["name"]: row["value"] for row in rows}["normal_force"] == 2.5
    running.outside.send(FingertipState(0, "thumb", 0))
    answers = []
    while not any(isinstance(answer, ForceCommand) for answer in answers):
        answers += running.outside.receive(1.0)
    assert next(a for a in answers if isinstance(a, ForceCommand)).normal_force == 2.5


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("normal_force", -1.0, "0 .. 20"),
        ("normal_force", "much", "float"),
        ("normal_force", float("nan"), "0 .. 20"),
        ("nothing", 1.0, "there are normal_force, validity"),
    ],
)
def test_what_is_out_of_bounds_is_refused_and_changes_nothing(running, name, value, words):
    with pytest.raises(InputError, match=words):
        ask(running.entry, "set_parameter", name=name, value=value)
    assert running.node.parameters == EchoParameters()


def test_the_state_is_changed_by_way_of_others(running):
    assert ask(running.entry, "state")["state"] == "active"
    assert ask(running.entry, "set_state", target="unconfigured")["state"] == "unconfigured"
    assert ask(running.entry, "set_state", target="active")["state"] == "active"
    assert ask(running.entry, "set_state", target="deactivate")["state"] == "inactive"
    assert running.runner.state is Lifecycle.INACTIVE
    with pytest.raises(UsageError, match="cannot deactivate"):
        ask(running.entry, "set_state", target="deactivate")


def test_a_hand_takes_its_zero_only_when_it_holds_nothing_and_can(running, monkeypatch):
    with pytest.raises(UsageError, match="may hold something"):
        ask(running.entry, "zero")
    ask(running.entry, "set_state", target="inactive")
    with pytest.raises(UsageError, match="no command for its zero"):
        ask(running.entry, "zero")
    asked = []
    monkeypatch.setattr(type(running.runner._endpoint), "zero", lambda _: not asked.append(1), raising=False)
    ask(running.entry, "zero")
    assert asked == [1]


def test_a_node_that_does_not_grip_says_so(running):
    for call in ("grasp", "release", "grasp_status"):
        with pytest.raises(UsageError, match="echo does not grip"):
            ask(running.entry, call)


@pytest.mark.parametrize(
    ("phase", "code", "said"),
    [(GraspPhase.HELD, 0, "held, 3.00 N, margin above 0.25"), (GraspPhase.WEAK, 4, "weak: margin of index")],
)
def test_a_grasp_is_waited_for_and_its_result_is_printed(running, monkeypatch, capsys, phase, code, said):
    status = GraspStatus(1, "echo", 1, GraspPhase.CLOSING, "", 1.0)
    reason = "margin of index" if code else ""
    ended = GraspStatus(2, "echo", 2, phase, reason, 3.0, 0.25)
    goals, told = [], iter([status, status, *[ended] * 9])
    monkeypatch.setattr(running.node, "grasp", goals.append, raising=False)
    monkeypatch.setattr(running.node, "grasp_status", lambda _: next(told), raising=False)
    monkeypatch.setattr(registry, "find_node", lambda _: running.entry)
    assert main(["grasp", "echo", "--force", "3", "--json"]) == code
    answer = capsys.readouterr()
    assert json.loads(answer.out) == {
        "phase": phase.name.lower(), "reached_goal": not code, "stalled": bool(code), "reason": reason,
        "normal_force": 3.0, "margin": 0.25,
    }  # fmt: skip
    assert goals == [{"force": 3.0, "max_force": 1000.0, "margin": 0.0, "timeout": 5.0}]
    assert main(["grasp", "echo"]) == code
    answer = capsys.readouterr()
    assert said in answer.out + answer.err


@pytest.mark.parametrize("call", ["nothing", "set_state"])
def test_a_bad_request_is_answered_and_the_next_one_too(running, call):
    with pytest.raises(UsageError):
        ask(running.entry, call)
    assert ask(running.entry, "state")["state"] == "active"


FRAMES = {
    "two empty ones": [b"", b"", b""],
    "one empty one": [b""],
    "nothing after the delimiter": [b"", b""],
    "a request in two": [b"", b"\x81", b"\xa4"],
    "no delimiter": [b"\x81\xa4call\xa5state"],
    "many": [b"x"] * 1000,
    "not msgpack": [b"", b"\xc1"],
    "deep": [b"", b"\x91" * 60_000],
}


@pytest.mark.parametrize("frames", FRAMES.values(), ids=FRAMES)
def test_whatever_the_frames_of_a_request_the_next_asker_is_answered(running, frames):
    with zmq.Context() as context, context.socket(zmq.DEALER) as stranger:
        stranger.linger = 0
        stranger.connect(running.entry.control)
        for _ in range(3):
            stranger.send_multipart(frames)
        assert stranger.poll(60_000), "it is answered, too"
    assert ask(running.entry, "state")["state"] == "active"


def test_what_is_no_request_is_counted_and_told_once(running, caplog):
    with zmq.Context() as context, context.socket(zmq.DEALER) as stranger:
        stranger.linger = 0
        stranger.connect(running.entry.control)
        for _ in range(5):
            stranger.send_multipart([b"", b"", b""])
            assert stranger.poll(60_000)
    for _ in range(2):
        seen = running.runner.status
        deadline = time.monotonic() + 60.0
        while running.runner.status is seen and time.monotonic() < deadline:
            time.sleep(0.01)
    assert running.runner.status.rejected["request"] == 5
    assert sum("control socket" in record.getMessage() for record in caplog.records) == 1


def test_one_who_asks_and_never_reads_keeps_nobody_waiting(running):
    with zmq.Context() as context, context.socket(zmq.DEALER) as stranger:
        stranger.linger = 0
        stranger.connect(running.entry.control)
        for _ in range(3000):
            stranger.send_multipart([b"", msgpack.packb({"call": "parameters"})], zmq.DONTWAIT)
            if not stranger.poll(0, zmq.POLLOUT):
                break
        assert ask(running.entry, "state", patience=30.0)["state"] == "active"


def test_telemetry_shows_what_comes_in_and_goes_out_with_namespace(running):
    reader = TelemetryReader([running.entry], ["/left/hand"])
    seen = []
    for seq in range(2000):  # until the subscription has arrived
        running.outside.send(FingertipState(1, "thumb", seq, normal_force=0.5))
        seen += reader.read(0.005)
        if {direction for _, _, direction, _ in seen} == {"in", "out"}:
            break
    reader.close()
    topics = {(topic, direction) for _, topic, direction, _ in seen}
    assert topics == {("/left/hand/thumb/state", "in"), ("/left/hand/thumb/force_command", "out")}
    assert {message.normal_force for *_, message in seen} == {0.5, 1.0}
    assert ask(running.entry, "topics")["/left/hand/thumb/state"]["in"] > 0


def test_requests_after_the_end_of_the_loop_are_refused_at_once(running):
    running.runner.stop()
    running.thread.join()
    start = time.monotonic()
    with pytest.raises(Exception, match="ending"):
        ask(running.entry, "set_state", target="inactive")
    assert time.monotonic() - start < 2.0


def test_groups_are_flattened_with_dotted_names():
    assert {row["name"]: row["value"] for row in describe_parameters(Outer())} == {
        "inner.gain": 1.0,
        "seed": 0,
    }


def test_a_dotted_name_sets_the_inner_value_only():
    changed = with_value(Outer(seed=4), "inner.gain", 2, running=True, where="node")
    assert changed == Outer(Inner(gain=2.0), seed=4)


def test_what_is_fixed_while_running_is_refused_then_and_allowed_before():
    with pytest.raises(ConfigError, match="unconfigured"):
        with_value(Outer(), "seed", 3, running=True, where="node")
    assert with_value(Outer(), "seed", 3, running=False, where="node").seed == 3


@pytest.mark.parametrize("name", ["inner", "inner.", "inner.gain.x", "", "inner.nothing"])
def test_what_is_no_parameter_is_named_with_those_there_are(name):
    with pytest.raises(ConfigError, match=r"inner\.gain, seed"):
        with_value(Outer(), name, 1, running=False, where="node")


def test_the_status_has_the_clock_of_the_hand_where_it_is_estimated(monkeypatch):
    endpoint, _ = pair()
    clock = ClockEstimate(offset=1.5, drift=1e-5, jitter=2e-4, worst=1e-3, jumps=1)
    monkeypatch.setattr(type(endpoint), "clock", clock)
    runner = Runner(
        EchoNode("echo", EchoParameters()), endpoint, WallClock(), LoopSettings(status_period=0.01)
    )
    status = NodeCalls(runner, dict).status
    assert status() is None, "nothing has been reported"
    runner.step()
    told = status()
    assert told["clock"] == {"offset": 1.5, "drift": 1e-5, "jitter": 2e-4, "worst": 1e-3, "jumps": 1}
    assert told["state"] == "unconfigured"


states = st.sampled_from(list(Lifecycle))


@given(states, st.sampled_from(list(TRANSITIONS)))
def test_a_transition_is_made_or_refused_never_ignored(state, transition):
    if transition in allowed_transitions(state):
        assert state_after(state, transition) is TRANSITIONS[transition][1]
    else:
        with pytest.raises(UsageError, match=state.name.lower()):
            state_after(state, transition)


def test_nothing_leaves_finalized():
    assert allowed_transitions(Lifecycle.FINALIZED) == []


def test_only_an_inactive_node_becomes_active():
    assert [state for state in Lifecycle if "activate" in allowed_transitions(state)] == [Lifecycle.INACTIVE]


@given(states, states)
def test_a_route_leads_where_it_says(start, target):
    if start is Lifecycle.FINALIZED and target is not start:
        with pytest.raises(UsageError):
            route(start, target)
        return
    state = start
    for transition in route(start, target):
        state = state_after(state, transition)
    assert state is target


def test_an_unknown_transition_names_the_known_ones():
    with pytest.raises(UsageError, match="configure, activate, deactivate, cleanup, shutdown"):
        state_after(Lifecycle.ACTIVE, "explode")
