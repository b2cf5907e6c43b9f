"""Registers of Modbus, over TCP or a serial line (RTU): one description, two framings. Pure.

::

    [modbus]
    framing = "rtu"                          # or "tcp"
    unit = 9

    [device]
    opening = [{ write = 0x03E8, data = "0100" }]
    poll = [{ reads = "status", every = 0.02 }]

    [packets.status]
    read = 0x07D0                            # its first register
    registers = 3
    [packets.status.fields]                  # counted from the first byte of the first register
    object = "u2 @0.6"

    [packets.grip]
    write = 0x03E8
    registers = 3
    [packets.grip.fields]
    force = "u8 @5"

It becomes packets and requests as :mod:`vegrip.transport.maps.packets` and ``dialogue`` have them. What was
written is answered by ``written``; an exception of the device counts as ``modbus_exception``. The next
request leaves when the last was answered or given up; RTU is also silent for 3.5 characters before it.

[ModbusSerial]_: functions 3 and 16, CRC-16 with its low byte first; [ModbusTcp]_: the header before them.
"""

import re
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from vegrip.config import build, parameter
from vegrip.errors import ConfigError
from vegrip.transport.maps.checksums import appended

FRAMINGS: Final = ("rtu", "tcp")
CHARACTER_BITS: Final = 11  # start, 8 bits, parity or second stop, stop
SILENT_CHARACTERS: Final = 3.5
FAST_BAUD, FAST_SILENCE_S = 19_200, 0.00175  # above that rate the silence is fixed [ModbusSerial]_, 2.5.1.1
MOST_REGISTERS: Final = 123  # that function 16 writes


@dataclass(frozen=True)
class ModbusMap:
    """``[modbus]`` of a map."""

    framing: str = parameter("rtu", choices=FRAMINGS)
    unit: int = parameter(1, low=0, high=247, doc="the device on its line")


def framed(framing: str, transaction: int, body: bytes) -> bytes:
    """Return unit, function and data as they are sent.

    >>> framed("rtu", 0, bytes.fromhex("09 03 07D0 0001")).hex(" ")
    '09 03 07 d0 00 01 85 cf'
    """
    if framing == "tcp":
        return struct.pack(">HHH", transaction, 0, len(body)) + body
    return appended("modbus", body)


def silence(baud: int) -> float:
    """Return how long a line of ``baud`` [bit/s] is silent between two frames [s]."""
    return FAST_SILENCE_S if baud > FAST_BAUD else SILENT_CHARACTERS * CHARACTER_BITS / baud


def with_registers(table: Mapping[str, Any], where: str) -> Mapping[str, Any]:
    """Return a map whose packets and requests are bytes; one without ``[modbus]`` is returned as it is."""
    if "modbus" not in table:
        return table
    modbus = build(ModbusMap, _table(table, "modbus", where), f"{where} [modbus]")
    expander = _Expander(modbus, where)
    given = _table(table, "packets", where)
    packets = {name: expander.packet(name, dict(_table(given, name, f"{where} [packets]"))) for name in given}
    device = {
        name: [expander.entry(each, packets) for each in value] if isinstance(value, list) else value
        for name, value in _table(table, "device", where).items()
    }
    if modbus.framing == "rtu":
        baud = _table(table, "transport", where).get("baud", 115_200)
        if not isinstance(baud, int) or baud < 1:
            raise ConfigError(f"{where} [transport]: 'baud' is {baud!r}; it must be a number of bit/s")
        device.setdefault("silence", silence(baud))
    return {**table, "packets": packets | expander.answers(packets), "device": device}


class _Expander:
    def __init__(self, modbus: ModbusMap, where: str) -> None:
        self._framing, self._unit, self._where = modbus.framing, modbus.unit, where
        self._head, self._tail = (6, 0) if modbus.framing == "tcp" else (0, 2)  # [bytes] around the body
        self._transactions: dict[str, int] = {}

    def packet(self, name: str, keys: dict[str, Any]) -> dict[str, Any]:
        if not keys.keys() & {"read", "write"}:
            return keys
        where = f"{self._where} [packets.{name}]"
        first, count = keys.pop("read", None), keys.pop("registers", 0)
        is_answer = first is not None
        first = keys.pop("write", 0) if first is None else first
        _check(first, count, where)
        transaction = self._transactions[name] = len(self._transactions) + 1
        if is_answer:
            keys["_request"] = struct.pack(">BBHH", self._unit, 3, first, count)
            body = struct.pack(">BBB", self._unit, 3, 2 * count)
        else:
            body = struct.pack(">BBHHB", self._unit, 16, first, count, 2 * count)
            keys.setdefault("answer", "written")
        head = self._begin(transaction, body, 2 * count)
        keys["fields"] = {
            field: re.sub(r"@ *(\d+)", lambda at: f"@{int(at[1]) + len(head)}", text)
            if isinstance(text, str)
            else text
            for field, text in _table(keys, "fields", where).items()
        }
        return self._guarded(keys, head, len(head) + 2 * count + self._tail)

    def entry(self, given: Any, packets: dict[str, dict[str, Any]]) -> Any:
        """Return an entry of ``[device]`` in bytes."""
        if not isinstance(given, Mapping):
            raise ConfigError(f"{self._where} [device]: {given!r} is no entry; write {{ reads = 'PACKET' }}")
        entry = dict(given)
        if "reads" in entry:
            name = entry.pop("reads")
            request = packets.get(str(name), {}).get("_request")
            if request is None:
                raise ConfigError(
                    f"{self._where} [device]: 'reads' is {name!r}, which is no packet with 'read'"
                )
            return {
                "expects": name,
                **entry,
                "data": framed(self._framing, self._transactions[name], request).hex(),
            }
        if "write" not in entry:
            return entry
        first, data = entry.pop("write"), self._registers(entry.get("data", ""))
        _check(first, len(data) // 2, f"{self._where} [device]")
        body = struct.pack(">BBHHB", self._unit, 16, first, len(data) // 2, len(data)) + data
        return {"expects": "written", **entry, "data": framed(self._framing, 0, body).hex()}

    def _registers(self, text: Any) -> bytes:
        try:
            data = bytes.fromhex(text)
        except (TypeError, ValueError):
            data = b"?"
        if len(data) % 2:
            raise ConfigError(
                f"{self._where} [device]: 'data' is {text!r}; write whole registers, like data = '0100 00FF'"
            )
        return data

    def answers(self, packets: dict[str, dict[str, Any]]) -> dict[str, dict[str, Any]]:
        """Return the packets that no map has to name; takes from the others what was for requests."""
        for each in packets.values():
            each.pop("_request", None)
        return {
            "written": self._answer(bytes([self._unit, 16]), 4, {}),
            **{
                f"refused{function}": self._answer(
                    bytes([self._unit, 0x80 | function]), 1, {"counted": "modbus_exception"}
                )
                for function in (3, 16)
            },
        }

    def _answer(self, body: bytes, rest: int, keys: dict[str, Any]) -> dict[str, Any]:
        head = self._begin(None, body, rest)
        return self._guarded(keys, head, len(head) + rest + self._tail)

    def _begin(self, transaction: int | None, body: bytes, rest: int) -> list[str]:
        """Return the first bytes in hexadecimal; of any transaction where it is None."""
        if self._framing == "rtu":
            return [f"{byte:02X}" for byte in body]
        whole = struct.pack(">HHH", transaction or 0, 0, len(body) + rest) + body
        found = [f"{byte:02X}" for byte in whole]
        return found if transaction is not None else ["..", "..", *found[2:]]

    def _guarded(self, keys: dict[str, Any], head: list[str], length: int) -> dict[str, Any]:
        keys |= {"start": " ".join(head), "length": length}
        if self._framing == "rtu":
            keys["fields"] = {**keys.get("fields", {}), "crc": f"u16 le @{length - 2}"}
            keys["checksum"] = {"kind": "modbus", "signal": "crc"}
        return keys


def _check(first: Any, count: Any, where: str) -> None:
    if not (isinstance(first, int) and 0 <= first <= 0xFFFF):
        raise ConfigError(f"{where}: the first register is {first!r}; it must be a number up to 0xFFFF")
    if not (isinstance(count, int) and 1 <= count <= MOST_REGISTERS):
        raise ConfigError(f"{where}: {count!r} registers; it must be 1 to {MOST_REGISTERS}")


def _table(tables: Mapping[str, Any], name: str, where: str) -> Mapping[str, Any]:
    value = tables.get(name, {})
    if not isinstance(value, Mapping):
        raise ConfigError(f"{where}: {name!r} is {value!r}; it must be a table")
    return value
