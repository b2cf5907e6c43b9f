"""The exported node in C and the virtual hand, each a process, over the bus of the kernel; the test watches.

The C node keeps a journal of all that its fingers are given. The objects of the node in Python are given the
same, at the same times; what they answer is compared with what was on the bus.
"""

import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from dataclasses import dataclass, replace
from functools import cache

import can
import pytest

from vegrip.c99 import host
from vegrip.estimator import ContactEstimator
from vegrip.export import texts
from vegrip.export.precision import Request
from vegrip.grip.node import GraspForce
from vegrip.grip.safety import WatchdogSettings
from vegrip.grip.settings import ControlSettings
from vegrip.messages import USUAL_FINGERS, FingertipState, ForceCommand, Reason
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
CONTROL = ControlSettings(watchdog=WatchdogSettings(time_out=0.5))  # [s]; an emulated kernel may be late
REQUEST = Request(paper_model(9e-3, modulus=3e5), frames=20, entry="finger", control=CONTROL)
PATIENCE = 180.0  # [s]
STARTING = 420.0  # [s] for a hand that is compiled first, by an emulated kernel
FAULTS = {Reason.INPUT_HOLD, Reason.FAIL_SAFE}
RECOVERY = CONTROL.watchdog.recover_after  # sound states
HELD, SILENT, AGAIN = 60, 60, 20  # commands of every finger: in the grip, without states, with states again
SECOND = 1_000_000_000  # [ns]
SO_RCVBUFFORCE = 33  # of Linux; the module socket does not name it


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    """The exported node, compiled as a user compiles it."""
    if host.compiler() is None:
        pytest.skip("no C compiler")
    folder = tmp_path_factory.mktemp("firmware")
    for name, text in texts.write(REQUEST).files.items():
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
    journal: list[str]  # what the fingers were given


@pytest.fixture(scope="module")
def episode(program, tmp_path_factory):
    """A grip is held; the sensors go silent; they come again; the node is told to end."""
    folder = tmp_path_factory.mktemp("launch")
    before = os.environ.get("VEGRIP_RUNTIME_DIR")
    os.environ["VEGRIP_RUNTIME_DIR"] = str(folder / "run")
    (folder / "hand.toml").write_text(LAUNCH)
    with can.Bus(interface="socketcan", channel="vcan0", fd=True) as bus:
        bus.socket.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, 1 << 24)
        node = subprocess.Popen(
            [program, "vcan0", "0", folder / "journal"], stdout=subprocess.PIPE, text=True
        )
        launcher = subprocess.Popen([sys.executable, "-m", "vegrip", "launch", folder / "hand.toml"])
        try:
            log: list[can.Message] = []
            listen(bus, log, HELD, STARTING)
            wait_until_controlled(bus, log, 0)
            (hand,) = [one.pid for one in running_nodes() if one.name == "/virtual_hand"]
            os.kill(hand, signal.SIGSTOP)
            silent = listen(bus, log, SILENT)
            os.kill(hand, signal.SIGCONT)
            again = listen(bus, log, AGAIN)
            wait_until_controlled(bus, log, again)
            node.terminate()
            told, _ = node.communicate(timeout=60)
            listen(bus, log, 0)
        finally:
            launcher.send_signal(signal.SIGINT)
            launcher.wait(60)
            node.kill()
            os.environ.pop("VEGRIP_RUNTIME_DIR")
            os.environ |= {"VEGRIP_RUNTIME_DIR": before} if before else {}
    return Episode(log, silent, again, node.returncode, told, (folder / "journal").read_text().splitlines())


def listen(bus, log, commands, patience=PATIENCE):
    """Keep frames until so many more commands of every finger came; return the number of the first frame."""
    start, wanted = len(log), {command_id(name): commands for name in USUAL_FINGERS}
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
    return CanCodec(USUAL_FINGERS, fd=True, use_sender_time=True)


@cache
def command_id(name):
    return codec().line(name).command_id


def of(frames, cls, name):
    """Decode those of a finger, as one who only listens."""
    line, listener = codec().line(name), codec()
    identifier = line.command_id if cls is ForceCommand else line.state_id
    mine = [bytes(one.data) for one in frames if one.arbitration_id == identifier]
    return [listener.decode(Frame(identifier, data, fd=True, stamp=1)) for data in mine]


def wait_until_controlled(bus, log, start):
    """Listen on until each finger has lately had a command that is no answer to a fault."""
    deadline = time.monotonic() + PATIENCE
    while not is_controlled(log[start:][-20 * len(USUAL_FINGERS) :]) and time.monotonic() < deadline:
        listen(bus, log, 1)


def is_controlled(log):
    """Whether each finger has had a command that is no answer to a fault."""
    return all({one.reason for one in of(log, ForceCommand, name)} - FAULTS for name in USUAL_FINGERS)


def answers_of_python(journal):
    """Return what the objects of the node in Python answer to the same at the same times: identifiers, bytes.

    Before the first frame a second is enough: nothing is answered then.
    """
    control = replace(REQUEST.control, report_period=0.0, health_period=0.0)
    settings = REQUEST.estimator
    wire = codec()
    node = GraspForce(
        "n", USUAL_FINGERS, lambda _: ContactEstimator(REQUEST.model, REQUEST.noise, settings), control
    )
    node.configure()
    node.activate()
    given = [line.split() for line in journal]
    begin = next(int(time) for kind, _, time, *_ in filter(is_frame, given)) - SECOND
    answers = []
    for line in given:
        now = int(line[2] if is_frame(line) else line[1])
        if is_frame(line):
            state = Frame(wire.line(line[1]).state_id, bytes.fromhex(line[3]), fd=True, stamp=now)
            message = wire.decode(state)
            assert message is not None
            answers += node.on_message(message, now)
        elif now >= begin:
            answers += node.on_tick(now)
    commands = [wire.encode(one)[0] for one in answers if isinstance(one, ForceCommand)]
    return [(one.arbitration_id, bytes(one.data)) for one in commands]


def is_frame(line):
    return line[0] == "frame"


@pytest.mark.parametrize("name", USUAL_FINGERS)
def test_the_exported_node_holds_the_grasp_of_the_hand(episode, name):
    states = of(episode.log[: episode.silent], FingertipState, name)[-20:]
    assert all(state.normal_force > 0.3 for state in states)
    assert not any(state.slip for state in states)
    commands = of(episode.log[: episode.silent], ForceCommand, name)[-20:]
    assert all(0.3 <= command.normal_force <= 15.0 for command in commands)
    assert {command.reason for command in commands} - FAULTS


def test_every_command_is_the_one_of_the_python_node_to_the_bit(episode):
    identifiers = {command_id(name) for name in USUAL_FINGERS}
    commands = [
        (one.arbitration_id, bytes(one.data)) for one in episode.log if one.arbitration_id in identifiers
    ]
    assert len(commands) >= (HELD + SILENT + AGAIN) * len(USUAL_FINGERS)
    assert answers_of_python(episode.journal) == commands


def test_a_frame_that_is_given_a_microsecond_later_is_answered_otherwise(episode):
    journal = list(episode.journal)
    number = [i for i, line in enumerate(journal) if is_frame(line.split())][-1]
    kind, finger, instant, data = journal[number].split()
    journal[number] = f"{kind} {finger} {int(instant) + 1000} {data}"
    same, other = answers_of_python(episode.journal), answers_of_python(journal)
    assert [one for one, two in zip(same, other, strict=True) if one != two]


@pytest.mark.parametrize("name", USUAL_FINGERS)
def test_silent_sensors_let_the_command_stand_and_then_ramp_to_the_fail_safe_force(episode, name):
    commands = of(episode.log[episode.silent : episode.again], ForceCommand, name)
    forces = [command.normal_force for command in commands]
    assert forces == sorted(forces)
    assert {command.reason for command in commands[-5:]} <= FAULTS
    assert forces[-1] >= REQUEST.control.fail_safe.force - 1e-6


@pytest.mark.parametrize("name", USUAL_FINGERS)
def test_the_grip_is_controlled_again_when_the_sensors_come_back(episode, name):
    """After so many sound states, and no earlier; how many commands the clock renews before is chance."""
    frames = episode.log[episode.again :]
    states = commands = 0  # that have come
    reasons = [command.reason for command in of(frames, ForceCommand, name)]
    for frame in frames:
        if frame.arbitration_id == codec().line(name).state_id:
            states += 1
        elif frame.arbitration_id == command_id(name):
            is_controlled_yet = reasons[commands] not in FAULTS
            assert states >= RECOVERY or not is_controlled_yet, f"after {states} states, {reasons}"
            commands += 1
    assert set(reasons[: RECOVERY - 1]) <= FAULTS
    assert set(reasons) - FAULTS


def test_sigterm_ends_the_node_which_tells_what_it_did(episode):
    assert episode.code == 0
    for name in USUAL_FINGERS:
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
