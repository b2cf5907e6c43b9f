"""Force commands that arrive, as plain values: a message for each costs a hand more than obeying it."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np

from vegrip.clock import NS
from vegrip.errors import ConfigError
from vegrip.messages import Reason
from vegrip.transport.codec.convert import Coded, Scaled
from vegrip.transport.codec.database import database
from vegrip.transport.codec.decoder import Decoder
from vegrip.transport.codec.layout import Part
from vegrip.transport.codec.row_kernels import CRC_TABLE, Bytes, Integers, read_commands

Refuse = Callable[[str], None]
MOST_ROWS: Final = 256
CODES: Final = 256  # of reasons
SIGNALS: Final = ("seq", "version", "time", "normal_force", "adjustment", "reason", "expires")
KINDS: Final = (("reason", Coded), ("expires", Scaled))


class ArrivedCommand(NamedTuple):
    """What a hand needs of a command."""

    finger: str
    normal_force: float  # [N]
    reason: Reason
    stamp: int  # [ns]
    expires: int  # [ns]


class RowHead(NamedTuple):
    """Where a row has what the bus says of the frame in it: bytes from its begin."""

    number: int  # 4 bytes
    end: int  # 8 bytes [ns]
    busy: int  # 8 bytes [ns]
    identifier: int  # 4 bytes
    flags: int
    code: int  # of the length
    mask: int  # of the flags that matter
    wanted: int  # what they are for a CAN FD data frame with 11 bits
    command_code: int  # the code of the length of a command
    frame: int  # where it begins


class Deliveries(NamedTuple):
    """Commands, and what the bus said of the frames."""

    commands: Sequence[ArrivedCommand]
    first: int  # number of the first delivery
    rows: int
    end: int  # [ns] of the last
    busy: int  # [ns] as of the last


class CommandReader:
    """Reads frames of commands as their decoders do, whose counters of the streams it goes on with.

    Args:
        decoders: by identifier.
        refuse: is told why a frame is refused.

    Raises:
        ConfigError: a command is not as it must be to be read in rows.

    """

    def __init__(self, decoders: Mapping[int, Decoder], refuse: Refuse) -> None:
        self._decoders = dict(decoders)
        self._refuse = refuse
        self._in_turn = list(decoders.values())
        self._identifiers = np.array(list(decoders), np.int64)
        part = self._in_turn[0].part
        self.length = part.length
        signals = {s.name: s.start // 8 for s in database().get_message_by_name(part.name).signals}
        self._places = np.array([signals[name] for name in SIGNALS])
        self._version = self._in_turn[0].version
        reason, lifetime = (_converter(part, name, kind) for name, kind in KINDS)
        self._reasons = np.isin(np.arange(CODES), list(reason.meaning))
        self._meaning, self._scale = reason.meaning, lifetime.scale
        self._lifetimes = np.array([lifetime.low, lifetime.high])
        self._wholes, self._forces = np.zeros((MOST_ROWS, 8), np.int64), np.zeros(MOST_ROWS)
        no_rows = np.frombuffer(b"", np.uint8).reshape(0, self.length)
        self._read(no_rows, np.zeros(len(RowHead._fields), np.int64))  # compiles before the loop begins

    def read_rows(self, rows: Bytes, head: Integers) -> Deliveries | None:
        """Return what the frames in ``rows`` command, read at once.

        None, and nothing is taken, where one of them is no command, is broken or means nothing, or where one
        is missing between them: then each is to be looked at by itself.

        Args:
            rows: (m, bytes), ``MOST_ROWS`` at most.
            head: a :class:`RowHead`.

        """
        count = len(rows)
        if count > MOST_ROWS or not self._read(rows, head):
            return None
        wholes, forces = self._wholes[:count], self._forces[:count]
        commands = []
        numbers = wholes.tolist()
        for (who, _, end, _, counter, time, reason, lifetime), force in zip(
            numbers, forces.tolist(), strict=True
        ):
            decoder = self._in_turn[who]
            if decoder.assembly.sequence.advance(counter, end) is None:
                self._refuse("counter")
                continue
            stamp = decoder.stamp(end, time)
            expires = stamp + round(lifetime * self._scale * NS)
            commands.append(ArrivedCommand(decoder.owner, force, self._meaning[reason], stamp, expires))
        return Deliveries(commands, numbers[0][1], count, numbers[-1][2], numbers[-1][3])

    def _read(self, rows: Bytes, head: Integers) -> bool:
        return read_commands(
            rows, head, self.length, self._identifiers, self._places, self._version, self._reasons,
            self._lifetimes, CRC_TABLE, self._wholes, self._forces,
        )  # fmt: skip


def _converter(part: Part, name: str, kind: type[Any]) -> Any:
    convert = next(slot.convert for slot in part.slots if slot.name == name)
    if not isinstance(convert, kind):
        raise ConfigError(f"fingertip.dbc: {part.name}.{name} must be of the kind {kind.__name__}")
    return convert
