"""The state of a finger as a message brought it, of whatever wire: counter and time are judged already.

:func:`finger_message` answers it in one call. Where an estimate, a policy or a share in Python takes part,
the calls between which it fits answer in their order: judge, take, bound, need, settle.
"""

from vegrip.estimator.elapsed import bounded_time
from vegrip.grip.grasp_memory import GraspMemory
from vegrip.grip.kernels.control import base_force, hold_without_input, is_renewal_due, time_asked
from vegrip.grip.kernels.demand import demand_nothing
from vegrip.grip.kernels.finger_step import *
from vegrip.grip.kernels.generated import *
from vegrip.grip.kernels.share import share_need
from vegrip.grip.kernels.watchdog import watch_silence


def finger_message(
    f: Floats, t: Wholes, g: GraspMemory, values: Floats, seq: int, stamp: int, now: int
) -> int:
    """Answer the state of ``values``; the command stays in the memory."""
    take_message(f, t, values, seq, stamp)
    return answer_state(f, t, g, now)


def finger_sense(f: Floats, t: Wholes, g: GraspMemory, values: Floats, seq: int, stamp: int, now: int) -> int:
    """Take the state of ``values`` and find what the finger needs; return whether it is believed."""
    take_message(f, t, values, seq, stamp)
    sense(f, t, g, now)
    return int(t.need.believed)


def finger_judge(f: Floats, t: Wholes, g: GraspMemory, values: Floats, seq: int, stamp: int, now: int) -> int:
    """Judge the state of ``values``; return whether it is believed."""
    take_message(f, t, values, seq, stamp)
    judge_state(f, t, g, now)
    return int(t.need.believed)


def finger_take(f: Floats, t: Wholes, g: GraspMemory, _now: int) -> int:
    """Take a state that is believed into the estimate, and find the demand."""
    take_estimate(f, t, g)
    return 1


def finger_bound(f: Floats, t: Wholes, _g: GraspMemory, now: int) -> int:
    """Bound the demand; return whether the policy is asked, by ``OWN_BASE`` and ``OWN_STEP``."""
    bound_demand(f, t, now)
    f.own.base, f.own.step = base_force(f, t), time_asked(t, now)
    return 1 if t.turn.started == 1 and t.input.condition <= CONDITION_DEGRADED else 0


def finger_need(f: Floats, t: Wholes, g: GraspMemory, now: int) -> int:
    """Find what the finger needs; return whether it is to be commanded."""
    settle_need(f, t, g, now)
    return int(t.turn.started)


def finger_settle(f: Floats, t: Wholes, g: GraspMemory, now: int) -> int:
    """Command the finger's share once it has begun; return what was done, in bits."""
    return settle_state(f, t, g, now)


def finger_watch(f: Floats, t: Wholes, g: GraspMemory, now: int) -> int:
    """Look at the clock: silence is a fault; return whether the last command must be renewed."""
    watch_silence(f, t, now)
    if not is_renewal_due(t, now):
        return 0
    if t.input.condition > CONDITION_DEGRADED:
        demand_nothing(f, t)
        hold_without_input(f, t, now)
        share_need(f, t, g)
    return 1


def finger_hold_last(f: Floats, t: Wholes, g: GraspMemory, now: int) -> int:
    """Ride out a fault of the node itself, without estimates; return whether a command is due."""
    if not is_renewal_due(t, now):
        return 0
    demand_nothing(f, t)
    hold_without_input(f, t, now)
    share_need(f, t, g)
    return 1


def take_message(f: Floats, t: Wholes, values: Floats, seq: int, stamp: int) -> None:
    """Take the present state."""
    t.news.seq, t.news.stamp = seq, bounded_time(stamp)
    for i in range(MEASURED):
        f.state[i] = values[i]
