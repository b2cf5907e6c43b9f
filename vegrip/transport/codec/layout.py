"""How each kind of message lies in CAN frames: what ``vegrip.transport.codec.database`` makes of the DBC.

A message takes one frame, or several parts sent in order; the last one sent has its bit ``last`` set, so that
parts without anything measured at the end need not be sent.
"""

import struct
from dataclasses import dataclass

from vegrip.transport.codec.cells import Place, Raw
from vegrip.transport.codec.convert import Converter
from vegrip.transport.codec.members import Cells, Get, ReadRow
from vegrip.transport.codec.protection import Profile
from vegrip.transport.codec.schema import Field, MessageSchema


@dataclass(frozen=True, slots=True)
class Slot:
    """One signal of the payload."""

    name: str
    field: Field
    attribute: str  # of the message, "" when the value takes a computation
    get: Get
    convert: Converter
    place: Place


@dataclass(frozen=True, slots=True)
class Part:
    """One frame of a message."""

    name: str
    number: int  # from 1
    base: int  # identifier for finger 0 of hand 0
    length: int
    fd: bool
    profile: Profile
    packer: struct.Struct
    counter: Place
    modulus: int
    version: Place
    version_modulus: int
    last: Place | None
    time: Place | None
    slots: tuple[Slot, ...]
    offset: int  # cells of the parts before this one
    cells: int

    @property
    def absent(self) -> Cells:
        """The cells of a part that was not sent: nothing measured."""
        row: list[Raw] = [0] * self.cells
        for slot in self.slots:
            slot.place.put(row, slot.convert.absent)
        return tuple(row)


@dataclass(frozen=True, slots=True)
class Layout:
    """A kind of message, classic or FD."""

    schema: MessageSchema
    fd: bool
    parts: tuple[Part, ...]
    read: ReadRow  # the fields after stamp, owner and seq, from the cells of all parts
    relative: tuple[int, ...]  # which of them are times after the stamp


@dataclass(frozen=True, slots=True)
class Layouts:
    """All of the database."""

    version: int
    hand_stride: int
    finger_stride: int
    hands: int
    fingers: int
    layouts: tuple[Layout, ...]
