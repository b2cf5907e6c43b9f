"""What a finger that grips has in its memory, by section: ``f.grip.envelope`` in the text of its step.

Sections of ``float`` lie among the real numbers, those of ``int`` among the whole ones
(:mod:`vegrip.grip.layout`). Times are in [s] where they are real and in [ns] where they are whole; ln mu is
the logarithm of the friction coefficient.
"""


class Watch:
    """What the watchdog has seen of the displacement (:mod:`vegrip.grip.kernels.stillness`)."""

    level: float  # [m] displacement, slowly followed


class Demand:
    """What the estimate asks for, before the policy."""

    least: float  # [N] least force that keeps the margin; NaN: not known, inf: no force suffices
    load: float  # [N] tangential
    torque: float  # [N m]
    bound: float  # lower bound of the margin


class Asked:
    """What the present state is judged with."""

    margin: float
    quantile: float  # of the standard normal, one-sided


class Shared:
    """How the fingers of a grasp share friction, and what this one has of it."""

    load_noise: float  # [N] std of the load
    seen: float  # version of the belief that the estimate has
    before_var: float  # variance of ln mu before the state
    flag: float  # slip as it was sensed
    speed: float  # [m/s] slip speed as it was sensed


class Transfer:
    """What a contact that was met in its middle began with."""

    force: float  # [N]
    load: float  # [N]
    arm: float  # [m] contact radius, by which a torque counts as load


class Published:
    """Of the slip margin that is reported."""

    confidence: float


class Grip:
    """Of the force."""

    held: float  # [N] commanded last; NaN before the start
    required: float  # [N] what the finger needs on its own
    envelope: float  # [N] of the need, fast up and slow down
    quiet: float  # [s] since the envelope rose
    slot: float  # [s] length of a slot of the window of the usual need
    present: float  # [N] largest need in the present slot
    filled: float  # [s] of the present slot
    median: float  # [N] usual need: median of the slots
    elapsed: float  # [s] since a fault began; -inf: there is none
    adjustment: float  # [N] change of the force by the last command, for balance
    proven: float  # [N] lowest median of late
    kept: float  # [N] that the margin grip does not lower before a load is felt
    closed: float  # [N] largest force since the start, until a load or its fall ended the takeover
    lowered_from: float  # [N] held when force began to be lowered to learn friction; else what is held


class Setup:
    """Settings of line and grasp."""

    state_id: int  # identifier of the frames of states
    command_id: int
    sender_time: int  # whether stamps are the sender's
    finger: int  # number in the grasp
    fingers: int  # of the grasp
    thumb: int  # number of the finger that the others press against; -1: none
    recover_after: int  # good states that end a fault
    lifetime: int  # [ns] of a command
    expires: int  # the same as it stands in a frame
    renewal: int  # [ns] after which a command is renewed
    shares: int  # whether friction is shared
    leads: int  # whether loads are led by the lag of the drive
    contact1_id: int
    contact2_id: int
    margin_id: int
    report_period: int  # [ns]


class Line:
    """Counter of the frames."""

    last: int  # counter of the last one; -1: none came
    stamp: int  # [ns] arrival of it
    lost: int  # states that never came


class Input:
    """What the watchdog knows of the input; sets of channels are bit by bit."""

    condition: int
    good: int  # states in a row as good as the last one
    doubtful: int  # whether the normal force has stood still for too long to be lowered on
    lost: int  # channels that were there and are not
    seen: int  # channels that were there
    present: int  # channels of the last state
    alike: int  # states in a row with these channels
    usable: int  # whether they suffice for an estimate
    received: int  # [ns] when a state came last
    is_received: int
    corrupt: int  # [ns] when a broken frame came last
    is_corrupt: int
    seq: int  # of the last state
    stamp: int  # [ns] of the last state
    is_known: int  # whether there was one
    leaps: int  # states in a row from far ahead of the sender's clock
    still_since: int  # [ns] when a mechanical channel changed last
    force_still_since: int  # [ns] when the normal force changed last
    quickest: int  # [ns] shortest way of a state, between two clocks
    travel_since: int  # [ns] when the level of the displacement was followed last


class Need:
    """Of the demand."""

    in_contact: int
    slipping: int
    trusted: int
    believed: int  # whether the state is


class Turn:
    """Of the control, from state to state."""

    seen: int  # whether a state was accepted
    has_margin: int  # whether the bound of the margin was ever worked out
    transfer_since: int  # [ns]
    in_transfer: int
    has_closed: int  # whether the force with which the hand closed is taken over
    bears: int  # whether a load was felt since the finger touches
    started: int  # whether there is a command to hold
    commanded: int  # [ns] when
    asked: int  # [ns] when the need was worked out
    seq: int  # of the commands
    reason: int  # of the required force
    slots: int  # of the usual need that are filled
    next_slot: int
    used: int  # [ns] when a state was accepted
    reported_condition: int  # last
    report_due: int  # [ns] the first of contact and health
    noted: int  # states in the history
    fetched: int  # states fetched from it
    given_reason: int  # in the last command
    learned: int  # [ns] stamp of the state that friction was learned of
    led: int  # [ns] stamp of the state whose load was led
    contact_due: int  # [ns] next report of contact and margin; 0: the first one, which is a message
    health_due: int  # [ns]
    reports: int  # of contact and margin
    reported: int  # [ns] when


class Baseline:
    """Settings of a policy to compare with (:mod:`vegrip.grip.policies.baselines`)."""

    force: float  # [N]
    friction: float
    safety: float
    radius: float  # [m]
    power: float
    exponent: float


class Own:
    """What a policy or a share of the grasp in Python gets, and answers."""

    base: float  # [N] force to start from
    step: float  # [s] since it was asked
    force: float  # [N] its answer
    share: float  # [N]


class Choice:
    """Of the policy."""

    policy: int  # its number (:data:`vegrip.grip.layout.STEP_POLICIES`)
    asks: int  # whether it asks for the least force
    share: int  # whether the share of the grasp comes from Python
    reason: int  # of a policy in Python
    forgotten: int  # how often it has to forget the past
