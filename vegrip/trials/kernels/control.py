"""One sample of one finger: estimator, policy, fail-safe, balance, limits, as in :mod:`vegrip.grip`."""

import math

from vegrip.contact.limit_surface.fast import least_normal_force
from vegrip.estimator.kernels.forecast import least_force
from vegrip.estimator.kernels.report import utilisation
from vegrip.estimator.kernels.update import update
from vegrip.grip.confirmed_load import CONFIRM_SIZE, confirm_load
from vegrip.grip.drive_lag import DRIVE_IS_MEASURED, DRIVE_TOLD, follow_drive
from vegrip.grip.felt_slip import (
    believed_flag,
    believed_speed,
    judge_felt_slip,
    may_teach,
    shows_sliding,
    twist_share,
)
from vegrip.grip.friction_belief import BELIEF_FINGERS
from vegrip.grip.friction_change import follow_level
from vegrip.grip.friction_onset import feel_onset
from vegrip.grip.friction_probe import PROBE_NEED, feel_slip, watch_load
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
from vegrip.trials.kernels.generated import (
    CH_USED,
    CHANNEL0,
    FRI_LN_MU,
    FRI_VAR,
    G_BELIEVED,
    G_BELIEVED_VAR,
    G_COMMAND,
    G_CONE,
    G_CONFIRMED,
    G_CONSTANT,
    G_DEAD_BAND,
    G_ELASTIC,
    G_ENVELOPE,
    G_FAIL_FORCE,
    G_FAIL_HOLD,
    G_FAIL_RAMP,
    G_FAULTY,
    G_FIRST_ARM,
    G_FIRST_FORCE,
    G_FIRST_LOAD,
    G_INFORMED,
    G_KNOWN,
    G_LEARNS,
    G_LIFETIME,
    G_LONGEST_GAP,
    G_LOWER_RATE,
    G_MARGIN,
    G_MAX_FORCE,
    G_MIN_FORCE,
    G_POLICY,
    G_PROVEN,
    G_PROVEN_TIME,
    G_QUANTILE,
    G_QUANTILE_KNOWN,
    G_QUIET,
    G_RAISE_RATE,
    G_RECOVERY,
    G_RELEASE_TIME,
    G_REQUIRED,
    G_SAMPLES,
    G_SETTLE_TIME,
    G_SINCE_LED,
    G_SLIP_GROWTH,
    G_SLOT,
    G_SLOT_FILLED,
    G_SLOT_MEDIAN,
    G_SLOT_PRESENT,
    G_SLOTS,
    G_SLOTS_USED,
    G_SORTED,
    G_TRANSFER,
    H_FORCE,
    H_K,
    H_MU,
    H_RADIUS,
    HAND_FINGERS,
    REP_CONTACT,
    REP_FORCE,
    REP_FORCE_STD,
    REP_RADIUS,
    REP_SOUND,
    SET_S_TANGENTIAL,
    SET_S_TORQUE,
    SLOT_COUNT,
    Floats,
)
from vegrip.trials.kernels.learning import give_evidence, take_belief

LONGEST_STEP = 0.1  # [s], as finger.LONGEST_STEP_S
LEAST_SLIDING = 2e-4  # [m/s], as estimator.LEAST_SLIP_SPEED
TRANSFER_TIME = 0.3  # [s], as in grip.kernels.takeover


def reset_policy(h: Floats, i: int) -> None:
    """Forget the past of the policy."""
    h[G_ENVELOPE + i] = math.nan
    h[G_QUIET + i] = 0.0
    h[G_SLOTS_USED + i] = h[G_SLOT_FILLED + i] = 0.0
    h[G_SLOT_PRESENT + i] = h[G_SLOT_MEDIAN + i] = -math.inf
    h[G_PROVEN + i] = math.inf


def usual_need(h: Floats, i: int, need: float, dt: float) -> float:
    """Return the median of the largest needs [N] of the last slots of time."""
    if h[G_SLOT] <= 0.0:
        return need
    h[G_SLOT_PRESENT + i] = max(h[G_SLOT_PRESENT + i], need)
    h[G_SLOT_FILLED + i] += dt
    used = int(h[G_SLOTS_USED + i])
    half = SLOT_COUNT // 2
    if h[G_SLOT_FILLED + i] >= h[G_SLOT]:
        first = G_SLOTS + i * SLOT_COUNT
        if used == SLOT_COUNT:
            for j in range(SLOT_COUNT - 1):
                h[first + j] = h[first + j + 1]
            used -= 1
        h[first + used] = h[G_SLOT_PRESENT + i]
        used += 1
        h[G_SLOTS_USED + i] = used * 1.0
        h[G_SLOT_PRESENT + i] = -math.inf
        h[G_SLOT_FILLED + i] = 0.0
        sort_needs(h, first, used)
        h[G_SLOT_MEDIAN + i] = h[G_SORTED + used // 2] if used > half else h[G_SORTED + used - 1]
        if used > half:
            prove_need(h, i)
    if used <= half:
        return float(max(h[G_SLOT_MEDIAN + i], need))
    return float(min(h[G_SLOT_MEDIAN + i], h[G_PROVEN + i]))


def prove_need(h: Floats, i: int) -> None:
    """Keep the lowest need that was usual, and let it rise to the present one within PROVEN_TIME."""
    usual = h[G_SLOT_MEDIAN + i]
    if h[G_PROVEN_TIME] > 0.0:
        proven = h[G_PROVEN + i]
        rise = min(h[G_SLOT] / h[G_PROVEN_TIME], 1.0) * (usual - proven) if proven < usual else 0.0
        h[G_PROVEN + i] = min(usual, proven + rise)


def sort_needs(h: Floats, first: int, used: int) -> None:
    """Put the slots of a finger in order into the scratch section."""
    for j in range(used):
        value = h[first + j]
        at = j
        while at > 0 and h[G_SORTED + max_of(at - 1, 0)] > value:
            h[G_SORTED + at] = h[G_SORTED + at - 1]
            at -= 1
        h[G_SORTED + at] = value


def max_of(a: int, b: int) -> int:
    """Return the larger number."""
    return a if a > b else b


def informed_age(m: Floats, h: Floats, i: int, dt: float) -> float:
    """Return for how long no measurement of force or displacement was used [s]."""
    if m[CHANNEL0 + CH_USED] > 0.0 or m[CHANNEL0 + 4 + CH_USED] > 0.0:
        h[G_INFORMED + i] = 0.0
    else:
        h[G_INFORMED + i] += max(dt, 0.0)
    return float(h[G_INFORMED + i])


def control_finger(
    m: Floats,
    h: Floats,
    g: Floats,
    q: Floats,
    i: int,
    dt: float,
    force: float,
    displacement: float,
    x: float,
    y: float,
    torque: float,
    slip: float,
    slip_speed: float,
) -> None:
    """Take one sample of finger ``i``; find what it needs and what it is commanded."""
    tangential = math.sqrt(x * x + y * y)
    sensed_slip, sensed_speed = slip, slip_speed
    learns = h[G_LEARNS] > 0.5
    if learns:
        slip = present_slip(q, i, believed_flag(q, i, slip))
        slip_speed = present_slip(q, i, believed_speed(q, i, slip_speed))
    believed = math.nan if slip >= 0.5 and slip_speed < LEAST_SLIDING else slip
    first = count_sample(h, i, dt)
    if learns:
        take_belief(m, h, g, i)
    ln, variance = m[FRI_LN_MU], m[FRI_VAR]
    update(m, -1.0 if first else dt, force, displacement, math.nan, tangential, torque, believed)
    age = informed_age(m, h, i, dt)
    valid = age <= h[G_LONGEST_GAP] and m[REP_SOUND] > 0.5
    slipping = slip >= 0.5 or (learns and shows_sliding(q, slip_speed) and not awaits_flag(q, i))
    touching = m[REP_CONTACT] > 0.5
    at, shift = h[G_QUANTILE], 0.0
    if learns:
        if counts_as_known(g, q, i):
            at = h[G_QUANTILE_KNOWN]
        shift = counted_shift(g, q, i, at)
    margin = 1.0 - (1.0 - h[G_MARGIN]) * math.exp(shift)
    if not touching:
        least = 0.0
        trusted = valid and abs(m[REP_FORCE] + m[REP_FORCE_STD]) < math.inf
    else:
        least = math.nan
        if h[G_POLICY] == 0.0 and valid:
            ahead, turn = load_ahead(m, h, q, i, force, x, y, torque)
            least = needed_force(m, h, i, ahead, turn, margin, at)
        trusted = not math.isnan(least)
    if first:
        start = force if not math.isnan(force) else 0.0
        h[G_COMMAND + i] = h[G_REQUIRED + i] = clamped(h, start)
        reset_policy(h, i)
        h[G_FAULTY + i] = -math.inf
        h[G_FIRST_FORCE + i], h[G_FIRST_ARM + i] = h[G_REQUIRED + i], m[REP_RADIUS]
        h[G_FIRST_LOAD + i] = armed_load(tangential, torque, m[REP_RADIUS])
        h[G_TRANSFER + i] = 0.0
    elif h[G_TRANSFER + i] >= 0.0:
        h[G_TRANSFER + i] += dt
    least = taken_over(h, i, least, armed_load(tangential, torque, h[G_FIRST_ARM + i]), slipping)
    require(h, i, 0.0 if first else dt, least, tangential, torque, touching, slipping, trusted)
    command_finger(h, i, dt if not first else 0.0)
    h[G_BELIEVED + i], h[G_BELIEVED_VAR + i] = (
        (m[FRI_LN_MU], m[FRI_VAR]) if touching else (math.nan, math.nan)
    )
    if learns:
        step = 0.0 if first else dt
        learn_friction_of(
            m,
            h,
            g,
            q,
            i,
            step,
            ln,
            variance,
            force,
            tangential,
            torque,
            sensed_slip,
            sensed_speed,
            at,
            margin,
        )


def count_sample(h: Floats, i: int, dt: float) -> bool:
    """Count a sample of finger ``i`` that comes ``dt`` [s] after the last; return whether it is the first."""
    h[G_SINCE_LED + i] += dt
    h[G_SAMPLES + i] += 1.0
    return bool(h[G_SAMPLES + i] == 1.0)


def load_ahead(
    m: Floats, h: Floats, q: Floats, i: int, force: float, x: float, y: float, torque: float
) -> tuple[float, float]:
    """Return the load of finger ``i`` that counts: ahead by the drive's lag where it is known.

    Only a finger that touches answers its load, so the filters rest in the air, as they do in the node.
    """
    at, noise, torque_noise = G_CONFIRMED + CONFIRM_SIZE * i, m[SET_S_TANGENTIAL], m[SET_S_TORQUE]
    x, y, torque = confirm_load(h, at, x, y, torque, noise, torque_noise)
    if q[DRIVE_TOLD] > 0.0 or q[DRIVE_IS_MEASURED] > 0.5:
        since, h[G_SINCE_LED + i] = min(h[G_SINCE_LED + i], LONGEST_STEP), 0.0
        follow_drive(q, i, since, h[G_COMMAND + i] if h[G_FAULTY + i] < 0.0 else math.nan, force)
        return lead_load(q, i, since, x, y, torque)
    return math.sqrt(x * x + y * y), torque


def needed_force(
    m: Floats, h: Floats, i: int, tangential: float, torque: float, margin: float, at: float
) -> float:
    """Return the least force [N] of finger ``i``, by its estimate or by the truth."""
    if h[G_KNOWN] > 0.5:
        return known_force(h, i, tangential, torque)
    return float(least_force(m, tangential, torque, margin, at))


def known_force(h: Floats, i: int, tangential: float, torque: float) -> float:
    """Return the least force [N] of finger ``i`` that keeps the margin, by the truth."""
    if not (h[H_FORCE + i] > 0.0 and h[H_RADIUS + i] > 0.0):
        return 0.0 if tangential + torque == 0.0 else math.inf
    mu = h[H_MU + i] * (1.0 - h[G_MARGIN])
    return float(
        least_normal_force(
            tangential, abs(torque), mu, h[H_RADIUS + i], h[H_K + i], h[H_FORCE + i], 1.0 / 3.0, 0.0
        )
    )


def learn_friction_of(
    m: Floats, h: Floats, g: Floats, q: Floats, i: int, step: float, ln: float, variance: float,
    force: float, tangential: float, torque: float, slip: float, slip_speed: float, at: float,
    asked: float,
) -> None:  # fmt: skip
    """Take into the belief of the grasp what finger ``i`` has just learned, and let probing go on."""
    believed, fast = believed_flag(q, i, slip), believed_speed(q, i, slip_speed)
    is_evidence = may_teach(q, i)
    give_evidence(m, h, g, i, step, ln, variance, believed >= 0.5 and (is_late(q) or not is_evidence))
    u, relative = utilisation(m)
    u *= math.exp(ln - m[FRI_LN_MU])
    vague = relative if is_evidence else math.inf
    feel_onset(g, q, i, step, recall_load(q, i, step, u), vague, believed, fast)
    q[PROBE_NEED + i] = h[G_REQUIRED + i]
    load = armed_load(tangential, torque, m[REP_RADIUS])
    noise, touching = m[SET_S_TANGENTIAL], m[REP_CONTACT] > 0.5
    watch_load(q, i, step, load, noise, touching)
    slides = ends_probe(q, i, step, believed >= 0.5, shows_sliding(q, fast))
    follow_trust(g, q, i, step, believed, slip_speed, u, relative, force, tangential, noise, touching)
    feel_slip(q, step, int(g[BELIEF_FINGERS]), slides)
    let_go(g, q, i, step, at, asked, u, noise, touching, slides)
    judge_felt_slip(q, i, step, slip, slip_speed, u, twist_share(tangential, load))
    follow_level(g, q, i, step)


def armed_load(tangential: float, torque: float, arm: float) -> float:
    """Return the load [N] with the torque as a force at ``arm`` [m]."""
    turning = abs(torque) / arm if arm > 0.0 else 0.0
    return math.hypot(tangential, 0.0 if math.isnan(turning) else turning)


def taken_over(h: Floats, i: int, least: float, load: float, slipping: bool) -> float:
    """Bound the least force [N] by what was held when the contact was met."""
    elapsed = h[G_TRANSFER + i]
    if elapsed < 0.0:
        return least
    if slipping or elapsed >= TRANSFER_TIME:
        h[G_TRANSFER + i] = -1.0
        return least
    growth = 1.0
    if h[G_FIRST_LOAD + i] > 0.0:
        growth = max(1.0, load / h[G_FIRST_LOAD + i])
    elif load > 0.0:
        growth = math.inf
    held = h[G_FIRST_FORCE + i] * growth * growth
    ramped = min(h[G_FIRST_FORCE + i] + h[G_FAIL_RAMP] * elapsed, h[G_FAIL_FORCE])
    bound = max(held, ramped)
    return bound if bound < least else least


def clamped(h: Floats, force: float) -> float:
    """Return ``force`` [N] within the limits."""
    return float(min(max(h[G_MIN_FORCE], force), h[G_MAX_FORCE]))


def require(
    h: Floats,
    i: int,
    dt: float,
    least: float,
    tangential: float,
    torque: float,
    touching: bool,
    slipping: bool,
    trusted: bool,
) -> None:
    """Find what finger ``i`` needs on its own; its first samples are not believed yet, as by the watchdog."""
    if h[G_SAMPLES + i] < h[G_RECOVERY]:
        ride_out(h, i, dt)
        return
    active = h[G_FAULTY + i] >= 0.0
    base = h[G_COMMAND + i] if slipping or active else h[G_REQUIRED + i]
    force = math.nan
    if h[G_POLICY] == 0.0:
        force = margin_force(h, i, base, dt, least, touching, slipping, trusted)
    elif h[G_POLICY] == 1.0:
        force = h[G_CONSTANT]
    elif h[G_POLICY] == 2.0:
        force = h[G_CONE] * tangential
    else:
        moment = 0.0 if math.isnan(torque) else torque
        e = G_ELASTIC
        force = (1.0 + h[e + 1]) * least_normal_force(
            tangential, abs(moment), h[e], h[e + 2], h[e + 4], 1.0, h[e + 3], 0.0
        )
    if math.isnan(force):
        ride_out(h, i, dt)
        return
    h[G_FAULTY + i] = -math.inf
    h[G_REQUIRED + i] = clamped(h, force)


def ride_out(h: Floats, i: int, dt: float) -> None:
    """Hold, then ramp to the fail-safe grip."""
    safe = max(h[G_COMMAND + i], h[G_REQUIRED + i])
    reset_policy(h, i)
    h[G_FAULTY + i] = h[G_FAULTY + i] + dt if h[G_FAULTY + i] >= 0.0 else 0.0
    if h[G_FAULTY + i] < h[G_FAIL_HOLD] or safe >= h[G_FAIL_FORCE]:
        h[G_REQUIRED + i] = safe
    else:
        h[G_REQUIRED + i] = min(safe + h[G_FAIL_RAMP] * dt, h[G_FAIL_FORCE])


def margin_force(
    h: Floats, i: int, held: float, dt: float, least: float, touching: bool, slipping: bool, trusted: bool
) -> float:
    """Return what the margin grip wants [N]; NaN where it does not trust the demand."""
    if slipping:
        need = least if trusted else 0.0
        h[G_ENVELOPE + i] = max(held * (1.0 + h[G_SLIP_GROWTH] * dt), need)
        h[G_QUIET + i] = 0.0
        return float(h[G_ENVELOPE + i])
    if not trusted:
        return math.nan
    need = least if touching else 0.0
    envelope = h[G_ENVELOPE + i]
    before = held if math.isnan(envelope) else min(held, envelope)
    usual = usual_need(h, i, need, dt)
    floor = max(need, min(usual, before))
    h[G_QUIET + i] = 0.0 if need > before else h[G_QUIET + i] + dt
    if need > before or h[G_QUIET + i] < h[G_SETTLE_TIME]:
        envelope = max(need, before)
    else:
        envelope = floor + (before - floor) * math.exp(-dt / h[G_RELEASE_TIME])
    h[G_ENVELOPE + i] = envelope
    if envelope > held:
        return envelope
    upper = envelope / (1.0 - h[G_DEAD_BAND])
    return upper if upper < held else held


def command_finger(h: Floats, i: int, dt: float) -> None:
    """Balance the needs about the first finger, and pass the limits."""
    required = h[G_REQUIRED + i]
    wanted = required if h[G_FAULTY + i] >= 0.0 else max(balanced_share(h, i), required)
    held = h[G_COMMAND + i]
    dt = min(dt, h[G_LIFETIME])
    reachable = min(max(wanted, held - h[G_LOWER_RATE] * dt), held + h[G_RAISE_RATE] * dt)
    h[G_COMMAND + i] = clamped(h, reachable)


def balanced_share(h: Floats, i: int) -> float:
    """Return the share of finger ``i`` [N] when all that have begun balance about the first one."""
    pressed, others = 0.0, 0.0
    for j in range(1, HAND_FINGERS):
        if h[G_SAMPLES + j] > 0.0:
            pressed += h[G_REQUIRED + j]
            others += 1.0
    if others == 0.0 or h[G_SAMPLES] == 0.0:
        return float(h[G_REQUIRED + i])
    total = max(h[G_REQUIRED], pressed)
    if i == 0:
        return float(total)
    return float(total * (h[G_REQUIRED + i] / pressed) if pressed > 0.0 else total / others)
