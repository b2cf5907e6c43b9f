"""The package ``canopen`` served from a loop, which itself sends periodic messages when they are due.

A heartbeat that a thread or the kernel keeps sending says nothing about the loop; this one stops with it.
"""

import configparser
import logging
import struct
import time
from collections.abc import Callable
from datetime import UTC, datetime
from importlib.resources import as_file, files
from pathlib import Path
from typing import Final

import canopen
import canopen.network
from canopen.objectdictionary import ObjectDictionary, ODVariable

from vegrip.clock import NS
from vegrip.errors import ConfigError
from vegrip.messages import Lifecycle


def read_eds(name: str, node: int, like: str) -> ObjectDictionary:
    """Return the object dictionary in the EDS file ``name`` for the node-ID ``node``.

    Args:
        name: a path; empty for the file ``like``.
        node: node-ID.
        like: the file of ``proto/`` that it must agree with: same product, same mapping of every PDO.

    Raises:
        ConfigError: no such file, not an EDS file, or of another device.

    """
    shipped = _shipped(like, node)
    if not name:
        return shipped
    found = _import(Path(name), node)
    difference = difference_of(found, shipped)
    if difference:
        raise ConfigError(f"{name} does not describe this device: {difference}; use {like} of vegrip.proto")
    return found


def difference_of(found: ObjectDictionary, expected: ObjectDictionary) -> str:
    """Return the first difference in identity and PDOs, "" if there is none."""
    for index, sub in essentials(expected):
        try:
            value = _entry(found, index, sub).default
        except KeyError:
            return f"object {index:04X}sub{sub} is missing"
        wanted = _entry(expected, index, sub).default
        if value != wanted:
            return f"object {index:04X}sub{sub} is {_hex(value)}, not {_hex(wanted)}"
    return ""


def essentials(dictionary: ObjectDictionary) -> list[tuple[int, int]]:
    """Return index and sub-index of what makes the device: type, product, revision, PDO mappings."""
    mappings = [index for index in dictionary if 0x1600 <= index < 0x1800 or 0x1A00 <= index < 0x1C00]
    mapped = [(index, sub) for index in mappings for sub in dictionary[index].subindices]
    return [(0x1000, 0), (0x1018, 2), (0x1018, 3), *mapped]


def wanted_value(dictionary: ObjectDictionary, index: int, sub: int) -> int:
    return int(_entry(dictionary, index, sub).default or 0)


def _entry(dictionary: ObjectDictionary, index: int, sub: int) -> ODVariable:
    found = dictionary[index]
    return found if isinstance(found, ODVariable) else found[sub]


def _shipped(name: str, node: int) -> ObjectDictionary:
    with as_file(files("vegrip.proto").joinpath(name)) as path:
        return _import(path, node)


def _import(path: Path, node: int) -> ObjectDictionary:
    if path.suffix.lower() not in (".eds", ".dcf"):
        raise ConfigError(f"{path} is no EDS file; its name must end in .eds or .dcf")
    try:
        return canopen.import_od(str(path), node)
    except OSError as error:
        raise ConfigError(f"{path} cannot be read ({error.strerror})") from None
    except (configparser.Error, ValueError, KeyError, AttributeError) as error:
        reason = str(error).strip().splitlines()[0] if str(error) else type(error).__name__
        raise ConfigError(f"{path} is not a valid EDS file: {reason}") from None


def _hex(value: object) -> str:
    return hex(value) if isinstance(value, int) else str(value)


SendRaw = Callable[[int, bytes], None]
"""Takes COB-ID and data; never raises."""


class PeriodicTask:
    """A message sent once in a while; what ``canopen`` calls a periodic message task."""

    def __init__(self, can_id: int, data: bytes, period: float, now: int, owner: "LoopNetwork") -> None:
        self.can_id, self.data = can_id, bytes(data)
        self.due = now
        self._period = max(round(period * NS), 1_000_000)
        self._owner = owner

    def update(self, data: bytes) -> None:
        self.data = bytes(data)

    def stop(self) -> None:
        self._owner.tasks.discard(self)

    def serve(self, now: int) -> None:
        """Send if due, on the grid it began on; what was missed is not made up for."""
        if now >= self.due:
            self._owner.send_message(self.can_id, self.data)
            self.due += self._period * ((now - self.due) // self._period + 1)


class LoopNetwork(canopen.Network):  # type: ignore[misc]
    """A network without threads. The owner feeds frames to :meth:`receive` and calls :meth:`serve` when due.

    Args:
        send: puts a frame on the bus.
        now: the clock [ns].

    """

    def __init__(self, send: SendRaw, now: Callable[[], int]) -> None:
        super().__init__()
        self.tasks: set[PeriodicTask] = set()
        self.malformed = 0  # frames that a service could not read
        self._send = send
        self._now = now

    @property
    def due(self) -> int:
        """When the next message must be sent [ns]."""
        return min((task.due for task in self.tasks), default=2**63 - 1)

    def serve(self, now: int) -> None:
        for task in tuple(self.tasks):
            task.serve(now)

    def receive(self, can_id: int, data: bytes, stamp: int) -> None:
        """Let the services have a frame; one they cannot read is counted."""
        try:
            self.notify(can_id, bytearray(data), stamp / NS)
        except Exception as error:  # noqa: BLE001 (a frame of the wrong length must not end the loop)
            self.malformed += 1
            logging.getLogger("vegrip.canopen").debug("frame %x: %r", can_id, error)

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        """Put a data frame on the bus; remote frames are not used here."""
        if not remote:
            self._send(can_id, bytes(data))

    def send_periodic(
        self,
        can_id: int,
        data: bytes,
        period: float,
        remote: bool = False,  # noqa: ARG002 (as the base class has it)
    ) -> PeriodicTask:
        """Send ``data`` every ``period`` [s], for the first time at once."""
        task = PeriodicTask(can_id, data, period, self._now(), self)
        self.tasks.add(task)
        return task


INITIALISING, STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0, 4, 5, 127
START, STOP, ENTER_PRE_OPERATIONAL, RESET_NODE, RESET_COMMUNICATION = 1, 2, 128, 129, 130

STATE_OF: Final = {
    Lifecycle.UNCONFIGURED: STOPPED,
    Lifecycle.INACTIVE: PRE_OPERATIONAL,
    Lifecycle.ACTIVE: OPERATIONAL,
    Lifecycle.FINALIZED: STOPPED,
}
TRANSITIONS_OF_COMMAND: Final = {
    # command: the lifecycle states to go through
    START: (Lifecycle.ACTIVE,),
    STOP: (Lifecycle.UNCONFIGURED,),
    ENTER_PRE_OPERATIONAL: (Lifecycle.INACTIVE,),
    RESET_NODE: (Lifecycle.UNCONFIGURED, Lifecycle.INACTIVE),
    RESET_COMMUNICATION: (Lifecycle.INACTIVE,),
}


def nmt_state(lifecycle: Lifecycle, *, is_on_hold: bool) -> int:
    return OPERATIONAL if is_on_hold else STATE_OF[lifecycle]


TIME_COB_ID: Final = 0x100  # COB-ID
PRODUCED: Final = 1 << 30  # in object 1012h
CONSUMED: Final = 1 << 31

_EPOCH: Final = int(datetime(1984, 1, 1, tzinfo=UTC).timestamp())  # [s] since 1970
_DAY: Final = 86_400  # [s]
_TIME_OF_DAY: Final = struct.Struct("<IH")
_MILLISECOND: Final = NS // 1000


def pack_time(time_of_day: int) -> bytes:
    """Return the TIME of ``time_of_day`` [ns since 1970]."""
    days, rest = divmod(time_of_day - _EPOCH * NS, _DAY * NS)
    return _TIME_OF_DAY.pack(rest // _MILLISECOND, days)


def unpack_time(data: bytes) -> int | None:
    """Return the time of a TIME message [ns since 1970], None when it is none."""
    if len(data) != _TIME_OF_DAY.size:
        return None
    counted, days = (int(number) for number in _TIME_OF_DAY.unpack(data))
    milliseconds = counted & 0x0FFF_FFFF  # four bits are reserved
    if milliseconds >= _DAY * 1000:
        return None
    return (_EPOCH + days * _DAY) * NS + milliseconds * _MILLISECOND


class TimeProducer(PeriodicTask):
    """Sends the wall clock of this machine every ``period`` [s]."""

    def __init__(self, period: float, now: int, owner: LoopNetwork) -> None:
        super().__init__(TIME_COB_ID, b"", period, now, owner)

    def serve(self, now: int) -> None:
        if now >= self.due:
            self.update(pack_time(time.time_ns()))
        super().serve(now)
