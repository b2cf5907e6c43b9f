"""The exported node in C and the virtual hand, each a process, over the bus of the kernel; the test watches.

The C node takes its times in the microseconds that its commands carry, so what was on the bus is enough to
ask the objects of the node in Python for the same commands.
"""

import os
import shutil
import signal
import subprocess
import sys
import time
from collections import deque
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations

import can
import pytest

from vegrip.c99 import host
from vegrip.estimator import ContactEstimator
from vegrip.export import finger, finger_vectors
from vegrip.export.request import HAND, Request
from vegrip.grip.node import GraspForce
from vegrip.messages import FingertipState, ForceCommand, Reason
from vegrip.model import paper_model
from vegrip.runtime.registry import running_nodes
from vegrip.transport.codec import CanCodec, Frame

LAUNCH = """
fingers = ["thumb", "index", "middle", "ring", "little"]

[transport]
kind = "can"
interface = "socketcan"
channel = "vcan0"
fd = true

[[node]]
program = "virtual_hand"
required = true
loop.tick_period = 0.01
loop.status_period = 1.0
[node.parameters]
disturbed = false
hand.step = 2e-3
hand.rings = 4
hand.spokes = 8
hand.sensor.rate = 50.0
"""
REQUEST = Request(paper_model(9e-3, modulus=3e5), frames=20, entry="finger")
PATIENCE = 180.0  # [s]
STARTING = 420.0  # [s] for a hand that is compiled first, by an emulated kernel
FAULTS = {Reason.INPUT_HOLD, Reason.FAIL_SAFE}
HELD, SILENT, AGAIN = 60, 40, 20  # commands of every finger: in the grip, without states, with states again
WINDOW, TRIES = (
    40,
    8,
)  # of the commands before one that differs, those that may have been answers to something else
US, HALF, ALL = 1000, 1 << 31, (1 << 32) - 1


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    """The exported node, compiled as a user compiles it."""
    if host.compiler() is None:
        pytest.skip("no C compiler")
    folder = tmp_path_factory.mktemp("firmware")
    for name, text in finger.write(REQUEST, finger_vectors.record(REQUEST)).files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    make = shutil.which("make") or "make"
    built = subprocess.run([make, "-C", folder, "linux"], capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    return folder / "build" / "linux"


@dataclass(frozen=True)
class Episode:
    """What was on the bus, frame by frame, and how the node ended."""

    log: list[can.Message]
    silent: int  # number of the first frame after the hand was stopped
    again: int  # and of the first after it went on
    code: int
    told: str


@pytest.fixture(scope="module")
def episode(program, tmp_path_factory):
    """A grip is held; the sensors go silent; they come again; the node is told to end."""
    folder = tmp_path_factory.mktemp("launch")
    before = os.environ.get("VEGRIP_RUNTIME_DIR")
    os.environ["VEGRIP_RUNTIME_DIR"] = str(folder / "run")
    (folder / "hand.toml").write_text(LAUNCH)
    with can.Bus(interface="socketcan", channel="vcan0", fd=True) as bus:
        node = subprocess.Popen([program, "vcan0"], stdout=subprocess.PIPE, text=True)
        launcher = subprocess.Popen([sys.executable, "-m", "vegrip", "launch", folder / "hand.toml"])
        try:
            log: list[can.Message] = []
            listen(bus, log, HELD, STARTING)
            (hand,) = [one.pid for one in running_nodes() if one.name == "/virtual_hand"]
            os.kill(hand, signal.SIGSTOP)
            silent = listen(bus, log, SILENT)
            os.kill(hand, signal.SIGCONT)
            again = listen(bus, log, AGAIN)
            deadline = time.monotonic() + PATIENCE
            while not is_controlled(log[again:]) and time.monotonic() < deadline:
                listen(bus, log, 1)
            node.terminate()
            told, _ = node.communicate(timeout=60)
            listen(bus, log, 0)
        finally:
            launcher.send_signal(signal.SIGINT)
            launcher.wait(60)
            node.kill()
            os.environ.pop("VEGRIP_RUNTIME_DIR")
            os.environ |= {"VEGRIP_RUNTIME_DIR": before} if before else {}
    return Episode(log, silent, again, node.returncode, told)


def listen(bus, log, commands, patience=PATIENCE):
    """Keep frames until so many more commands of every finger came; return the number of the first frame."""
    start, wanted = len(log), {command_id(name): commands for name in HAND}
    deadline = time.monotonic() + patience
    while any(count > 0 for count in wanted.values()):
        assert time.monotonic() < deadline, f"still to come: {wanted}; {len(log)} frames came"
        message = bus.recv(1.0)
        if message is not None:
            log.append(message)
            if message.arbitration_id in wanted:
                wanted[message.arbitration_id] -= 1
    while (message := bus.recv(0.0)) is not None:  # what was sent is there at once
        log.append(message)
    return start


def codec():
    return CanCodec(HAND, fd=True, use_sender_time=True)


@cache
def command_id(name):
    return codec().line(name).command_id


def of(frames, cls, name):
    """Decode those of a finger, as one who only listens."""
    line, listener = codec().line(name), codec()
    identifier = line.command_id if cls is ForceCommand else line.state_id
    mine = [bytes(one.data) for one in frames if one.arbitration_id == identifier]
    return [listener.decode(Frame(identifier, data, fd=True, stamp=1)) for data in mine]


def is_controlled(log):
    """Whether each finger has had a command that is no answer to a fault."""
    return all({one.reason for one in of(log, ForceCommand, name)} - FAULTS for name in HAND)


class Answers:
    """The node in Python, asked for what it answers at given instants."""

    def __init__(self):
        control = replace(REQUEST.control, report_period=0.0, health_period=0.0)
        settings = replace(REQUEST.settings, late=0)
        self.codec = codec()
        self.node = GraspForce(
            "n", HAND, lambda _: ContactEstimator(REQUEST.model, REQUEST.noise, settings), control
        )
        self.node.configure()
        self.node.activate()
        self.waiting = {name: deque() for name in HAND}
        self.ticked = -1  # [ns]
        self.due = {}

    def by_frame(self, name, now):
        """Take the oldest frame that waits; return the command."""
        frame = self.waiting[name].popleft()
        message = self.codec.decode(Frame(frame.arbitration_id, bytes(frame.data), fd=True, stamp=now))
        assert message is not None
        return self._commands(self.node.on_message(message, now))[name]

    def by_clock(self, name, now):
        """Look at the clock; all fingers do so at one instant."""
        if now != self.ticked:
            self.ticked, self.due = now, self._commands(self.node.on_tick(now))
        return self.due.get(name)

    def _commands(self, answers):
        commands = [one for one in answers if isinstance(one, ForceCommand)]
        return {one.finger: self.codec.encode(one)[0].data for one in commands}


def instant(command):
    """When it was made [ns]: the instant nearest to now with these 32 bits of microseconds."""
    now = time.monotonic_ns() // US
    stamp = int.from_bytes(command.data[8:12], "little")
    return (now + (stamp - now + HALF & ALL) - HALF) * US


def real_time():
    """Return what the clock of arrivals is ahead of that of commands [ns], by the quickest of many looks."""
    looks = [(time.time_ns(), time.monotonic_ns(), time.time_ns()) for _ in range(1000)]
    first, between, last = min(looks, key=lambda look: look[2] - look[0])
    return (first + last) // 2 - between


def differing(log):
    """Return of each command that differs: number in the log, that of the C node, that of Python.

    A command is the answer to the oldest state that waits, unless that came after the command was made: then
    it was renewed by the clock. The node may have looked at the clock before it was given a state that
    waited, so where a command differs, those shortly before it are taken the other way,
    one or two of them, the least sure first.
    """
    turned = frozenset()
    while (first := _first_differing(log, turned, waits := {})) is not None:
        unsure = sorted(list(waits)[-WINDOW:], key=lambda one: abs(waits[one]))[:TRIES]
        for chosen in (set(some) for n in (1, 2) for some in combinations(unsure, n)):
            other = _first_differing(log, turned ^ chosen, {})
            if other is None or other > first:
                turned ^= chosen
                break
        else:
            break
    return list(_differing(log, turned, {}))


def _first_differing(log, turned, waits):
    return next((number for number, _, _ in _differing(log, turned, waits)), None)


def _differing(log, turned, waits):
    """As :func:`differing`, with the other answer for those in ``turned``.

    ``waits`` gets, of each command that either could be, how long the state had waited [ns].
    """
    answers, ahead = Answers(), real_time()
    states = {answers.codec.line(name).state_id: name for name in HAND}
    commands = {answers.codec.line(name).command_id: name for name in HAND}
    first = next(instant(one) for one in log if one.arbitration_id in commands)
    for before in (1_000_000_000, 1_000_000):  # the C node ran long before the hand did
        answers.node.on_tick(first - before)
    for number, frame in enumerate(log):
        if frame.arbitration_id in states:
            answers.waiting[states[frame.arbitration_id]].append(frame)
        elif frame.arbitration_id in commands:
            name, now = commands[frame.arbitration_id], instant(frame)
            by_frame = False
            if answers.waiting[name]:
                waits[number] = now + ahead - round(answers.waiting[name][0].timestamp * 1e9)
                by_frame = (waits[number] >= 0) != (number in turned)
            wanted = (answers.by_frame if by_frame else answers.by_clock)(name, now)
            if wanted != bytes(frame.data):
                yield number, bytes(frame.data), wanted


@pytest.mark.parametrize("name", HAND)
def test_the_exported_node_holds_the_grasp_of_the_hand(episode, name):
    states = of(episode.log[: episode.silent], FingertipState, name)[-20:]
    assert all(state.normal_force > 0.3 for state in states)
    assert not any(state.slip for state in states)
    commands = of(episode.log[: episode.silent], ForceCommand, name)[-20:]
    assert all(0.3 <= command.normal_force <= 15.0 for command in commands)
    assert {command.reason for command in commands} - FAULTS


def test_every_command_is_the_one_of_the_python_node_to_the_bit(episode):
    identifiers = {command_id(name) for name in HAND}
    commands = [one for one in episode.log if one.arbitration_id in identifiers]
    assert len(commands) >= (HELD + SILENT + AGAIN) * len(HAND)
    assert differing(episode.log) == []


def test_a_command_at_another_instant_differs(episode):
    log = list(episode.log)
    number = next(
        i for i in range(episode.silent // 2, len(log)) if log[i].arbitration_id == command_id("index")
    )
    data = bytearray(log[number].data)
    data[12] ^= 1
    log[number] = can.Message(arbitration_id=log[number].arbitration_id, data=data, is_fd=True)
    assert [found[0] for found in differing(log)] == [number]


@pytest.mark.parametrize("name", HAND)
def test_silent_sensors_let_the_command_stand_and_then_ramp_to_the_fail_safe_force(episode, name):
    commands = of(episode.log[episode.silent : episode.again], ForceCommand, name)
    forces = [command.normal_force for command in commands]
    assert forces == sorted(forces)
    assert {command.reason for command in commands[-5:]} <= FAULTS
    assert forces[-1] >= REQUEST.control.fail_safe.force - 1e-6


@pytest.mark.parametrize("name", HAND)
def test_the_grip_is_controlled_again_when_the_sensors_come_back(episode, name):
    commands = of(episode.log[episode.again :], ForceCommand, name)
    assert {command.reason for command in commands[:5]} <= FAULTS, "some sound states come first"
    assert {command.reason for command in commands} - FAULTS


def test_sigterm_ends_the_node_which_tells_what_it_did(episode):
    assert episode.code == 0
    for name in HAND:
        assert f"{len(of(episode.log, ForceCommand, name))} commands" in line_of(episode.told, name)
        assert "0 lost" in line_of(episode.told, name)
    assert "0 commands not sent, bus lost 0 times" in episode.told


def line_of(text, name):
    return next(line for line in text.splitlines() if line.startswith(f"{name}:"))


@pytest.fixture
def spare(links):
    """An interface of this test alone."""
    links.add("vcan7")
    yield "vcan7"
    if "vcan7" in {name for _, name in links.socket.if_nameindex()}:
        links.remove("vcan7")


def spoil_nothing_is_there(links, name):
    links.remove(name)


def spoil_down(links, name):
    links.set_down(name)


def spoil_classic(links, name):
    links.remove(name)
    links.add(name, links.CLASSIC_MTU)


@pytest.mark.parametrize(
    ("spoil", "remedy"),
    [(spoil_nothing_is_there, "no such interface"), (spoil_down, "set vcan7 up"), (spoil_classic, "mtu 72")],
    ids=["missing", "down", "classic only"],
)
def test_an_interface_that_cannot_serve_is_refused_with_the_remedy(program, links, spare, spoil, remedy):
    spoil(links, spare)
    done = subprocess.run([program, spare], capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 4
    assert remedy in done.stderr
    assert done.stderr.count("\n") == 1


def answered(bus, sender, number):
    """Send states until a command comes; return the number of the next."""
    deadline = time.monotonic() + 60.0
    while time.monotonic() < deadline:
        state = FingertipState(time.monotonic_ns(), "thumb", number, normal_force=1.0)
        number += 1
        for frame in sender.encode(state):
            bus.send(
                can.Message(
                    arbitration_id=frame.arbitration_id, data=frame.data, is_fd=True, is_extended_id=False
                )
            )
        if bus.recv(0.05) is not None:
            return number
    raise AssertionError("no command came")


def test_a_lowered_interface_is_used_again_and_a_removed_one_ends_the_node(program, links, spare):
    node = subprocess.Popen([program, spare], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        with can.Bus(interface="socketcan", channel=spare, fd=True) as bus:
            number = answered(bus, codec(), 0)
        links.set_down(spare)
        links.set_up(spare)
        with can.Bus(interface="socketcan", channel=spare, fd=True) as bus:
            answered(bus, codec(), number)
        links.remove(spare)
        told, why = node.communicate(timeout=60)
    finally:
        node.kill()
    assert node.returncode == 4
    assert "removed" in why
    assert "bus lost" in told
