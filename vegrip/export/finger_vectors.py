"""Recorded frames and ticks of one finger, and what the node answers: the self-test of an export."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vegrip.estimator import ContactEstimator
from vegrip.export.precision import Request
from vegrip.export.vectors import STEP, simulated
from vegrip.grip.controller import GripController
from vegrip.grip.finger import GraspFinger
from vegrip.grip.node import GraspForce
from vegrip.messages import ForceCommand
from vegrip.transport.codec import CanCodec, Frame

START_NS = 10_000_000_000  # [ns] of the first frame
LATENCY_NS = 300_000  # [ns] from a state to its arrival
ANSWER_NS = 20_000  # [ns] from an arrival to its answer
TICK_NS = 25_000_000  # [ns] between ticks where nothing comes
BROKEN_EVERY = 41  # of so many frames one has a bit that is wrong


@dataclass(frozen=True)
class Meeting:
    """A frame that comes, or a tick where ``data`` is empty; the command that answers it, if any."""

    arrival: int  # [ns]
    now: int  # [ns]
    data: bytes
    command: bytes
    condition: int


@dataclass(frozen=True)
class FingerVectors:
    """What one finger meets, and its memory at the end."""

    meetings: tuple[Meeting, ...]
    reals: NDArray[np.float64]
    blank: GraspFinger


def record(request: Request) -> FingerVectors:
    """Run the model's own simulation through the node; the same bytes every time."""
    control = replace(request.alone, report_period=0.0, health_period=0.0)
    node = GraspForce("finger", request.fingers, _estimators(request), control)
    node.configure()
    node.activate()
    codec = CanCodec(request.fingers, fd=True, use_sender_time=True)
    meetings = tuple(_meetings(node, codec, request))
    return FingerVectors(meetings, _memory(alone(request), meetings), alone(request))


def _meetings(node: GraspForce, codec: CanCodec, request: Request) -> Iterator[Meeting]:
    name, last = request.fingers[0], START_NS
    for number, frame in enumerate(_frames(request)):
        while frame.stamp - last > TICK_NS:
            last += TICK_NS
            yield _answered(node, codec, Meeting(last, last, b"", b"", 0), name)
        last = frame.stamp
        data = bytearray(frame.data)
        data[17] ^= 4 if number % BROKEN_EVERY == BROKEN_EVERY - 1 else 0
        yield _answered(node, codec, Meeting(frame.stamp, frame.stamp + ANSWER_NS, bytes(data), b"", 0), name)


def _frames(request: Request) -> Iterator[Frame]:
    """Yield the states as frames; they arrive in the order of time, whatever the sender's clock says."""
    sender = CanCodec(request.fingers, fd=True)
    arrival = START_NS
    for state in simulated(request):
        stamped = replace(state, finger=request.fingers[0], stamp=state.stamp + START_NS)
        arrival = max(arrival + round(STEP * 1e8), stamped.stamp + LATENCY_NS)
        for frame in sender.encode(stamped):
            yield frame._replace(stamp=arrival)


def _answered(node: GraspForce, codec: CanCodec, meeting: Meeting, name: str) -> Meeting:
    line = codec.line(name)
    assert line is not None  # noqa: S101
    if meeting.data:
        broken = codec.broken[name]
        message = codec.decode(Frame(line.state_id, meeting.data, fd=True, stamp=meeting.arrival))
        answers = list(node.on_message(message, meeting.now)) if message is not None else []
        if codec.broken[name] != broken:
            node.on_broken(name, meeting.now)
    else:
        answers = list(node.on_tick(meeting.now))
    commands = [one for one in answers if isinstance(one, ForceCommand) and one.finger == name]
    data = codec.encode(commands[0])[0].data if commands else b""
    return replace(meeting, command=data, condition=int(node.fingers[name].condition))


def alone(request: Request, mode: str = "python") -> GraspFinger:
    """Return a finger as firmware has it, before its first frame; ``mode`` says what runs its step."""
    control, names = request.alone, request.fingers
    make = _estimators(request)
    hand = GripController(names, settings=control, make_estimator=make)
    line = CanCodec(names, fd=True, use_sender_time=True).line(names[0])
    assert line is not None  # noqa: S101
    needs = np.full(len(names), np.nan)
    one = GraspFinger(
        names[0], make(names[0]), control, hand.place_of(names[0]), needs, line=line, mode=mode, alone=True
    )
    one.apply(control, hand.wanted)
    one.take_line()
    return one


def _estimators(request: Request) -> Callable[[str], ContactEstimator]:
    settings = replace(request.settings, late=0)  # firmware takes samples in the order of time
    return lambda _: ContactEstimator(request.model, request.noise, settings)


def _memory(one: GraspFinger, meetings: tuple[Meeting, ...]) -> NDArray[np.float64]:
    """Return the real numbers after all, worked out by plain Python."""
    module, f, t = one.module, one.memory.f, one.memory.t
    needs, frame = np.full(one.memory["SETUP_FINGERS"], np.nan), np.zeros(64, dtype=np.uint8)
    for meeting in meetings:
        if meeting.data:
            frame[: len(meeting.data)] = np.frombuffer(meeting.data, dtype=np.uint8)
            length = len(meeting.data)
            module.finger_receive(f, t, needs, frame, length, meeting.arrival, meeting.now, one.answer_frame)
        else:
            module.finger_tick(f, t, needs, meeting.now, one.answer_frame)
    return f.copy()
