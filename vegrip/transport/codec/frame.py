"""One CAN frame as the transports hand it to the codec."""

from typing import TYPE_CHECKING, Final, NamedTuple

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

EXTENDED: Final = 1 << 31
"""Set in the identifier of a frame whose identifier has 29 bits, as SocketCAN does."""


class Frame(NamedTuple):
    """A data frame; remote and error frames never come this far."""

    arbitration_id: int
    data: bytes
    fd: bool = False
    stamp: int = 0  # [ns] receive time; 0 on the way out


class FrameBlock(NamedTuple):
    """CAN FD frames as they came, one behind the other."""

    data: bytes
    rows: "NDArray[np.int64]"
    """(m, 4): identifier, receive time [ns], where in ``data`` its bytes begin and how many they are."""

    def frame(self, number: int) -> Frame:
        identifier, stamp, start, length = self.rows[number].tolist()
        return Frame(identifier, self.data[start : start + length], True, stamp)

    def newest(self) -> list[Frame]:
        last = {identifier: number for number, identifier in enumerate(self.rows[:, 0].tolist())}
        return [self.frame(number) for number in last.values()]

    def frames(self) -> list[Frame]:
        return [self.frame(number) for number in range(len(self.rows))]
