"""Play the frames of a CAN log as they came: the hand that was logged, to a node that runs."""

from collections.abc import Callable, Iterable

import can

from vegrip.clock import Clock
from vegrip.transport.codec import Frame
from vegrip.transport.codec.frame import EXTENDED


def play_frames(
    frames: Iterable[Frame], send: Callable[[can.Message], None], clock: Clock, speed: float = 1.0
) -> int:
    """Send each of ``frames`` when its time has come, by its stamp [ns]; return how many there were.

    A frame that is late is sent at once, so the last comes when it would have.
    """
    count, start, first = 0, 0, 0
    for frame in frames:
        if not count:
            start, first = clock.now(), frame.stamp
        clock.sleep_until(start + round((frame.stamp - first) / speed))
        send(
            can.Message(
                arbitration_id=frame.arbitration_id & ~EXTENDED,
                is_extended_id=bool(frame.arbitration_id & EXTENDED),
                is_fd=frame.fd,
                bitrate_switch=frame.fd,
                data=frame.data,
            )
        )
        count += 1
    return count
