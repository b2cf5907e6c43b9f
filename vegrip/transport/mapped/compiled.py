"""The hot part of decoding as generated Python: one function for each message, one for each finger.

Shifts, masks, scales and sums stand in the text as numbers, and nothing of the files of others but numbers
goes into it. A message of eight signals is read so in 0.4 us; cantools' decoder, with the copy of its
dictionary, takes 1.6, and a foreign state would be decoded 1.7 times as slowly as one of our own layout.
"""

import bisect
import math
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from vegrip.messages import FingertipState, make_row
from vegrip.transport.mapped.plan import UNITY, VECTORS, ChannelPlan, FingerPlan, Slot
from vegrip.transport.maps.schema import POLAR, REPORTED
from vegrip.transport.maps.signals import ForeignMessage, Signal

Slots = list[float]
Read = Callable[[bytes, Slots], tuple[int, ...]]
"""Fills the slots from a frame; returns which groups of signals were in it."""
Build = Callable[[Slots, int, str, int], FingertipState]
"""Makes a state of the slots, its stamp, its finger and its number."""

ORDER: Final = tuple(FingertipState.__dataclass_fields__)[3:]
_UNPACKED: Final = {  # what unpacks whole bytes
    f"{order}{code}": struct.Struct(sign + code).unpack_from
    for order, sign in (("little_", "<"), ("big_", ">"))
    for code in "bBhHiIqQefd"
}
_CODES: Final = {8: "b", 16: "h", 32: "i", 64: "q"}
_FLOATS: Final = {16: "e", 32: "f", 64: "d"}


@dataclass(frozen=True, slots=True)
class Group:
    """Signals that come together: all of a message, or those of one value of a multiplexer."""

    condition: tuple[tuple[str, Sequence[int]], ...]
    slots: tuple[Slot, ...]


def groups_of(message: ForeignMessage, slots: Sequence[Slot]) -> list[Group]:
    """Return the ``slots`` of ``message`` by the multiplexers that select them."""
    found: dict[tuple[tuple[str, Sequence[int]], ...], list[Slot]] = {}
    for slot in slots:
        found.setdefault(_condition(message, slot.place), []).append(slot)
    return [Group(condition, tuple(members)) for condition, members in found.items()]


def compile_reader(message: ForeignMessage, groups: Sequence[Group], first: int) -> Read:
    """Return the reader of ``message``; its groups are numbered from ``first``."""
    lines = reading(message, groups, first)
    read: Read = made(["def read(data, s):", *lines, " return found"], "read", {})
    return read


def reading(message: ForeignMessage, groups: Sequence[Group], first: int) -> list[str]:
    """Return the lines that fill the slots ``s`` from ``data``, and set ``found`` to the groups it holds."""
    switches = dict.fromkeys(name for group in groups for name, _ in group.condition)
    names = {switch: f"m{number}" for number, switch in enumerate(switches)}
    lines = [f" {own} = {_raw(message.signals[switch], message.length)}" for switch, own in names.items()]
    always = tuple(number for number, group in enumerate(groups, first) if not group.condition)
    lines.append(f" found = {always!r}")
    for number, group in enumerate(groups, first):
        indent = " "
        if group.condition:
            tests = " and ".join(f"{names[name]} in {values!r}" for name, values in group.condition)
            lines += [f" if {tests}:", f"  found += ({number},)"]
            indent = "  "
        lines += [indent + line for slot in group.slots for line in _assignment(slot, message.length)]
    return [*_words("".join(lines)), *lines]


def compile_raw(message: ForeignMessage, signal: Signal) -> Callable[[bytes], int]:
    """Return the function that reads the raw value of ``signal``."""
    lines = ["def raw(data):", *raw_reading(message, signal), " return raw"]
    raw: Callable[[bytes], int] = made(lines, "raw", {})
    return raw


def raw_reading(message: ForeignMessage, signal: Signal) -> list[str]:
    value = _raw(signal, message.length)
    return [*_words(value), f" raw = {value}"]


def packing(message: ForeignMessage, numbers: Mapping[str, int | str]) -> str:
    """Return the text of a message of raw values, by signal, or the names of them; the rest is zero."""
    words = {False: [str(int.from_bytes(message.template, "little"))], True: ["0"]}
    for name, number in numbers.items():
        signal = message.signals[name]
        bits = f"({number} & {(1 << signal.length) - 1}) << {signal.shift(message.length)}"
        words[signal.is_big_endian].append(f"({bits})")
    little, big = (" | ".join(words[order]) for order in (False, True))
    if len(words[True]) > 1:
        little += f" | int.from_bytes(({big}).to_bytes({message.length}, 'big'), 'little')"
    return f"({little}).to_bytes({max(message.length, len(message.template))}, 'little')"


def _words(text: str) -> list[str]:
    named = {"(w ": " w = int.from_bytes(data, 'little')", "(b ": " b = int.from_bytes(data, 'big')"}
    return [line for name, line in named.items() if name in text]


def compile_builder(finger: FingerPlan) -> Build:
    """Return the function that makes a state of ``finger`` from the slots."""
    lines = ["def build(s, stamp, name, seq):"]
    scope: dict[str, Any] = {"interpolated": interpolated, "cos": _cos, "sin": _sin}
    scope |= {"row": make_row, "State": FingertipState}
    present: set[str] = set()
    for name, channel in finger.channels.items():
        if name in REPORTED:
            continue
        lines += _channel(f"c_{name}", channel, scope)
        present.add(name)
    if present >= POLAR:
        length, turn = "c_tangential_magnitude", "c_tangential_direction"
        lines += [
            f" c_tangential_force_x = {length} * cos({turn})",
            f" c_tangential_force_y = {length} * sin({turn})",
        ]
        present.update(VECTORS[0][:2])
    if finger.torque is not None:
        lines += _torque(finger)
        present.add("torque_z")
    row = {name: f"c_{name}" if name in present else "nan" for name in ORDER}
    if finger.rotation:
        row |= _rotated(finger.rotation, present)
    lines.append(f" return row(State, (stamp, name, seq, {', '.join(row[name] for name in ORDER)}))")
    build: Build = made(lines, "build", scope)
    return build


def interpolated(xs: Sequence[float], ys: Sequence[float], x: float) -> float:
    """Return the value at ``x`` on the line through the points, NaN outside: nothing is extrapolated.

    >>> interpolated((0.0, 10.0), (0.0, 0.002), 5.0)
    0.001
    """
    if not xs[0] <= x <= xs[-1]:
        return math.nan
    i = min(bisect.bisect_right(xs, x), len(xs) - 1)
    return ys[i - 1] + (ys[i] - ys[i - 1]) * (x - xs[i - 1]) / (xs[i] - xs[i - 1])


def _cos(angle: float) -> float:
    return math.cos(angle) if math.isfinite(angle) else math.nan


def _sin(angle: float) -> float:
    return math.sin(angle) if math.isfinite(angle) else math.nan


def _condition(message: ForeignMessage, signal: Signal | None) -> tuple[tuple[str, Sequence[int]], ...]:
    found: list[tuple[str, Sequence[int]]] = []
    while signal is not None and signal.selected_by:
        found.append((signal.selected_by, signal.selectors))
        signal = message.signals.get(signal.selected_by)
    return tuple(reversed(found))


def _raw(signal: Signal, length: int) -> str:
    """Return the text of the raw value of ``signal``: of whole bytes, or shifted out of the message."""
    first = 7 if signal.is_big_endian else 0
    code = (_FLOATS if signal.is_float else _CODES).get(signal.length, "")
    if code and signal.start % 8 == first:
        order = "big" if signal.is_big_endian else "little"
        code = code if signal.is_float or signal.is_signed else code.upper()
        return f"{order}_{code}(data, {signal.start // 8})[0]"
    word, shift = "b" if signal.is_big_endian else "w", signal.shift(length)
    bits = f"({word}{f' >> {shift}' if shift else ''} & {(1 << signal.length) - 1})"
    if signal.is_float:
        return f"little_{code}({bits}.to_bytes({signal.length // 8}, 'little'), 0)[0]"
    if signal.is_signed:
        sign = 1 << signal.length - 1
        return f"(({bits} ^ {sign}) - {sign})"
    return bits


def _assignment(slot: Slot, length: int) -> list[str]:
    assert slot.place is not None  # noqa: S101 (topics have no frames)
    raw = _raw(slot.place, length)
    is_missing = [f"r in {slot.invalid!r}"] if slot.invalid else []
    if slot.bounds is not None:
        is_missing.append(f"not {slot.bounds[0]!r} <= r <= {slot.bounds[1]!r}")
    value = "r" if is_missing else raw
    if slot.scale != 1.0:
        value = f"{value} * {slot.scale!r}"
    if slot.offset:
        value = f"{value} + {slot.offset!r}"
    if is_missing:
        return [f"r = {raw}", f"s[{slot.number}] = nan if {' or '.join(is_missing)} else {value}"]
    return [f"s[{slot.number}] = {value}"]


def _channel(name: str, plan: ChannelPlan, scope: dict[str, Any]) -> list[str]:
    terms = [f"s[{number}]" for number in plan.slots]
    if plan.constant or not terms:
        terms.append(repr(plan.constant))
    value = " + ".join(terms)
    if plan.table:
        scope[f"x_{name}"], scope[f"y_{name}"] = zip(*plan.table, strict=True)
        value = f"interpolated(x_{name}, y_{name}, {value})"
    lines = [f" {name} = {value}"]
    if not math.isnan(plan.above):
        lines.append(f" {name} = ({name} > {plan.above!r}) + 0.0 if {name} == {name} else nan")
    return lines


def _torque(finger: FingerPlan) -> list[str]:
    """About the centre of pressure; about the middle of the array where nothing presses."""
    plan = finger.torque
    assert plan is not None  # noqa: S101 (looked at by the caller)
    places = list(zip(plan.normal, plan.positions, strict=True))
    centre_x = " + ".join(f"s[{slot}] * {x!r}" for slot, (x, _) in places)
    centre_y = " + ".join(f"s[{slot}] * {y!r}" for slot, (_, y) in places)
    moment = " + ".join(
        f"{x!r} * s[{fy}] - {y!r} * s[{fx}]"
        for fx, fy, (x, y) in zip(plan.x, plan.y, plan.positions, strict=True)
    )
    return [
        f" p = {' + '.join(f's[{slot}]' for slot in plan.normal)}",
        f" x = ({centre_x}) / p if p > 0.0 else 0.0",
        f" y = ({centre_y}) / p if p > 0.0 else 0.0",
        f" c_torque_z = {moment} - x * c_tangential_force_y + y * c_tangential_force_x",
    ]


def _rotated(rotation: tuple[tuple[float, ...], ...], present: set[str]) -> Mapping[str, str]:
    """Return the text of the turned components; one that needs what is not there is missing."""
    turned: dict[str, str] = {}
    for vector in VECTORS:
        for name, row in zip(vector, rotation, strict=True):
            parts = [
                (weight, other) for other, weight in zip(vector, row, strict=True) if abs(weight) > UNITY
            ]
            known = all(other in present for _, other in parts)
            turned[name] = " + ".join(f"{w!r} * c_{other}" for w, other in parts) if known else "nan"
    return turned


def made(lines: list[str], name: str, scope: dict[str, Any]) -> Any:
    """Return the function ``name`` of a text that holds nothing but numbers and names of ours."""
    scope |= {"nan": math.nan, "inf": math.inf, **_UNPACKED}
    exec(compile("\n".join(lines), "<map>", "exec"), scope)  # noqa: S102 - numbers and names of ours only
    return scope[name]
