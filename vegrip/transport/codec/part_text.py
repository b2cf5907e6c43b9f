"""The classic frames of states and commands as functions of the compiled finger step, written from the DBC.

As :mod:`vegrip.transport.codec.kernel_text` for FD frames. The values of all parts of a state are kept as
bytes, one behind the other, without the two bytes of each frame that hold checksum, counter and version.
"""

from collections.abc import Callable, Iterable
from functools import cache

from vegrip.errors import ConfigError
from vegrip.messages import FingertipState, ForceCommand
from vegrip.transport.codec.convert import Converter, Scaled
from vegrip.transport.codec.database import database, layouts
from vegrip.transport.codec.kernel_text import ARGUMENTS, function
from vegrip.transport.codec.layout import Layout, Part

HEAD_BYTES = 2  # checksum, counter and version
ByteAt = Callable[[int], str]
"""Number of a byte of a frame -> the expression that reads it."""
FORCE, ADJUSTMENT = "normal_force", "adjustment"


def classic_layout(kind: type) -> Layout:
    """Return how messages of ``kind`` lie in classic frames."""
    return next(one for one in layouts().layouts if not one.fd and one.schema.cls is kind)


def state_parts() -> int:
    """Return how many frames make a state at most."""
    return len(classic_layout(FingertipState).parts)


def payload_bytes() -> int:
    """Return how many bytes of values all parts of a state have."""
    return sum(part.length - HEAD_BYTES for part in classic_layout(FingertipState).parts)


@cache
def part_text() -> str:
    """Return the functions, lengths and scales; it stands below the text of the FD frames."""
    parts = classic_layout(FingertipState).parts
    command = classic_layout(ForceCommand).parts[0]
    absent = [byte for part in parts for byte in part.packer.pack(*part.absent)[HEAD_BYTES:]]
    first = parts[0]
    version = layouts().version % first.version_modulus
    return "\n".join([
        "",
        f"STATE_PARTS = {len(parts)}",
        f"PART_LENGTH = {first.length}",
        f"PART_PAYLOAD = {first.length - HEAD_BYTES}",
        f"PART_VERSION = {version}",
        f"PART_OFFSETS = np.array([{', '.join(str(part.base - first.base) for part in parts)}])",
        f"ABSENT_BYTES = np.array([{', '.join(map(str, absent))}])",
        f"SHORT_COMMAND_LENGTH = {command.length}",
        *_scale("FORCE", _scaled(command, FORCE)),
        *_scale("ADJUSTMENT", _scaled(command, ADJUSTMENT)),
        *function("counter_of_part(data)", "Counter of the sender.", f"return {_bits(first, 'counter')}"),
        *function("version_of_part(data)", "Version of the set.", f"return {_bits(first, 'version')}"),
        *function("is_last_part(data)", "Whether no further part comes.",
                  f"return {_bits(first, 'last')} == 1"),
        *function("signed_half_word(raw)", "16 bits as a number with a sign.",
                  "return raw - 65536 if raw >= 32768 else raw"),
        *function("signed_byte(raw)", "8 bits as a number with a sign.",
                  "return raw - 256 if raw >= 128 else raw"),
        *function("scaled_raw(raw, low, high, scale)", "Value of a raw number; beyond its range it is none.",
                  "return float(raw) * scale if low <= raw <= high else math.nan"),
        *function("part_means_something(data, part)", "No raw value of a part is without a meaning.",
                  *_meanings(parts), "return False"),
        *function("unpack_parts(f, t)", "Take the values of all parts, in SI units.", *_unpacked(parts)),
        *_packing(command),
    ])  # fmt: skip


def _unpacked(parts: Iterable[Part]) -> Iterable[str]:
    at = 0  # among the kept bytes
    for part in parts:
        for slot in part.slots:
            one = _scaled(part, slot.name)
            raw = _raw(part, slot.name, _kept_behind(at))
            yield f"f[STATE_{slot.name.upper()}] = scaled_raw({raw}, {one.low}, {one.high}, {one.scale!r})"
        at += part.length - HEAD_BYTES


def _kept_behind(start: int) -> ByteAt:
    """Return where the bytes of a part are kept whose values begin at ``start``."""
    return lambda byte: f"t[PART_BYTES0 + {start + byte - HEAD_BYTES}]"


def _meanings(parts: Iterable[Part]) -> Iterable[str]:
    for part in parts:
        known = [text for slot in part.slots if (text := _meaning(part, slot.name))]
        yield f"if part == {part.number}:"
        yield f"    return {' and '.join(known) or 'True'}"


def _meaning(part: Part, name: str) -> str:
    """Return the condition that a raw value means something, "" where every one does."""
    one, signal = _scaled(part, name), database().get_message_by_name(part.name).get_signal_by_name(name)
    lowest = -(1 << signal.length - 1) if signal.is_signed else 0
    every = set(range(lowest, lowest + (1 << signal.length)))
    if every <= {*range(one.low, one.high + 1), *one.special}:
        return ""
    raw = _raw(part, name, lambda byte: f"int(data[{byte}])")
    others = [f" or {raw} == {special}" for special in one.special]
    return f"({one.low} <= {raw} <= {one.high}{''.join(others)})"


def _packing(command: Part) -> list[str]:
    version = layouts().version % command.version_modulus
    head = [_shift(command, "counter", "counter"), _shift(command, "version", str(version))]
    return function(
        "pack_short_command(data, counter, force, adjustment, reason, expires)",
        "Write a command of raw values, but for its checksum.",
        "for i in range(SHORT_COMMAND_LENGTH):",
        "    data[i] = 0",
        f"data[1] = {' | '.join(head)}",
        *(_put(command, name, argument) for name, argument in ARGUMENTS.items()),
    )


def _put(command: Part, name: str, value: str) -> str:
    signal = database().get_message_by_name(command.name).get_signal_by_name(name)
    at = signal.start // 8
    return f"put_half_word(data, {at}, {value})" if signal.length == 16 else f"data[{at}] = {value} & 255"


def _scale(name: str, one: Scaled) -> list[str]:
    return [f"{name}_SCALE = {one.scale!r}", f"{name}_LOW = {one.low}", f"{name}_HIGH = {one.high}"]


def _scaled(part: Part, name: str) -> Scaled:
    convert: Converter = next(slot.convert for slot in part.slots if slot.name == name)
    if not isinstance(convert, Scaled):
        raise ConfigError(f"fingertip.dbc: {part.name}.{name} must be a whole number with a scale")
    return convert


def _raw(part: Part, name: str, byte_at: ByteAt) -> str:
    """Return the expression of a raw value, whole bytes with the least significant one first."""
    signal = database().get_message_by_name(part.name).get_signal_by_name(name)
    at = signal.start // 8
    if signal.start % 8 or signal.length not in (8, 16):
        raise ConfigError(f"fingertip.dbc: {part.name}.{name} must be one byte or two")
    if signal.length == 8:
        return f"signed_byte({byte_at(at)})" if signal.is_signed else byte_at(at)
    word = f"({byte_at(at)} | {byte_at(at + 1)} << 8)"
    return f"signed_half_word{word}" if signal.is_signed else word


def _bits(part: Part, name: str) -> str:
    signal = database().get_message_by_name(part.name).get_signal_by_name(name)
    return f"int(data[{signal.start // 8}]) >> {signal.start % 8} & {(1 << signal.length) - 1}"


def _shift(part: Part, name: str, value: str) -> str:
    signal = database().get_message_by_name(part.name).get_signal_by_name(name)
    if signal.start // 8 != 1:
        raise ConfigError(f"fingertip.dbc: {part.name}.{name} must stand in byte 1")
    return f"{value} << {signal.start % 8}"
