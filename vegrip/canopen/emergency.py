"""Emergency codes of CiA 301 that the devices here send, and which of them are in force.

The five bytes that belong to the manufacturer hold the lifecycle state, then the node-ID it is about.
"""

from collections.abc import Callable
from typing import Final

HEARTBEAT_LOST: Final = 0x8130
ID_TAKEN: Final = 0x8150
SOFTWARE: Final = 0x6100
NOT_ITS_EDS: Final = 0x6300
NO_ERROR: Final = 0x0000

GENERIC, COMMUNICATION = 0x01, 0x10  # bits of the error register, object 1001h
REGISTER: Final = {
    HEARTBEAT_LOST: GENERIC | COMMUNICATION,
    ID_TAKEN: GENERIC | COMMUNICATION,
    SOFTWARE: GENERIC,
    NOT_ITS_EDS: GENERIC | COMMUNICATION,
}

Send = Callable[[int, int, bytes], None]
"""Takes code, error register and the bytes of the manufacturer."""


class Emergencies:
    """What is wrong now; each beginning and the end of the last is reported once."""

    def __init__(self, send: Send) -> None:
        self.standing: dict[tuple[int, int], str] = {}
        """``(code, node-ID)`` -> what is wrong, in one sentence."""
        self._send = send

    @property
    def register(self) -> int:
        """The error register."""
        bits = 0
        for code, _ in self.standing:
            bits |= REGISTER[code]
        return bits

    def begin(self, code: int, node: int, sentence: str, lifecycle: int) -> bool:
        """Tell that something is wrong with ``node``; return whether that is new."""
        if (code, node) in self.standing:
            return False
        self.standing[code, node] = sentence
        self._send(code, self.register, bytes([lifecycle, node, 0, 0, 0]))
        return True

    def end(self, code: int, node: int, lifecycle: int) -> None:
        """Tell that it is over; the error register says whether anything else is still wrong."""
        if self.standing.pop((code, node), None) is not None:
            self._send(NO_ERROR, self.register, bytes([lifecycle, node, 0, 0, 0]))
