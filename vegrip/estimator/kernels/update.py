"""One sample through everything, one compiled call."""

import math

from vegrip.estimator.kernels.consistency import PATIENCE, note_contradiction
from vegrip.estimator.kernels.displacement_loss import follow_displacement_loss
from vegrip.estimator.kernels.forecast import force_reserve, slip_times
from vegrip.estimator.kernels.friction import learn_friction
from vegrip.estimator.kernels.gap import bridge_gap
from vegrip.estimator.kernels.generated import *
from vegrip.estimator.kernels.initialisation import *
from vegrip.estimator.kernels.load_loss import follow_load, is_load_doubted
from vegrip.estimator.kernels.measure import expect_force, expect_force_alone, measure_radius
from vegrip.estimator.kernels.motion import follow_motion, predict_motion, surprise_of
from vegrip.estimator.kernels.predict import follow_extremes, predict
from vegrip.estimator.kernels.report import margin_gauge, report, utilisation
from vegrip.estimator.kernels.scalar_update import *
from vegrip.estimator.kernels.state import bound_state
from vegrip.estimator.kernels.touch_detection import detect_touch

CAUTIOUS = 0.1  # [s] after a contradiction in which nothing is learned
RESTART = 0.1  # [s] for which a channel has contradicted before the memory of the contact begins anew
LEARNED_ERROR = 1.0  # [s] over which the unexplained variance of the force is averaged
LEAST_REFUSALS = 5.0
AGREEING = 0.05  # [s]
GIVE_UP = 2.0  # [s] of contradiction after which nothing that was learned is believed any more
ZERO_MOVED = 0.1  # std of the zero of the displacement then, in radii
LARGEST = 1e50  # in SI units; its fourth power is finite
STEADY = 4.0  # times the usual spacing of samples, beyond which a pause counts as a gap


def filter_step(m: Floats, dt: float, force: float, displacement: float, radius: float) -> None:
    """Predict and measure; NaN is a channel without a measurement. Returns nothing, all is in ``m``."""
    known, felt = math.isfinite(displacement), math.isfinite(force)
    blind = m[DISPLACEMENT_AGE] > m.set.longest_gap and not known
    age_channels(m, dt)
    follow_displacement_loss(m, blind)
    if dt > m.set.longest_gap and dt > STEADY * m.mode.period:
        bridge_gap(m, dt, force, displacement)
        dt = 0.0
    predict_motion(m, dt)
    note_regime(m, dt)
    m.mode.slope = 0.0
    take_sample(m, dt, force if felt else math.nan, displacement if known else math.nan)
    detect_touch(m, force, displacement)
    if math.isfinite(radius) and radius > 0.0:
        measure_radius(m, radius)
    begin_lost_contact_anew(m, dt, force, displacement)


def age_channels(m: Floats, dt: float) -> None:
    """Time passes: since each channel was used, and for what is remembered of the innovations."""
    m.mode.health_decay = math.exp(-dt / m.set.health_time)
    m.mode.caution = max(m.mode.caution - dt, 0.0)
    for channel in range(CHANNELS):
        m.channel[CHANNEL_SIZE * channel + CH_AGE] += dt
        m.channel[CHANNEL_SIZE * channel + CH_USED] = 0.0
    if dt > 0.0:
        m.mode.period += 0.1 * (dt - m.mode.period) if m.mode.period > 0.0 else dt


def note_regime(m: Floats, dt: float) -> None:
    """Note how the tip moves, and for how long it has rested."""
    m.mode.regime = regime_of(m)
    moves = m.mode.regime == REGIME_LOADING or m.mode.regime == REGIME_UNLOADING
    m.mode.rest = 0.0 if moves else m.mode.rest + dt
    m.mode.since_jerk += dt
    m.mode.cell = cell_of(m)


def take_sample(m: Floats, dt: float, force: float, displacement: float) -> None:
    """Take in what displacement and force say together; where they contradict each other, find who lies.

    A manoeuvre, however sudden, is seen by both. Where the force contradicts the displacement, the one that
    jumped is not believed: the displacement, if the force fits the motion as it was expected, else the force.
    """
    if not math.isfinite(displacement):
        m.mode.corner = 0.0
        predict(m, dt, math.nan)
        bound_state(m)
        if m.mode.blind > 0.0 and m.y[DELTA] < 0.0:
            m.y[DELTA] = m.y[SPEED] = 0.0  # out of contact nothing shows how far
        if math.isfinite(force):
            innovation, S = expect_innovation(m, force)
            use_force(m, dt, innovation, S)
        follow_extremes(m, dt, False)
        return
    surprise = surprise_of(m, displacement)
    keep_belief(m)
    m.mode.corner = displacement - m.motion.position
    predict(m, dt, displacement)
    bound_state(m)
    if math.isfinite(force):
        innovation, S = expect_innovation(m, force)
        if innovation * innovation > GATE * S and surprise > GATE:
            if follow_if_motion_fits(m, dt, force):
                refuse_displacement(m, surprise)
                return
            return_belief(m)
            predict(m, dt, displacement)
            bound_state(m)
            innovation, S = expect_innovation(m, force)
        use_force(m, dt, innovation, S)
    use_displacement(m, dt, displacement, surprise)
    follow_extremes(m, dt, True)


def expect_innovation(m: Floats, force: float) -> tuple[float, float]:
    """Innovation of the force, and its variance."""
    return expect_force_alone(m, force) if m.mode.blind > 0.0 else expect_force(m, force)


def follow_if_motion_fits(m: Floats, dt: float, force: float) -> bool:
    """Whether the force fits the motion as it was expected, without the displacement; then it is taken in."""
    return_belief(m)
    predict(m, dt, math.nan)
    bound_state(m)
    innovation, S = expect_innovation(m, force)
    if innovation * innovation > GATE * S:
        return False
    m.mode.caution = CAUTIOUS
    use_force(m, dt, innovation, S)
    follow_extremes(m, dt, False)
    return True


def use_force(m: Floats, dt: float, innovation: float, S: float) -> None:
    """Correct by the force, or refuse it; what the model leaves unexplained counts as noise from then on."""
    nis = innovation * innovation / S
    if nis > GATE:
        m.mode.caution = CAUTIOUS
    else:
        gain = dt / (LEARNED_ERROR + dt)
        excess = innovation * innovation - (S - m.mode.tolerated)
        m.mode.unexplained = max(m.mode.unexplained + gain * (excess - m.mode.unexplained), 0.0)
    apply_measurement(m, CHANNEL_FORCE, innovation, S)


def use_displacement(m: Floats, dt: float, displacement: float, surprise: float) -> None:
    """Follow the displacement, which drives the contact already."""
    off = math.sqrt(surprise)
    record_innovation(m, CHANNEL_DISPLACEMENT, off if displacement >= m.motion.position else -off, surprise)
    follow_motion(m, displacement, dt)
    accept(m, CHANNEL_DISPLACEMENT)


def refuse_displacement(m: Floats, surprise: float) -> None:
    """Note a displacement that jumped alone."""
    record_innovation(m, CHANNEL_DISPLACEMENT, math.sqrt(surprise), surprise)
    refuse(m, CHANNEL_DISPLACEMENT)


def begin_lost_contact_anew(m: Floats, dt: float, force: float, displacement: float) -> None:
    """Begin anew what a channel has contradicted for RESTART, or a published estimate for GIVE_UP.

    At first motion, memory and zeros only: what was learned stays, and is but considered for a while, for
    the fault may be the sensor's. When that has not mended it either, everything, with a zero of the
    displacement that may have moved by a tenth of the radius.
    """
    worst = max(m[DISPLACEMENT_STREAK], m[FORCE_STREAK])
    refused = worst >= LEAST_REFUSALS and worst * m.mode.period >= RESTART
    note_lost(m, dt, refused or m.mode.contradicted > PATIENCE)
    if m.mode.lost > GIVE_UP:
        begin_all_anew(m, force, displacement)
    elif refused:
        m.counts.restarts += 1.0
        for j in (OFFSET, BIAS):
            free_coordinate(m, j, m.prior[j])
        begin_contact(m, force, displacement)
        m.mode.caution = 10.0 * CAUTIOUS
        m.mode.unexplained = 0.0
        m[DISPLACEMENT_STREAK] = m[FORCE_STREAK] = 0.0


def note_lost(m: Floats, dt: float, wrong: bool) -> None:
    """Note for how long the contact has been lost; it is found again after AGREEING without contradiction."""
    if wrong:
        m.mode.lost += dt
        m.mode.agreed = 0.0
    else:
        m.mode.agreed += dt
        if m.mode.agreed > AGREEING:
            m.mode.lost = 0.0


def begin_all_anew(m: Floats, force: float, displacement: float) -> None:
    """Begin as with the first sample."""
    m.counts.restarts += 1.0
    period = m.mode.period
    begin_filter(m, force, displacement)
    moved = ZERO_MOVED * m.set.tip_radius
    free_coordinate(m, OFFSET, moved * moved)
    begin_contact(m, force, displacement)
    m.mode.period = period
    m[DISPLACEMENT_STREAK] = m[FORCE_STREAK] = 0.0


def free_coordinate(m: Floats, j: int, variance: float) -> None:
    """Give coordinate ``j`` a ``variance`` of its own."""
    for c in range(N):
        m.p[j * N + c] = m.p[c * N + j] = 0.0
    m.p[j * N + j] = variance


def update(
    m: Floats,
    dt: float,
    force: float,
    displacement: float,
    radius: float,
    tangential: float,
    torque: float,
    slip: float,
) -> None:
    """One sample: filter, quantities, limit surface, friction. ``dt < 0`` begins."""
    force, displacement = plausible_value(force), plausible_value(displacement)
    radius, tangential = plausible_value(radius), plausible_value(tangential)
    torque = plausible_value(torque)
    if dt < 0.0:
        begin_filter(m, force, displacement)
        dt = 0.0
    filter_step(m, dt, force, displacement, radius)
    keep_finite(m)
    follow_load(m, dt, tangential, torque)
    report(m, tangential, torque)
    note_contradiction(m, dt, force, displacement, radius)
    if m.report.force <= 0.0:
        m.mode.zero_known = 1.0  # in the air: the next touch shows where zero is
    u, relative = utilisation(m)
    sound = m.report.sound > 0.0 and m.mode.contradicted == 0.0 and not is_load_doubted(m)
    learn_friction(m, dt, u, relative, slip, m.report.contact > 0.0, sound)


def plausible_value(value: float) -> float:
    """Return ``value``, NaN for one so large that its powers are infinite: no sensor measures that."""
    return value if abs(value) < LARGEST else math.nan


def margin_of(m: Floats, tangential: float, torque: float, out: Floats) -> None:
    """Fill ``out`` with gauge, its upper bound, force reserve, time to slip and its earliest."""
    out[0] = m.report.gauge
    out[1] = margin_gauge(m)
    out[2] = force_reserve(m, tangential, torque)
    chance = 0.5 * math.erfc(m.set.quantile * 0.7071067811865476)
    likely, earliest = slip_times(m, tangential, torque, chance)
    out[3], out[4] = likely, earliest
