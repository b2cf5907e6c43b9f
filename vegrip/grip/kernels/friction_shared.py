"""What a finger learns of friction with the others of its grasp (:mod:`vegrip.grip.grasp_friction`).

``g`` is what the grasp shares: the needs, the belief, drives, loads, slip, witness and release, one behind
the other.
"""

import math

from vegrip.estimator.elapsed import LONGEST_STEP, step_time
from vegrip.estimator.kernels.friction import HELD, SLID
from vegrip.estimator.kernels.load_law import remove_site
from vegrip.estimator.kernels.load_loss import is_load_doubted
from vegrip.estimator.kernels.sense import touches
from vegrip.grip.force_release import *
from vegrip.grip.grasp_memory import BELIEF_MOST, BELIEF_ROW, GraspMemory
from vegrip.grip.kernels.generated import *
from vegrip.grip.load_lead import *


def prepare_friction(f: Floats, t: Wholes, g: GraspMemory) -> None:
    """Write what the grasp believes into the finger's own estimate; choose margin and confidence."""
    f.asked.margin, f.asked.quantile = f.rule.wanted_margin, f.rule.quantile
    if t.setup.shares == 0:
        return
    i = t.setup.finger
    if g.belief.version != f.shared.seen:
        f.shared.seen = g.belief.version
        believe_friction(f, g, i)
    f.friction.event = 0.0
    f.shared.before_var = f.friction.var
    since_last = step_time(t.news.stamp, t.turn.learned) if t.turn.learned != 0 else 0.0
    screen_slip(f, g, i, since_last)
    if math.isnan(g.release.counted[i]):
        g.release.counted[i] = counted_on(g, i)
    counted, std = g.release.counted[i], math.sqrt(believed_variance(g, i) + NEARLY_NONE)
    f.asked.quantile = min(max((believed_mean(g, i) - counted) / std, 0.0), OUTLIER)
    more = counted - (believed_mean(g, i) - f.asked.quantile * std)
    f.asked.margin = 1.0 - (1.0 - f.rule.wanted_margin) * math.exp(g.release.shift[i] + g.witness.lack + more)


def hide_unsound(f: Floats, t: Wholes, g: GraspMemory) -> None:
    """Let slip channels that are surely wrong count as missing, which degrades the finger."""
    if t.setup.shares == 0:
        return
    f.shared.flag, f.shared.speed = f.state.slip, f.state.slip_speed
    if is_unsound(g, t.setup.finger):
        f.state.slip = math.nan
    if is_unsound(g, BELIEF_MOST + t.setup.finger):
        f.state.slip_speed = math.nan


def screen_slip(f: Floats, g: GraspMemory, i: int, dt: float) -> None:
    """Let the state have what is believed of slip: whether the finger slides, if that is known at all.

    The sign of a slip speed is its direction, which some sensors tell.
    """
    hear_slip(g, i, dt, f.shared.flag, abs(f.shared.speed))
    slides, sound = g.slip.slides[i], sound_channel(g, i)
    if sound > 0.0:
        quiet = 0.0 if sound > UNSURE and slides < EVEN else EVEN
        f.state.slip = 1.0 if slides >= SURE else quiet
    if sound < NAMED_AT:
        f.state.slip = math.nan


def restore_slip(f: Floats, t: Wholes) -> None:
    """Let the state show slip as it was sensed."""
    if t.setup.shares == 1:
        f.state.slip, f.state.slip_speed = f.shared.flag, f.shared.speed


def is_slipping(f: Floats, t: Wholes, g: GraspMemory) -> bool:
    """Return whether the finger slips: by what is believed where friction is shared, else by its flag."""
    return reacts(g, t.setup.finger) if t.setup.shares == 1 else f.state.slip >= SLIDES


def believe_friction(f: Floats, g: GraspMemory, i: int) -> None:
    """Go on from what the grasp believes, for the present loading without the evidence of it."""
    if not MU_LEARNED:
        return
    n = int(g.belief.fingers)
    f.friction.ln_mu, f.friction.exponent = g.belief.mean[i], g.belief.mean[n]
    f.friction.var = g.belief.p[i * BELIEF_ROW + i]
    f.friction.cov = g.belief.p[i * BELIEF_ROW + n]
    f.friction.exponent_var = g.belief.p[n * BELIEF_ROW + n]
    remove_site(f, g.belief.site_load[i], g.belief.site[i], g.belief.site_weighted[i])


def update_shared_friction(f: Floats, t: Wholes, g: GraspMemory) -> None:
    """Take in what the finger learned of its last state, and let probing go on."""
    if t.setup.shares == 0:
        return
    i = t.setup.finger
    dt = step_time(t.news.stamp, t.turn.learned) if t.turn.learned != 0 else 0.0
    t.turn.learned = t.news.stamp
    g.belief.since += dt / float(t.setup.fingers)
    if g.belief.since >= LONGEST_STEP:
        widen_belief(g)
    is_touching = touches(f, t)
    refer_anew(g)
    g.belief.load[i] = f.friction.load
    give_evidence(f, g, i)
    refer_anew(g)
    u, unsure = utilised_friction(f, is_touching)
    x, y = f.state.tangential_force_x, f.state.tangential_force_y
    unsure = follow_utilisation(g, i, dt, u, unsure, f.friction.load, is_touching)
    follow_forces(g, i, dt, f.state.normal_force, math.sqrt(x * x + y * y), is_touching)
    changed = watch_quiet(g, i, dt, armed_load(f, is_touching), f.shared.load_noise, is_touching)
    note_slide(g, i, unsure)
    decide(g, i, dt, f.rule.wanted_margin, is_touching, changed)
    if g.release.shift[i] <= 0.0 and t.turn.started == 1:
        f.grip.lowered_from = f.grip.held


def stated_friction(_f: Floats, t: Wholes, mu: float, std: float) -> tuple[float, float]:
    """Return the friction coefficient and its std that are stated, of those that are believed."""
    if t.setup.shares == 0 or not 0.0 < mu < math.inf:
        return mu, std
    return mu, stated_std(std / mu) * mu


def give_evidence(f: Floats, g: GraspMemory, i: int) -> None:
    """Tell the grasp what the finger's own estimate has seen since :func:`prepare_friction`: loads that held.

    Slides teach the grasp itself (:func:`~vegrip.grip.force_release.note_slide`).
    """
    if f.friction.event == HELD:
        absorb_hold(g, i, f.friction.event_ln_u, f.friction.event_noise)
    elif f.friction.event == SLID:
        refuse_evidence(g)
    elif f.friction.var > f.shared.before_var + RISE * RISE:
        widen_own(g, i, f.friction.var - f.shared.before_var)


def is_load_told(f: Floats, is_touching: bool) -> bool:
    """Return whether the contact tells what the load asks of it."""
    return is_touching and f.report.gauge > 0.0 and f.report.radius > 0.0


def utilised_friction(f: Floats, is_touching: bool) -> tuple[float, float]:
    """Return the friction coefficient at which the load would slip, and its relative std.

    NaN and inf while a part of the load is doubted.
    """
    if not is_load_told(f, is_touching) or is_load_doubted(f):
        return math.nan, math.inf
    mu = f.report.mu
    part = f.report.mu_std / mu if mu > 0.0 else 0.0
    known, noise = f.report.gauge_rel, f.report.gauge_abs / f.report.gauge
    rest = max(known * known - part * part, 0.0)
    return f.report.gauge * mu, math.sqrt(rest + noise * noise)


def armed_load(f: Floats, is_touching: bool) -> float:
    """Return the load [N], the torque in it as a force at the contact radius; NaN: not known."""
    if not is_load_told(f, is_touching):
        return math.nan
    turning = 0.0 if math.isnan(f.taken.torque) else f.taken.torque / f.report.radius
    return math.sqrt(f.taken.load * f.taken.load + turning * turning)


def load_to_answer(
    f: Floats, t: Wholes, g: GraspMemory, x: float, y: float, torque: float
) -> tuple[float, float]:
    """Return tangential force [N] and torque [N m] of a load that counts.

    They are ahead by the lag of the drive where that is told.
    """
    if t.setup.leads == 0:
        return math.sqrt(x * x + y * y), torque
    dt = step_time(t.news.stamp, t.turn.led)
    t.turn.led = t.news.stamp
    follow_drive(g, t.setup.finger, dt, followed_command(f, t), f.state.normal_force)
    return lead_load(g, t.setup.finger, dt, x, y, torque)


def followed_command(f: Floats, t: Wholes) -> float:
    """Return the command [N] that the drive follows; NaN: there is none, or it is of a fault."""
    is_following = t.turn.started == 1 and not f.grip.elapsed >= 0.0 and t.input.doubtful == 0
    return f.grip.held if is_following else math.nan
