"""The files of an exported finger: frames of states in, frames of commands out."""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vegrip.c99 import literals, translate
from vegrip.clock import NS
from vegrip.config import declaration
from vegrip.estimator.compiled import text_of
from vegrip.estimator.estimator import quantile
from vegrip.estimator.layout import REPORT, layout_of
from vegrip.export import frameworks
from vegrip.export.finger_vectors import FingerVectors, Meeting
from vegrip.export.precision import PRECISIONS
from vegrip.export.request import Request
from vegrip.export.saved import NUMBER_DIGITS, text_number
from vegrip.export.texts import NAMES, ONLY_TOUCHING, Texts, filled, saved_text, saving_words
from vegrip.grip.batch_text import COMMAND_BYTES
from vegrip.grip.compiled import finger_places, finger_text
from vegrip.grip.finger import RENEWAL
from vegrip.grip.joint_confidence import FINGER_CORRELATION, each_confidence
from vegrip.grip.layout import REALS, FingerLayout
from vegrip.grip.settings import ControlSettings
from vegrip.grip.wires import ENTRIES
from vegrip.messages import Condition
from vegrip.model.file import model_text
from vegrip.transport.codec.database import database, layouts
from vegrip.transport.codec.kernel_text import STATE

FILES = {
    "finger.h": "{p}_finger.h", "finger.c": "{p}_finger.c", "finger_vectors.h": "{p}_vectors.h",
    "finger_vectors.c": "{p}_vectors.c", "finger_selftest.c": "{p}_selftest.c", "Makefile": "Makefile",
    "counting.h": "{p}_counting.h", "finger_worst.c": "{p}_worst.c",
    "CMakeLists.txt": "CMakeLists.txt", "finger_bare_metal.c": "examples/bare_metal.c",
    "finger_linux.c": "examples/linux.c",
    "startup.c": "{core}/startup.c", "link.ld": "{core}/link.ld", **frameworks.FINGER,
}  # fmt: skip
FIXED = ("LIFETIME",)
"""Settings that others follow from; they are those of the export."""
PARAMETERS = {
    "WANTED_MARGIN": "grip", "QUANTILE": "grip.probability", "DEAD_BAND": "grip", "RELEASE_TIME": "grip",
    "SETTLE_TIME": "grip", "USUAL_TIME": "grip", "SLIP_GROWTH": "grip", "PROVEN_TIME": "grip",
    "MIN_FORCE": "limits", "MAX_FORCE": "limits", "RAISE_RATE": "limits", "LOWER_RATE": "limits",
    "SAFE_FORCE": "fail_safe.force", "HOLD_TIME": "fail_safe", "RAMP_RATE": "fail_safe",
    "TIME_OUT": "watchdog", "FROZEN_AFTER": "watchdog", "FORCE_FROZEN_AFTER": "watchdog",
    "DOUBT_AFTER": "watchdog", "FROZEN_CHANCE": "watchdog", "STUCK_TRAVEL": "watchdog",
}  # fmt: skip
"""Setting -> section of the control's parameters, and the name there if it is another one."""
ONE_LINE = 6  # numbers


def write(request: Request, vectors: FingerVectors) -> Texts:
    """Return the files.

    Raises:
        UntranslatableError: a line of an effect or kernel has no counterpart in C.

    """
    model, p, precision = request.model, request.prefix, PRECISIONS[request.precision]
    layout = layout_of(model)
    finger = FingerLayout(layout)
    ellipse = request.settings.surface == "ellipse"
    text = finger_text(model.effects, finger, ellipse)
    origins = finger_places(model)
    entries = {name: ENTRIES[name] for name in ("finger_receive", "finger_tick")}
    program = translate(
        text,
        entries,
        prefix=f"{p}_k",
        place=origins.place,
        notes=origins.notes(),
        is_public=False,
        reals=precision.reals,
    )
    digest = hashlib.sha256(text.encode()).hexdigest()
    estimator = hashlib.sha256(text_of(model, layout, ellipse=ellipse).encode()).hexdigest()
    places = layout.places()
    report = {name: str(places["REPORT"][0] + i) for i, name in enumerate(REPORT)}
    memory, settings = vectors.blank.memory, tuple(settable(len(request.fingers)))
    known = {
        "p": p, "P": p.upper(), "entry": "finger", "hash": digest[:NUMBER_DIGITS],
        "effects": ", ".join(effect.name for effect in model.effects),
        "kernels": program.text(), "reals": str(finger.n_reals), "wholes": str(finger.n_wholes),
        "bytes": str(_ram(request, finger)), "state_bytes": str(_state_bytes()),
        "command_bytes": str(COMMAND_BYTES), "finger_allowed": _allowed(request),
        "fingers": str(len(request.fingers)), "names": ", ".join(request.fingers),
        "quoted_names": ", ".join(f'"{name}"' for name in request.fingers),
        "hands": str(layouts().hands), "hand_stride": str(layouts().hand_stride),
        "finger_stride": str(layouts().finger_stride), "version": str(layouts().version),
        "blank_reals": _table([literals.real(one, precision.reals) for one in memory.f.tolist()]),
        "blank_wholes": _table([literals.whole(one) for one in memory.t.tolist()]),
        "settings": "\n".join(f"    {p.upper()}_{one.name}, /* {one.words} */" for one in settings),
        "setting_places": ", ".join(str(finger.reals[f"RULE_{one.name}"]) for one in settings),
        "setting_lowest": ", ".join(literals.real(one.low, precision.reals) for one in settings),
        "setting_highest": ", ".join(literals.real(one.high, precision.reals) for one in settings),
        **{name: str(finger.reals[name]) for name in ("RULE_MIN_FORCE", "RULE_MAX_FORCE")},
        "conditions": "\n".join(f"    {p.upper()}_{one.name} = {one.value}," for one in Condition),
        "accessors": "\n".join(_accessor(p, name, report) for name in NAMES),
        "declared": "\n".join(f"{p}_estimate {p}_{name}(const {p}_finger *e);" for name in NAMES),
        "longest_gap": literals.real(request.settings.longest_gap),
        **{f"REP_{name}": place for name, place in report.items()},
        **finger_constants(finger), **_vectors(vectors), **precision.known,
        "worst_sources": f"{p}_worst.c {p}_vectors.c",
        **frameworks.words("finger"),
    }  # fmt: skip
    mark = text_number(estimator)
    known |= saving_words(known, mark, model, layout, precision.reals)
    files = {}
    for template, name in FILES.items():
        files[name.format(p=p, entry="finger", core=known["core"])] = filled(template, known)
    files |= frameworks.arduino_sources(p, "finger", files)
    files["examples/finger.txt"] = saved_text(mark, model, layout, vectors.reals[: layout.size])
    files["model.toml"] = model_text(model)
    return Texts(files, program, digest, _ram(request, finger))


def finger_constants(finger: FingerLayout) -> dict[str, str]:
    """Return the places that the hand-written part of the C needs."""
    names = (
        "SETUP_STATE_ID", "SETUP_COMMAND_ID", "SETUP_FINGER", "INPUT_CONDITION", "FAULTS0", "LINE_LOST",
        "SAMPLE_BEGUN", "SAMPLE_STAMP", "SAMPLE_INFORMED", "SAMPLE_IS_INFORMED", "SAMPLE_TRUSTED",
        "SAMPLE_RESUMED", "TURN_STARTED",
    )  # fmt: skip
    return {name: str(finger.wholes[name]) for name in names} | {"GRIP_HELD": str(finger.reals["GRIP_HELD"])}


def _ram(request: Request, finger: FingerLayout) -> int:
    """Return the bytes of a finger: its real numbers, its whole ones, and the command."""
    reals = PRECISIONS[request.precision].number_bytes * finger.n_reals
    return -(-reals // 8) * 8 + 8 * finger.n_wholes + COMMAND_BYTES


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
    rules = REALS["RULE"]
    assert isinstance(rules, tuple)  # noqa: S101
    for name in rules:
        if name not in FIXED:
            section, _, key = PARAMETERS[name].partition(".")
            yield _setting(name, section, key or name.lower(), fingers)


def _setting(name: str, section: str, key: str, fingers: int) -> Setting:
    declared = declaration(getattr(ControlSettings(), section), key)
    scale = NS if section == "watchdog" and declared.unit == "s" else 1
    low, high, doc = declared.low * scale, declared.high * scale, declared.doc
    unit = "ns" if scale == NS else "-" if declared.unit == "1" else declared.unit
    if name == "QUANTILE":  # as GripController.wanted, where friction is not shared
        low, high = (quantile(each_confidence(one, fingers, FINGER_CORRELATION)) for one in (low, high))
        doc = f"standard normal, of each finger's probability: {doc}"
    return Setting(name, f"{section}.{key}", scale, low, high, f"[{unit}] {low:.6g} .. {high:.6g}, {doc}")


def _accessor(p: str, name: str, report: dict[str, str]) -> str:
    value, std = NAMES[name]
    known = f"{p}_in_contact(e)" if name in ONLY_TOUCHING else "true"
    body = f"    return {p}_reported(e, {report[value]}, {report[std]}, {known});"
    return "\n".join([f"{p}_estimate {p}_{name}(const {p}_finger *e)", "{", body, "}", ""])


def _vectors(vectors: FingerVectors) -> dict[str, str]:
    return {
        "meetings": str(len(vectors.meetings)),
        "frames": str(sum(bool(meeting.data) for meeting in vectors.meetings)),
        "rows": "\n".join(_row(meeting) for meeting in vectors.meetings),
        "reals_at_end": _hexadecimal(vectors.reals),
    }


def _row(meeting: Meeting) -> str:
    data = ", ".join(map(str, meeting.data)) or "0"
    command = ", ".join(map(str, meeting.command)) or "0"
    sizes = f"{len(meeting.data)}, {len(meeting.command)}, {meeting.condition}"
    head = f"{meeting.arrival}LL, {meeting.now}LL, {sizes}"
    return f"    {{{head},\n     {{{data}}},\n     {{{command}}}}},"


def _hexadecimal(values: NDArray[np.float64]) -> str:
    return _table([literals.hexadecimal(one) for one in values.tolist()])


def _table(words: list[str]) -> str:
    lines = [words[i : i + ONE_LINE] for i in range(0, len(words), ONE_LINE)]
    return "\n".join(f"    {', '.join(line)}," for line in lines)
