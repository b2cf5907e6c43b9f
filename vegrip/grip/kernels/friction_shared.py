"""What a finger learns of friction with the others of its grasp (:mod:`vegrip.grip.grasp_friction`).

``g`` is what the grasp shares: the needs, the belief, probing, onsets and loads, one behind the other.
"""

import math

from vegrip.estimator.elapsed import elapsed_time
from vegrip.estimator.kernels.load_loss import is_load_doubted
from vegrip.grip.drive_lag import follow_drive
from vegrip.grip.felt_slip import (
    believed_flag,
    believed_speed,
    judge_felt_slip,
    may_teach,
    shows_sliding,
    twist_share,
)
from vegrip.grip.friction_belief import (
    BELIEF_MEAN,
    BELIEF_SINCE,
    BELIEF_VERSION,
    absorb_evidence,
    believed_variance,
    refuse_evidence,
    widen_own,
)
from vegrip.grip.friction_change import CHANGE_LEVEL, CHANGE_SPREAD, follow_level, stated_friction
from vegrip.grip.friction_onset import feel_onset
from vegrip.grip.friction_probe import PROBE_NEED, feel_slip, watch_load
from vegrip.grip.kernels.generated import (
    ASKED_MARGIN,
    ASKED_QUANTILE,
    FRI_BASE_LN,
    FRI_BASE_VAR,
    FRI_LN_MU,
    FRI_VAR,
    GRIP_ELAPSED,
    GRIP_HELD,
    GRIP_REQUIRED,
    INPUT_DOUBTFUL,
    MU_LEARNED,
    NEWS_STAMP,
    REP_GAUGE,
    REP_GAUGE_ABS,
    REP_GAUGE_REL,
    REP_MU,
    REP_MU_STD,
    REP_RADIUS,
    RULE_QUANTILE,
    RULE_WANTED_MARGIN,
    SETUP_FINGER,
    SETUP_FINGERS,
    SETUP_LEADS,
    SETUP_SHARES,
    SHARED_BEFORE,
    SHARED_BEFORE_VAR,
    SHARED_FLAG,
    SHARED_KNOWN_QUANTILE,
    SHARED_LEVEL,
    SHARED_LOAD_NOISE,
    SHARED_SEEN,
    SHARED_SITE,
    SHARED_SITE_WEIGHTED,
    SHARED_SPEED,
    SHARED_SPREAD,
    SHARED_UNKNOWN,
    SHARED_WIDEST,
    SLIDES,
    STATE_NORMAL_FORCE,
    STATE_SLIP,
    STATE_SLIP_SPEED,
    STATE_TANGENTIAL_FORCE_X,
    STATE_TANGENTIAL_FORCE_Y,
    TAKEN_LOAD,
    TAKEN_TORQUE,
    TURN_LEARNED,
    TURN_LED,
    TURN_STARTED,
    Floats,
    Wholes,
)
from vegrip.grip.kernels.sense import touches
from vegrip.grip.late_slip import is_late, present_slip, recall_load
from vegrip.grip.load_lead import lead_load
from vegrip.grip.slip_trust import (
    awaits_flag,
    counted_shift,
    counts_as_known,
    ends_probe,
    follow_trust,
    let_go,
)

LONGEST_STEP = 0.1  # [s]; a longer pause between two states counts as so much
NEW_CONTACT = 1e-4  # growth of the variance of ln mu between two states that only a new contact brings


def prepare_friction(f: Floats, t: Wholes, g: Floats) -> None:
    """Write what the grasp believes into the finger's own estimate; choose margin and confidence."""
    f[ASKED_MARGIN], f[ASKED_QUANTILE] = f[RULE_WANTED_MARGIN], f[RULE_QUANTILE]
    if t[SETUP_SHARES] == 0:
        return
    i = t[SETUP_FINGER]
    if f[FRI_LN_MU] == f[FRI_BASE_LN] and f[FRI_VAR] == f[FRI_BASE_VAR]:
        f[SHARED_SITE] = f[SHARED_SITE_WEIGHTED] = 0.0
    if g[BELIEF_VERSION] != f[SHARED_SEEN]:
        f[SHARED_SEEN] = g[BELIEF_VERSION]
        believe_friction(f, g[BELIEF_MEAN + i], believed_variance(g, i))
    f[SHARED_BEFORE], f[SHARED_BEFORE_VAR] = f[FRI_LN_MU], f[FRI_VAR]
    screen_slip(f, g, i)
    if counts_as_known(g, g, i):
        f[ASKED_QUANTILE] = f[SHARED_KNOWN_QUANTILE]
    shift = counted_shift(g, g, i, f[ASKED_QUANTILE])
    f[ASKED_MARGIN] = 1.0 - (1.0 - f[RULE_WANTED_MARGIN]) * math.exp(shift)


def screen_slip(f: Floats, g: Floats, i: int) -> None:
    """Let the state have what is believed of slip.

    What the load has shown to be wrong counts as not sensed, and a slide that is over as none.
    """
    f[SHARED_FLAG], f[SHARED_SPEED] = f[STATE_SLIP], f[STATE_SLIP_SPEED]
    f[STATE_SLIP] = present_slip(g, i, believed_flag(g, i, f[STATE_SLIP]))
    f[STATE_SLIP_SPEED] = present_slip(g, i, believed_speed(g, i, f[STATE_SLIP_SPEED]))


def restore_slip(f: Floats, t: Wholes) -> None:
    """Let the state show slip as it was sensed."""
    if t[SETUP_SHARES] == 1:
        f[STATE_SLIP], f[STATE_SLIP_SPEED] = f[SHARED_FLAG], f[SHARED_SPEED]


def is_slipping(f: Floats, t: Wholes, g: Floats) -> bool:
    """Return whether the finger slips by its flag, or by its speed where friction is shared."""
    if f[STATE_SLIP] >= SLIDES or t[SETUP_SHARES] == 0:
        return f[STATE_SLIP] >= SLIDES
    return shows_sliding(g, f[STATE_SLIP_SPEED]) and not awaits_flag(g, t[SETUP_FINGER])


def believe_friction(f: Floats, mean: float, variance: float) -> None:
    """Go on from this belief, and for the present loading from the same without its own evidence."""
    if not MU_LEARNED:
        return
    f[FRI_LN_MU] = f[FRI_BASE_LN] = mean
    f[FRI_VAR] = f[FRI_BASE_VAR] = variance
    left = 1.0 / variance - f[SHARED_SITE] if variance > 0.0 else 0.0
    if f[SHARED_SITE] != 0.0 and left > 1.0 / f[SHARED_WIDEST]:
        f[FRI_BASE_LN] = (mean / variance - f[SHARED_SITE_WEIGHTED]) / left
        f[FRI_BASE_VAR] = 1.0 / left


def update_shared_friction(f: Floats, t: Wholes, g: Floats) -> None:
    """Take in what the finger learned of its last state, and let probing go on."""
    if t[SETUP_SHARES] == 0:
        return
    i = t[SETUP_FINGER]
    dt = since(t[NEWS_STAMP], t[TURN_LEARNED]) if t[TURN_LEARNED] != 0 else 0.0
    t[TURN_LEARNED] = t[NEWS_STAMP]
    g[BELIEF_SINCE] += dt / float(t[SETUP_FINGERS])
    is_touching = touches(f, t)
    slip, speed = believed_flag(g, i, f[SHARED_FLAG]), believed_speed(g, i, f[SHARED_SPEED])
    is_evidence = may_teach(g, i)
    give_evidence(f, g, i, slip >= SLIDES and (is_late(g) or not is_evidence))
    u, relative = utilised_friction(f, is_touching)
    vague = relative if is_evidence else math.inf
    feel_onset(g, g, i, dt, recall_load(g, i, dt, u), vague, slip, speed)
    g[PROBE_NEED + i] = f[GRIP_REQUIRED]
    load = armed_load(f, is_touching)
    watch_load(g, i, dt, load, f[SHARED_LOAD_NOISE], is_touching)
    noise, slides = f[SHARED_LOAD_NOISE], ends_probe(g, i, dt, slip >= SLIDES, shows_sliding(g, speed))
    x, y = f[STATE_TANGENTIAL_FORCE_X], f[STATE_TANGENTIAL_FORCE_Y]
    pull = math.sqrt(x * x + y * y)
    follow_trust(
        g, g, i, dt, slip, f[SHARED_SPEED], u, relative, f[STATE_NORMAL_FORCE], pull, noise, is_touching
    )
    feel_slip(g, dt, t[SETUP_FINGERS], slides)
    let_go(g, g, i, dt, f[ASKED_QUANTILE], f[ASKED_MARGIN], u, noise, is_touching, slides)
    twist = twist_share(pull, load)
    judge_felt_slip(g, i, dt, f[SHARED_FLAG], f[SHARED_SPEED], u, twist)
    follow_level(g, g, i, dt)
    f[SHARED_LEVEL], f[SHARED_SPREAD] = g[CHANGE_LEVEL + i], g[CHANGE_SPREAD + i]


def told_friction(f: Floats, t: Wholes, mu: float, std: float) -> tuple[float, float]:
    """Return the friction coefficient and its std that are told, of those that are believed."""
    if t[SETUP_SHARES] == 0 or not 0.0 < mu < math.inf:
        return mu, std
    level, spread, unknown = f[SHARED_LEVEL], f[SHARED_SPREAD], f[SHARED_UNKNOWN]
    mean, relative = stated_friction(math.log(mu), std / mu, level, spread, unknown)
    told = math.exp(mean)
    return told, told * relative


def give_evidence(f: Floats, g: Floats, i: int, refused: bool) -> None:
    """Tell the grasp what the finger's own estimate has learned since :func:`prepare_friction`.

    Of slip that is felt late it learns by the wrong load, and a flag that was never silent is no evidence:
    both are ``refused``.
    """
    mean, variance = f[SHARED_BEFORE], f[SHARED_BEFORE_VAR]
    if f[FRI_LN_MU] == mean:
        if f[FRI_VAR] > variance + NEW_CONTACT:
            widen_own(g, i, f[FRI_VAR])
        return
    if refused:
        refuse_evidence(g)
    elif variance > 0.0 and f[FRI_VAR] > 0.0:
        f[SHARED_SITE] += 1.0 / f[FRI_VAR] - 1.0 / variance
        weighted = f[SHARED_SITE_WEIGHTED] + f[FRI_LN_MU] / f[FRI_VAR]
        f[SHARED_SITE_WEIGHTED] = weighted - mean / variance
        absorb_evidence(g, i, mean, variance, f[FRI_LN_MU], f[FRI_VAR])


def is_load_told(f: Floats, is_touching: bool) -> bool:
    """Return whether the contact tells what the load asks of it."""
    return is_touching and f[REP_GAUGE] > 0.0 and f[REP_RADIUS] > 0.0


def utilised_friction(f: Floats, is_touching: bool) -> tuple[float, float]:
    """Return the friction coefficient at which the load would slip, and its relative std.

    NaN and inf while a part of the load is doubted.
    """
    if not is_load_told(f, is_touching) or is_load_doubted(f):
        return math.nan, math.inf
    mu = f[REP_MU]
    part = f[REP_MU_STD] / mu if mu > 0.0 else 0.0
    known, noise = f[REP_GAUGE_REL], f[REP_GAUGE_ABS] / f[REP_GAUGE]
    rest = max(known * known - part * part, 0.0)
    return f[REP_GAUGE] * mu, math.sqrt(rest + noise * noise)


def armed_load(f: Floats, is_touching: bool) -> float:
    """Return the load [N], the torque in it as a force at the contact radius; NaN: not known."""
    if not is_load_told(f, is_touching):
        return math.nan
    turning = 0.0 if math.isnan(f[TAKEN_TORQUE]) else f[TAKEN_TORQUE] / f[REP_RADIUS]
    return math.sqrt(f[TAKEN_LOAD] * f[TAKEN_LOAD] + turning * turning)


def load_to_answer(f: Floats, t: Wholes, g: Floats, x: float, y: float, torque: float) -> tuple[float, float]:
    """Return tangential force [N] and torque [N m] of a load that counts.

    They are ahead by the lag of the drive where that is told.
    """
    if t[SETUP_LEADS] == 0:
        return math.sqrt(x * x + y * y), torque
    dt = since(t[NEWS_STAMP], t[TURN_LED])
    t[TURN_LED] = t[NEWS_STAMP]
    follow_drive(g, t[SETUP_FINGER], dt, followed_command(f, t), f[STATE_NORMAL_FORCE])
    return lead_load(g, t[SETUP_FINGER], dt, x, y, torque)


def followed_command(f: Floats, t: Wholes) -> float:
    """Return the command [N] that the drive follows; NaN: there is none, or it is of a fault."""
    is_following = t[TURN_STARTED] == 1 and not f[GRIP_ELAPSED] >= 0.0 and t[INPUT_DOUBTFUL] == 0
    return f[GRIP_HELD] if is_following else math.nan


def since(stamp: int, before: int) -> float:
    """Return the time between two states [s], as far as it counts."""
    return min(max(float(elapsed_time(stamp, before)) / 1e9, 0.0), LONGEST_STEP)
