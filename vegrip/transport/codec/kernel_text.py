"""FD frames of states, commands and reports as functions of the compiled finger step, written from the DBC.

The functions are plain scalar Python over bytes, as the kernels of the control are, and stand among them in
the generated module (:mod:`vegrip.grip.compiled`). So ``fingertip.dbc`` alone says where a value stands.
"""

from functools import cache

from cantools.database.can import Message as DbcMessage
from cantools.database.can import Signal

from vegrip.transport.codec.database import database, layouts

STATE, COMMAND = "FingertipStateFd", "ForceCommandFd"
CONTACT_PARTS, MARGIN = ("ContactEstimateFd1", "ContactEstimateFd2"), "SlipMarginFd"
HEAD_SIGNALS = ("crc", "seq", "version", "time")
ARGUMENTS = {"normal_force": "force", "adjustment": "adjustment", "reason": "reason", "expires": "expires"}
"""Signal of a command -> argument of ``pack_command``; ``expires`` is given as it stands in the frame."""
AGE = "_age"
"""Ends the signals of a contact that are all of one age."""
PUT = {
    32: "put_word(data, {at}, {bits})",
    16: "put_half_word(data, {at}, {bits})",
    8: "data[{at}] = {bits} & 255",
}


@cache
def wire_text() -> str:
    """Return the functions, and the lengths and version of the frames."""
    state, command = database().get_message_by_name(STATE), database().get_message_by_name(COMMAND)
    at = {signal.name: signal.start // 8 for signal in state.signals}
    values = [signal for signal in state.signals if signal.name not in HEAD_SIGNALS]
    finite = " and ".join(f"is_not_infinite(word(data, {at[signal.name]}))" for signal in values)
    unpacked = [
        f"f[STATE_{signal.name.upper()}] = real_of_bits(word(data, {at[signal.name]}))" for signal in values
    ]
    return "\n".join([
        f"STATE_LENGTH = {state.length}",
        f"COMMAND_LENGTH = {command.length}",
        f"WIRE_VERSION = {layouts().version}",
        *function("counter_of_state(data)", "Counter of the sender.", f"return word(data, {at['seq']})"),
        *function("version_of_state(data)", "Version of the set.", f"return int(data[{at['version']}])"),
        *function("time_of_state(data)", "Time of the sender [us].", f"return word(data, {at['time']})"),
        *function("is_not_infinite(bits)", "Whether a single is a number or NaN.",
                   "return (bits & 0x7FFFFFFF) != 0x7F800000"),
        *function("values_mean_something(data)", "No value is infinite.", f"return {finite}"),
        *function("unpack_state(f, data)", "Take the values of a state, in SI units.", *unpacked),
        *_packing(command),
        *_reports(),
    ])  # fmt: skip


def _reports() -> list[str]:
    """Return the functions that pack the reports of a finger, but for the checksums; flags are 0 or 1."""
    margin = database().get_message_by_name(MARGIN)
    parts = [database().get_message_by_name(name) for name in CONTACT_PARTS]
    lines = [f"MARGIN_LENGTH = {margin.length}", f"CONTACT_LENGTH = {parts[0].length}"]
    lines += _report("pack_margin", margin, {})
    for number, part in enumerate(parts, start=1):
        last = str(int(number == len(parts)))
        ages = {signal.name: "age" for signal in part.signals if signal.name.endswith(AGE)}
        lines += _report(f"pack_contact{number}", part, {"last": last, **ages})
    return lines


def _report(name: str, message: DbcMessage, given: dict[str, str]) -> list[str]:
    """Return the function that packs a report; what is not ``given`` by signal is an argument of its name."""
    given = {"seq": "seq", "version": "WIRE_VERSION", "time": "stamp // 1000", **given}
    signals = [signal for signal in message.signals if signal.name != "crc"]
    values = {signal.name: given.get(signal.name, signal.name) for signal in signals}
    arguments = dict.fromkeys(value for value in values.values() if value.isidentifier() and value.islower())
    rest = [argument for argument in arguments if argument not in {"seq", "stamp"}]
    flags: dict[int, list[str]] = {}
    for signal in signals:
        if signal.length == 1:
            flags.setdefault(signal.start // 8, []).append(f"{values[signal.name]} << {signal.start % 8}")
    return function(
        f"{name}(data, seq, stamp, {', '.join(rest)})",
        "Write a report, but for its checksum.",
        f"for i in range({message.length}):",
        "    data[i] = 0",
        *[f"data[{at}] = {' | '.join(bits)}" for at, bits in flags.items()],
        *[_put(signal, values[signal.name]) for signal in signals if signal.length > 1],
    )


def _packing(command: DbcMessage) -> list[str]:
    given = {"seq": "seq", "version": "WIRE_VERSION", "time": "stamp // 1000", **ARGUMENTS}
    puts = [_put(signal, given[signal.name]) for signal in command.signals if signal.name != "crc"]
    return function(
        f"pack_command(data, seq, stamp, {', '.join(ARGUMENTS.values())})",
        "Write a command, but for its checksum.",
        "for i in range(COMMAND_LENGTH):",
        "    data[i] = 0",
        *puts,
    )


def _put(signal: Signal, value: str) -> str:
    bits = f"bits_of_real({value})" if signal.is_float else value
    return PUT[signal.length].format(at=signal.start // 8, bits=bits)


def function(head: str, doc: str, *lines: str) -> list[str]:
    return ["", "", f"def {head}:", f'    """{doc}"""', *(f"    {line}" for line in lines)]
