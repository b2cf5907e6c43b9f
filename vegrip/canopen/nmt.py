"""NMT states and commands of CiA 301, and how they stand for the lifecycle of a node.

=============  =================  ======================================================================
lifecycle      NMT state          what the bus sees
=============  =================  ======================================================================
unconfigured   STOPPED            heartbeat only
inactive       PRE-OPERATIONAL    heartbeat, SDO, EMCY; no PDO
active         OPERATIONAL        everything
on hold        OPERATIONAL        the last safe commands go on; error register and EMCY say why
finalized      -                  a last heartbeat STOPPED, then silence
=============  =================  ======================================================================
"""

from typing import Final

from vegrip.messages import Lifecycle

INITIALISING, STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0, 4, 5, 127
START, STOP, ENTER_PRE_OPERATIONAL, RESET_NODE, RESET_COMMUNICATION = 1, 2, 128, 129, 130

STATE_OF: Final = {
    Lifecycle.UNCONFIGURED: STOPPED,
    Lifecycle.INACTIVE: PRE_OPERATIONAL,
    Lifecycle.ACTIVE: OPERATIONAL,
    Lifecycle.FINALIZED: STOPPED,
}
TRANSITIONS_OF_COMMAND: Final = {
    # command: the lifecycle states to go through
    START: (Lifecycle.ACTIVE,),
    STOP: (Lifecycle.UNCONFIGURED,),
    ENTER_PRE_OPERATIONAL: (Lifecycle.INACTIVE,),
    RESET_NODE: (Lifecycle.UNCONFIGURED, Lifecycle.INACTIVE),
    RESET_COMMUNICATION: (Lifecycle.INACTIVE,),
}


def nmt_state(lifecycle: Lifecycle, *, is_on_hold: bool) -> int:
    return OPERATIONAL if is_on_hold else STATE_OF[lifecycle]
