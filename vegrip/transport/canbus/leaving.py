"""Why the compiled loop of the bus leaves the rest to Python."""

from enum import IntEnum


class Why(IntEnum):
    """Why the loop has left."""

    TIME = 0  # it has run for long enough, or a signal has come
    NEWCOMER = 1  # a newcomer wants to join
    OTHER_PACKET = 2  # the member WHO has sent LENGTH bytes that are not requests alone
    GONE = 3  # the member WHO has left
    BEHIND = 4  # a member does not read; what is to be sent from SENT on is left
