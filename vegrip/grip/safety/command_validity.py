"""Whether the drive of a finger may still obey a force command. Pure.

Counter and checksum have been looked at by the codec, and on a network the key of the sender. What is left is
time: a command that was held back, stamped by a wrong clock, or says that it lives for ever.
"""

import math

from vegrip.clock import NS
from vegrip.messages import ForceCommand

AHEAD = 1 * NS  # [ns] by which a sender's clock may be ahead; a command further ahead would live longer
LONGEST_LIFE = 10 * NS  # [ns] the largest lifetime that can be configured


def reason_to_reject(command: ForceCommand, now: int) -> str:
    """Return why ``command`` must not be obeyed at ``now`` [ns], "" if it may."""
    return reason_to_reject_force(command.normal_force, command.stamp, command.expires, now)


def reason_to_reject_force(normal_force: float, stamp: int, expires: int, now: int) -> str:
    """Return why a command of ``normal_force`` [N], of which no message was made, must not be obeyed."""
    if not math.isfinite(normal_force) or normal_force < 0.0:
        return "no usable force"
    if expires <= now:
        return "expired"
    if expires - stamp > LONGEST_LIFE:
        return "lives too long"
    return "from the future" if stamp - now > AHEAD else ""
