"""The FD frames of states and commands as functions of the compiled finger step, written from the DBC.

The functions are plain scalar Python over bytes, as the kernels of the control are, and stand among them in
the generated module (:mod:`vegrip.grip.compiled`). So ``fingertip.dbc`` alone says where a value stands.
"""

from functools import cache

from cantools.database.can import Message as DbcMessage
from cantools.database.can import Signal

from vegrip.transport.codec.database import database, layouts

STATE, COMMAND = "FingertipStateFd", "ForceCommandFd"
HEAD_SIGNALS = ("crc", "seq", "version", "time")
ARGUMENTS = {"normal_force": "force", "adjustment": "adjustment", "reason": "reason", "expires": "expires"}
"""Signal of a command -> argument of ``pack_command``; ``expires`` is given as it stands in the frame."""
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
    ])  # fmt: skip


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
    """Return the lines of a function of a generated module."""
    return ["", "", f"def {head}:", f'    """{doc}"""', *(f"    {line}" for line in lines)]
