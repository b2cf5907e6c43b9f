"""Times and numbers by which the bus process works, in Python and in C."""

from typing import Final

from vegrip.clock import NS

NO_EVENT: Final = 1 << 62  # [ns]
LONGEST_SLEEP: Final = 10_000_000  # [ns] so that those who come or leave are seen on a slow bus too
GATHERED: Final = 100_000  # [ns] frames that end so soon after another are handed out with it, if more wait
TRANSMIT_QUEUE: Final = 64  # frames of one member that may wait for the bus; then the member is not read
SLICE: Final = (
    NS // 20
)  # [ns] of the bus at a time, when it is behind; else those who come and leave must wait
OLDEST_REQUEST: Final = NS  # [ns] a frame that claims to have waited for longer has not
