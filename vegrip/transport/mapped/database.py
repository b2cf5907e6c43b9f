"""Messages and signals of a foreign hand, whatever kind of file declares them."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from vegrip.transport.codec.frame import EXTENDED

__all__ = ["EXTENDED", "Database", "ForeignMessage", "Signal"]


@dataclass(frozen=True, slots=True)
class Signal:
    """Some bits of a message.

    Attributes:
        start: where it begins, counted as in a DBC: the lowest bit when little-endian, else the highest.
        scale, offset: physical value = raw * scale + offset, in ``unit``.
        low, high: physical limits as declared, NaN where none are.
        selected_by: the multiplexer and its values for which this signal is there; "" = always.

    """

    name: str
    start: int
    length: int
    is_big_endian: bool = False
    is_signed: bool = False
    is_float: bool = False
    scale: float = 1.0
    offset: float = 0.0
    unit: str = ""
    low: float = float("nan")
    high: float = float("nan")
    choices: Mapping[int, str] = field(default_factory=dict)
    selected_by: str = ""
    selectors: tuple[int, ...] = ()

    def shift(self, length: int) -> int:
        """Return by how many bits a message of ``length`` bytes, read as one number, is moved right."""
        if not self.is_big_endian:
            return self.start
        return 8 * length - (8 * (self.start // 8) + 7 - self.start % 8) - self.length

    @property
    def raw_range(self) -> tuple[int, int]:
        """The smallest and the largest raw value of an integer."""
        if self.is_signed:
            return -(1 << self.length - 1), (1 << self.length - 1) - 1
        return 0, (1 << self.length) - 1


@dataclass(frozen=True, slots=True)
class ForeignMessage:
    """One kind of frame."""

    name: str
    identifier: int
    length: int  # [bytes]
    fd: bool
    signals: Mapping[str, Signal]
    asked: bool = False  # comes as the answer to a request (CANopen SDO)


@dataclass(frozen=True, slots=True)
class Database:
    """All messages of a file, by name."""

    name: str
    messages: Mapping[str, ForeignMessage]
    opening: tuple[tuple[int, bytes], ...] = ()  # frames to send once, before anything comes
    descriptors: bytes = b""  # of protobuf
