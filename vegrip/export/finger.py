"""The exported finger: frames of states in, frames of commands out."""

from collections.abc import Iterator
from dataclasses import dataclass

from vegrip.c99 import literals
from vegrip.clock import NS
from vegrip.config import declaration
from vegrip.estimator.estimator import quantile
from vegrip.estimator.layout import layout_of
from vegrip.export.finger_vectors import Meeting, record
from vegrip.export.precision import PRECISIONS, Request, Unit
from vegrip.grip.compiled import finger_places, finger_text
from vegrip.grip.finger import RENEWAL
from vegrip.grip.joint_confidence import FINGER_CORRELATION, each_confidence
from vegrip.grip.layout import RULES, FingerLayout
from vegrip.grip.settings import ControlSettings
from vegrip.grip.wires import COMMAND_BYTES, ENTRIES
from vegrip.messages import Condition
from vegrip.transport.codec.database import database, layouts
from vegrip.transport.codec.kernel_text import STATE

FIXED = ("LIFETIME",)
"""Settings that others follow from; they are those of the export."""


def unit(request: Request) -> Unit:
    """Return what is exported."""
    model, p, precision = request.model, request.prefix, PRECISIONS[request.precision]
    vectors = record(request)
    memory, settings = vectors.blank.memory, tuple(settable(len(request.fingers)))
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


def settable(fingers: int) -> Iterator[Setting]:
    """Yield what can be set, for a grasp of so many ``fingers``."""
    for name, (section, key, scale) in RULES.items():
        if name in FIXED:
            continue
        declared = declaration(getattr(ControlSettings(), section), key)
        low, high, doc = declared.low * scale, declared.high * scale, declared.doc
        unit = "ns" if scale == NS else "-" if declared.unit == "1" else declared.unit
        if name == "QUANTILE":  # as GripController.wanted, where friction is not shared
            low, high = (quantile(each_confidence(one, fingers, FINGER_CORRELATION)) for one in (low, high))
            doc = f"standard normal, of each finger's probability: {doc}"
        yield Setting(name, f"{section}.{key}", scale, low, high, f"[{unit}] {low:.6g} .. {high:.6g}, {doc}")


def _row(meeting: Meeting) -> str:
    data = ", ".join(map(str, meeting.data)) or "0"
    command = ", ".join(map(str, meeting.command)) or "0"
    sizes = f"{len(meeting.data)}, {len(meeting.command)}, {meeting.condition}"
    head = f"{meeting.arrival}LL, {meeting.now}LL, {sizes}"
    return f"    {{{head},\n     {{{data}}},\n     {{{command}}}}},"
