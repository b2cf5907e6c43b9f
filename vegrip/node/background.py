"""Helper processes of a node: they end with it, and everything else on the machine goes first."""

import contextlib
import os

from vegrip.node.launcher import end_with_parent

LOWEST = 19  # nice


def serve_behind() -> None:
    """Be a helper: end when the parent dies, in whatever way, and make way for all that is in a hurry.

    Nice alone is not enough on a core that is shared with the loop: a nice process that runs keeps the core
    for the rest of its slice, some milliseconds, while one that is SCHED_IDLE gives it up at once.
    """
    end_with_parent()
    os.nice(LOWEST)
    with contextlib.suppress(OSError):  # forbidden in some containers
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
