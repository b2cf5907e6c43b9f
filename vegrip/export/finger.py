"""The exported finger: frames of states in, frames of commands out."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vegrip.c99 import literals
from vegrip.clock import NS
from vegrip.config import constants, declaration
from vegrip.estimator import ContactEstimator
from vegrip.estimator.estimator import quantile
from vegrip.estimator.layout import layout_of
from vegrip.export.estimator import STEP, simulated
from vegrip.export.precision import PRECISIONS, Request, Unit
from vegrip.grip.compiled import finger_places, finger_text
from vegrip.grip.finger import RENEWAL, GraspFinger
from vegrip.grip.finger_step import Place
from vegrip.grip.grasp_memory import GraspMemory
from vegrip.grip.layout import RULES, FingerLayout
from vegrip.grip.node import GraspForce
from vegrip.grip.settings import ControlSettings
from vegrip.grip.wires import COMMAND_BYTES, ENTRIES
from vegrip.messages import Condition, ForceCommand
from vegrip.transport.codec import CanCodec, Frame
from vegrip.transport.codec.database import database, layouts
from vegrip.transport.codec.kernel_text import STATE

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
    control = replace(request.control, report_period=0.0, health_period=0.0)
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
    control, names = request.control, request.fingers
    thumb = names.index(control.thumb) if control.thumb in names else -1
    line = CanCodec(names, fd=True, use_sender_time=True).line(names[0])
    assert line is not None  # noqa: S101
    one = GraspFinger(
        names[0],
        _estimators(request)(names[0]),
        control,
        Place(0, len(names), thumb),
        GraspMemory(len(names)),
        line=line,
        mode=mode,
        alone=True,
    )
    one.take_line()
    return one


def _estimators(request: Request) -> Callable[[str], ContactEstimator]:
    return lambda _: ContactEstimator(request.model, request.noise, request.estimator)


def _memory(one: GraspFinger, meetings: tuple[Meeting, ...]) -> NDArray[np.float64]:
    module, f, t = one.numbers.module, one.memory.f, one.memory.t
    needs, frame = np.full(one.memory["SETUP_FINGERS"], np.nan), np.zeros(64, dtype=np.uint8)
    for meeting in meetings:
        if meeting.data:
            frame[: len(meeting.data)] = np.frombuffer(meeting.data, dtype=np.uint8)
            length = len(meeting.data)
            module.finger_receive(
                f, t, needs, frame, length, meeting.arrival, meeting.now, one.numbers.answer_frame
            )
        else:
            module.finger_tick(f, t, needs, meeting.now, one.numbers.answer_frame)
    return f.copy()


FIXED = ("LIFETIME",)
"""Settings that others follow from; they are those of the export."""


def unit(request: Request) -> Unit:
    """Return what is exported."""
    model, p, precision = request.model, request.prefix, PRECISIONS[request.precision]
    vectors = record(request)
    memory, settings = vectors.blank.memory, tuple(settable())
    finger = FingerLayout(layout_of(model))
    entries = {name: ENTRIES[name] for name in ("finger_receive", "finger_tick")}
    words = {
        "state_bytes": str(_state_bytes()), "command_bytes": str(COMMAND_BYTES),
        "command": f"    uint8_t command[{p.upper()}_COMMAND_BYTES]; /* the last command, as it is sent */\n",
        "finger_allowed": _allowed(request), "fingers": str(len(request.fingers)),
        "names": ", ".join(request.fingers),
        "quoted_names": ", ".join(f'"{name}"' for name in request.fingers),
        "hands": str(layouts().hands), "hand_stride": str(layouts().hand_stride),
        "finger_stride": str(layouts().finger_stride), "wire_version": str(layouts().version),
        "settings": "\n".join(f"    {p.upper()}_{one.name}, /* {one.words} */" for one in settings),
        "setting_places": ", ".join(str(finger.reals[f"RULE_{one.name}"]) for one in settings),
        "setting_lowest": ", ".join(literals.real(one.low, precision.reals) for one in settings),
        "setting_highest": ", ".join(literals.real(one.high, precision.reals) for one in settings),
        "conditions": "\n".join(f"    {p.upper()}_{one.name} = {one.value}," for one in Condition),
        "believed": f"e->t.named.input.condition <= {int(Condition.DEGRADED)}",
        "row": "meeting", "ROW": "MEETING", "meetings": str(len(vectors.meetings)),
        "frames": str(sum(bool(meeting.data) for meeting in vectors.meetings)),
        "rows": "\n".join(_row(meeting) for meeting in vectors.meetings),
        "worst_sources": f"{p}_worst.c {p}_vectors.c",
    }  # fmt: skip
    text = finger_text(model.effects, finger, request.settings.surface == "ellipse")
    return Unit(text, finger_places(model), entries, memory, vectors.reals, words, COMMAND_BYTES)


def _allowed(request: Request) -> str:
    """Return by how much a force may be off: relative in double precision, in [N] in single."""
    if request.precision == "double":
        return "1e-5"
    control = request.control
    return literals.real(2.0 * control.fail_safe.ramp_rate * RENEWAL * control.limits.lifetime)


def _state_bytes() -> int:
    return int(database().get_message_by_name(STATE).length)


@dataclass(frozen=True)
class Setting:
    """A setting of an exported finger, a ``parameter`` of the control in units of 1 / ``scale``."""

    name: str
    parameter: str
    scale: int
    low: float
    high: float
    words: str


def settable() -> Iterator[Setting]:
    """Yield what can be set."""
    for name, (section, key, scale) in RULES.items():
        group = getattr(ControlSettings(), section)
        if name in FIXED or key in constants(group):
            continue
        declared = declaration(group, key)
        low, high, doc = declared.low * scale, declared.high * scale, declared.doc
        unit = "ns" if scale == NS else "-" if declared.unit == "1" else declared.unit
        if name == "QUANTILE":
            low, high = quantile(low), quantile(high)
            doc = f"standard normal, of the probability: {doc}"
        yield Setting(name, f"{section}.{key}", scale, low, high, f"[{unit}] {low:.6g} .. {high:.6g}, {doc}")


def _row(meeting: Meeting) -> str:
    data = ", ".join(map(str, meeting.data)) or "0"
    command = ", ".join(map(str, meeting.command)) or "0"
    sizes = f"{len(meeting.data)}, {len(meeting.command)}, {meeting.condition}"
    head = f"{meeting.arrival}LL, {meeting.now}LL, {sizes}"
    return f"    {{{head},\n     {{{data}}},\n     {{{command}}}}},"
