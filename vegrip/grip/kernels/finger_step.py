"""One frame of one finger: state in, command out, one compiled call."""

import math

from vegrip.estimator.elapsed import elapsed_time
from vegrip.estimator.kernels.sense import assimilate, margin_bound, touches
from vegrip.grip.grasp_memory import GraspMemory
from vegrip.grip.kernels.choice import note_command, pressed_by_others, shared_force
from vegrip.grip.kernels.control import *
from vegrip.grip.kernels.demand import demand_force, demand_nothing, hold_doubtful
from vegrip.grip.kernels.frame_bytes import protect
from vegrip.grip.kernels.friction_shared import (
    hide_unsound,
    prepare_friction,
    restore_slip,
    update_shared_friction,
)
from vegrip.grip.kernels.generated import *
from vegrip.grip.kernels.receive import is_welcome, is_whole, take_frame
from vegrip.grip.kernels.share import share_need
from vegrip.grip.kernels.takeover import begin_transfer, bound_takeover, hold_unloaded
from vegrip.grip.kernels.watchdog import accept_state, note_broken, watch_silence

LEFT_ALONE = 0  # the frame is refused, or is not one for this way; nothing has changed
STEP_TAKEN = 1
STEP_COMMANDED = 2  # a command has been packed
STEP_REPORT = 4  # something is due to be reported, or fetched from the history


def finger_step(
    f: Floats, t: Wholes, g: GraspMemory, frame: Bytes, length: int, arrival: int, now: int, out: Bytes
) -> int:
    """Answer a frame that came at ``arrival`` at ``now`` [ns], in ``out``; return what was done, in bits."""
    if not is_welcome(t, frame, length, arrival):
        return LEFT_ALONE
    take_frame(f, t, frame, arrival)
    done = answer_state(f, t, g, now)
    if (done & STEP_COMMANDED) != 0:
        write_command(f, t, now, out)
    return done


def finger_receive(
    f: Floats, t: Wholes, g: GraspMemory, frame: Bytes, length: int, arrival: int, now: int, out: Bytes
) -> int:
    """As :func:`finger_step` for a finger that works alone: what a node does beside the step is done here."""
    if not is_whole(t, frame, length):
        note_broken(t, now)
        return LEFT_ALONE
    done = finger_step(f, t, g, frame, length, arrival, now, out)
    if t.turn.seen == 1:
        f.taken.bound = margin_bound(f, t)  # where reports are made, they bring it up to date
    return done


def finger_tick(f: Floats, t: Wholes, g: GraspMemory, now: int, out: Bytes) -> int:
    """Look at the clock: silence is a fault, and a command is renewed before it expires."""
    watch_silence(f, t, now)
    if not is_renewal_due(t, now):
        return LEFT_ALONE
    if t.input.condition > CONDITION_DEGRADED:
        demand_nothing(f, t)
        require_force(f, t, now)
        share_need(f, t, g)
    settle_command(f, t, g, now)
    write_command(f, t, now, out)
    return STEP_TAKEN + STEP_COMMANDED


def answer_state(f: Floats, t: Wholes, g: GraspMemory, now: int) -> int:
    """Answer the present state at ``now`` [ns] with numbers; return what was done, in bits."""
    sense(f, t, g, now)
    return settle_state(f, t, g, now)


def settle_state(f: Floats, t: Wholes, g: GraspMemory, now: int) -> int:
    """Command this finger's share once it has begun; return what was done with its state, in bits."""
    done = STEP_TAKEN
    if t.turn.started == 1:
        settle_command(f, t, g, now)
        done += STEP_COMMANDED
    return done + STEP_REPORT if is_report_due(t, now) else done


def sense(f: Floats, t: Wholes, g: GraspMemory, now: int) -> None:
    """Judge the present state, take it in, and find what the finger needs."""
    judge_state(f, t, g, now)
    if t.need.believed == 1:
        take_estimate(f, t, g)
    bound_demand(f, t, now)
    settle_need(f, t, g, now)


def judge_state(f: Floats, t: Wholes, g: GraspMemory, now: int) -> None:
    """Judge the present state: whether the estimate may use it, and what it says of slip."""
    demand_nothing(f, t)
    hide_unsound(f, t, g)
    t.need.believed = 1 if accept_state(f, t, now) else 0
    if t.need.believed == 1:
        prepare_friction(f, t, g)


def take_estimate(f: Floats, t: Wholes, g: GraspMemory) -> None:
    """Take a state that is believed into the estimate, and find the demand."""
    assimilate(f, t)
    if t.turn.has_margin == 0:
        f.taken.bound = margin_bound(f, t)
        t.turn.has_margin = 1
    demand_force(f, t, g)


def bound_demand(f: Floats, t: Wholes, now: int) -> None:
    """Begin with the first state that is believed; bound the demand by what is known besides the estimate."""
    if t.need.believed == 1:
        measured = f.state.normal_force
        present = f.report.force if math.isnan(measured) else measured
        if t.turn.started == 0:
            start_control(f, t, present, now)
        if t.turn.seen == 0:
            begin_transfer(f, t, f.grip.required, f.report.radius, now)
        elif is_back(f, t, now):
            begin_transfer(f, t, present, f.report.radius, now)
        t.turn.used = now
        t.turn.seen = 1
        note_history(f, t)
    if t.turn.started == 1:
        bound_takeover(f, t, now)
        hold_doubtful(f, t)
        hold_unloaded(f, t)


def is_back(f: Floats, t: Wholes, now: int) -> bool:
    """Return whether the state comes after a silence in which the estimate has lost the contact."""
    return 0.0 < f.set.longest_gap < float(elapsed_time(now, t.turn.used)) / 1e9


def settle_need(f: Floats, t: Wholes, g: GraspMemory, now: int) -> None:
    """Find what the finger needs, as its policy answers the demand; let the grasp know, and learn."""
    if t.turn.started == 1:
        require_force(f, t, now)
    if t.need.believed == 1:
        update_shared_friction(f, t, g)
    restore_slip(f, t)
    share_need(f, t, g)


def settle_command(f: Floats, t: Wholes, g: GraspMemory, now: int) -> None:
    """Settle the command for this finger's share of the grasp."""
    share, pressed = shared_force(f, t, g), pressed_by_others(t, g)
    f.grip.adjustment, t.turn.given_reason = command_share(f, t, share, pressed, now)
    note_command(f, t, g)


def write_command(f: Floats, t: Wholes, now: int, out: Bytes) -> None:
    """Pack the command that was settled at ``now`` [ns]."""
    force, adjustment, reason = f.grip.held, f.grip.adjustment, t.turn.given_reason
    pack_command(out, t.turn.seq, now, force, adjustment, reason, t.setup.expires)
    protect(out, COMMAND_LENGTH, t.setup.command_id)


def is_report_due(t: Wholes, now: int) -> bool:
    """Return whether a report is due, the condition has changed, or half of the history waits."""
    waiting = t.turn.noted - t.turn.fetched
    full = HISTORY_STATES > 0 and waiting >= HISTORY_STATES // 2
    return now >= t.turn.report_due or t.input.condition != t.turn.reported_condition or full


def note_history(f: Floats, t: Wholes) -> None:
    """Keep the state itself for those who look back."""
    if HISTORY_STATES > 0:
        row = t.turn.noted % max(HISTORY_STATES, 1)
        t.history_stamp[row], t.history_seq[row] = t.news.stamp, t.news.seq
        start = HISTORY0 + row * (MEASURED + 1)
        for i in range(MEASURED):
            f[start + i] = f.state[i]
        f[start + MEASURED] = 1.0 if touches(f, t) else 0.0
        t.turn.noted += 1
