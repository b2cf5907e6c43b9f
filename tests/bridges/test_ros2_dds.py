"""ROS 2 over DDS on loopback, against a peer process that shares no code with vegrip."""

import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.bridges.messages_of_a_hand import SENT
from vegrip.bridges import ros2_types as ros2
from vegrip.cli import main
from vegrip.clock import NS
from vegrip.errors import DeviceError
from vegrip.messages import ForceCommand, Reason
from vegrip.transport.codec.msgpack_codec import MsgpackCodec

pytest.importorskip("cyclonedds")

from vegrip.bridges.ros2_dds import Incoming, Link, Outgoing, idl_type, relay

PEER = Path(__file__).with_name("ros2_peer.py")
COUNT = 1000
PATIENCE = 60.0  # [s] on a busy machine
STAMP = 1_700_000_000_000_000_005


@pytest.fixture
def link() -> Iterator[Link]:
    told: list[str] = []
    made = Link(101 + os.getpid() % 100, complain=told.append)
    made.told = told  # type: ignore[attr-defined]
    yield made
    made.close()


@pytest.fixture
def peer(link: Link) -> Iterator[Callable[..., subprocess.Popen[str]]]:
    started: list[subprocess.Popen[str]] = []

    def start(how: str, count: int = 0) -> subprocess.Popen[str]:
        words = [sys.executable, str(PEER), str(link.domain), how, str(count)]
        process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        started.append(process)
        assert process.stdout.readline() == "ready\n"
        return process

    yield start
    for process in started:
        process.stdin.close()
        process.wait(PATIENCE)
        process.stdout.close()


def command(force: float) -> ForceCommand:
    return ForceCommand(1, "thumb", 0, force, 0.0, Reason.HOLD, 9)


def until(done: Callable[[], object]) -> None:
    end = time.monotonic() + PATIENCE
    while not done():
        assert time.monotonic() < end


def test_a_thousand_messages_go_each_way_in_order(link: Link, peer) -> None:
    incoming, outgoing = Incoming(link, ("thumb",)), Outgoing(link)
    outgoing.send("/hand/thumb/force_command", command(-1.0))  # so that it is there
    process = peer("echo", COUNT)
    states = []

    def turn() -> bool:
        for state in incoming.read(7):
            states.append(state)
            outgoing.send("/hand/thumb/force_command", command(state.normal_force))
        return len(states) >= COUNT

    until(turn)
    assert [state.normal_force for state in states] == [float(n) for n in range(COUNT)]
    assert [state.seq for state in states] == list(range(1, COUNT + 1))
    assert process.stdout.readline() == f"{COUNT} True\n"
    assert link.left_out == 0


def test_a_second_publisher_of_a_finger_is_named_and_counted(link: Link, peer) -> None:
    incoming, states = Incoming(link, ("thumb",)), []
    incoming.read(0)
    for _ in range(2):
        peer("publish", 50)

    def turn() -> bool:
        states.extend(incoming.read(0))
        return len(states) + link.left_out == 100

    until(turn)
    assert (len(states), link.left_out) == (50, 50)
    assert link.told == ["two publishers send /hand/thumb/wrench; the first is received, stop one of them"]


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ("other_type", "publishes /hand/thumb/wrench as geometry_msgs::msg::dds_::Wrench_"),
        ("version", "another version of geometry_msgs::msg::dds_::WrenchStamped_"),
        ("best_effort", "/hand/thumb/wrench is published best effort and not received"),
    ],
)
def test_what_does_not_fit_is_named_once(link: Link, peer, how: str, said: str) -> None:
    Incoming(link, ("thumb",)).read(0)
    peer(how)

    def turn() -> bool:
        link.look()
        return bool(link.told)

    until(turn)
    link.look()
    (sentence,) = link.told
    assert said in sentence


def test_what_is_sent_has_the_bytes_of_the_types_that_are_offered() -> None:
    for message in SENT:
        kind, row = type(message), ros2.row_of(message, 0)
        for name in ros2.ends_of("/hand/thumb/topic", kind).values():
            data = ros2.message_of(name, "/hand/thumb/topic", kind, row, STAMP)
            assert idl_type(name).deserialize(data).serialize() == data, name


def test_the_message_files_of_the_package_are_what_is_sent() -> None:
    folder = Path(__file__).parents[2] / "proto" / "ros2" / "vegrip_msgs" / "msg"
    assert {path.stem for path in folder.glob("*.msg")} == {kind.__name__ for kind in ros2.TYPES}
    for kind in ros2.TYPES:
        assert (folder / f"{kind.__name__}.msg").read_text() == ros2.own_lines(kind)


def test_a_joint_of_the_fingers_name_is_its_displacement(link: Link, peer) -> None:
    incoming, states = Incoming(link, ("thumb",)), []
    incoming.read(0)
    process = peer("joints", 50)
    assert process.stdout.readline() == "there\n"
    assert incoming.read(0) == []
    process.stdin.write("go\n")
    process.stdin.flush()

    def turn() -> bool:
        states.extend(incoming.read(0))
        return len(states) == 50

    until(turn)
    assert states[-1].displacement == 1e-3
    assert math.isnan(states[-1].slip)  # not measured


def test_a_displacement_that_came_a_tenth_of_a_second_ago_is_missing_until_the_next_one() -> None:
    came: dict[str, list[object]] = {}
    source = SimpleNamespace(read=lambda topic, _: came.pop(topic, []))
    incoming = Incoming(source, ("thumb",))  # type: ignore[arg-type]
    vector = SimpleNamespace(x=0.0, y=0.0, z=1.0)
    wrench = SimpleNamespace(wrench=SimpleNamespace(force=vector, torque=vector))
    felt = []
    for now, positions in ((5, [1e-3]), (NS // 10 + 5, []), (NS // 10 + 6, []), (NS, [2e-3])):
        came["/hand/thumb/wrench"] = [wrench]
        came["/joint_states"] = [SimpleNamespace(name=["thumb"], position=[one]) for one in positions]
        felt += [state.displacement for state in incoming.read(now)]
    assert felt == pytest.approx([1e-3, 1e-3, math.nan, 2e-3], nan_ok=True)


def test_what_nodes_say_goes_out_and_what_comes_in_goes_to_a_node(link: Link, peer) -> None:
    got: list[float] = []

    class Source:
        def look(self):
            return {"/hand/thumb/force_command": ForceCommand}

        def read(self, topics, period):
            assert period > 0.0
            return [(topic, command(3.0)) for topic in topics]

        def rest(self):
            """No program reads a command yet, or any more."""

    def take(state) -> None:
        got.append(state.normal_force)
        if len(got) == 20:
            raise KeyboardInterrupt

    peer("publish", 20)
    with pytest.raises(KeyboardInterrupt):
        relay(link, Source(), Incoming(link, ("thumb",)), take)
    assert got == [float(n) for n in range(20)]


def test_only_what_another_program_reads_is_asked_of_nodes(link: Link, peer) -> None:
    outgoing, codec = Outgoing(link), MsgpackCodec(fingers=("thumb",))
    topics = {}
    for message in 2 * SENT:  # nodes and fingers share the topic of diagnostics, in any order
        topic, _ = codec.encode(message)
        topics[topic] = type(message)
        outgoing.send(topic, message)
    assert len(topics) == len(SENT)
    assert outgoing.wanted(topics) == []
    Incoming(link, ("thumb",)).read(0)  # for which it waits
    process = peer("publish", 0)  # it also reads the commands
    until(lambda: outgoing.wanted(topics))
    assert outgoing.wanted(topics) == ["/hand/thumb/force_command"]
    process.stdin.close()
    until(lambda: not outgoing.wanted(topics))


@pytest.mark.parametrize("more", [[], ["--states", "tcp://127.0.0.1:*"]])
def test_ctrl_c_within_cyclone_dds_ends_the_bridge_without_an_error(
    runtime, monkeypatch, capsys, more: list[str]
) -> None:
    def look(self: Link) -> None:
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt:  # as the library turns whatever its callbacks raise into this
            raise Exception("Callfunc endpoint constructor errored.") from None

    monkeypatch.setattr(Link, "look", look)
    assert main(["bridge", "ros2", "--domain", "227", *more]) == 130
    assert not capsys.readouterr().err


def test_an_interface_that_is_not_there_is_one_sentence(capsys) -> None:
    with pytest.raises(DeviceError, match="--interface"):
        Link(230, "none9")
    assert main(["bridge", "ros2", "--domain", "229", "--interface", "none9"]) == DeviceError.exit_code
    assert len([line for line in capsys.readouterr().err.splitlines() if "domain 229" in line]) == 1


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["--states", "nonsense"], 3, "'nonsense' is no address"),
        (["--interface", "none9"], 4, "there is no interface none9"),
        (["--fingers", " , "], 2, "--fingers is ' , '"),
    ],
)
def test_what_is_refused_is_refused_before_anything_is_promised(capsys, words, code: int, said: str) -> None:
    assert main(["bridge", "ros2", "--domain", "228", *words]) == code
    out = capsys.readouterr()
    assert said in out.err
    assert len(out.err.splitlines()) == 1
    assert not out.out
