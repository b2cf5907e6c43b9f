"""Force commands that arrive, as plain values: a message for each costs a hand more than obeying it."""

from collections.abc import Callable, Mapping
from typing import Final, NamedTuple

from vegrip.messages import Reason
from vegrip.transport.codec.decoder import Decoder
from vegrip.transport.codec.frame import Frame

Refuse = Callable[[str], None]
FORCE: Final = 0
REASON: Final = 2
LIFETIME: Final = 3
"""Places among the fields of a command after stamp, finger and seq."""


class ArrivedCommand(NamedTuple):
    """What a hand needs of a command."""

    finger: str
    normal_force: float  # [N]
    reason: Reason
    stamp: int  # [ns]
    expires: int  # [ns]


class CommandReader:
    """Reads frames of commands as the decoder does, which shares the counters of its streams.

    Args:
        decoders: of the commands, by identifier.
        refuse: is told why a frame is refused.

    """

    def __init__(self, decoders: Mapping[int, Decoder], refuse: Refuse) -> None:
        self._decoders = dict(decoders)
        self._refuse = refuse

    def reads(self, frame: Frame) -> bool:
        """Return whether ``frame`` has the identifier of a command."""
        return frame.arbitration_id in self._decoders

    def read(self, frame: Frame) -> ArrivedCommand | None:
        """Return what ``frame`` commands; None: nothing, which is counted."""
        decoder = self._decoders[frame.arbitration_id]
        taken = decoder.read(frame)
        if isinstance(taken, str):
            self._refuse(taken)
            return None
        values, stamp = taken
        return ArrivedCommand(decoder.owner, values[FORCE], values[REASON], stamp, stamp + values[LIFETIME])
