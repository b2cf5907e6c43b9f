"""What a compiled trial starts from: settings and tables in place, burdens by tick, noise by sample."""

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from vegrip.estimator.layout import friction_symbol
from vegrip.grip.drive_lag import begin_drives, tell_drives
from vegrip.grip.felt_slip import begin_felt_slip
from vegrip.grip.friction_belief import BELIEF_SIZE, begin_belief, expect_finger
from vegrip.grip.friction_change import begin_changes
from vegrip.grip.friction_onset import begin_onsets
from vegrip.grip.friction_probe import begin_probing
from vegrip.grip.joint_confidence import FINGER_CORRELATION, shared_part
from vegrip.grip.late_slip import begin_late_slip
from vegrip.grip.load_lead import begin_lead
from vegrip.grip.parameters import GraspParameters
from vegrip.grip.slip_trust import TRUST_SIZE, begin_trust
from vegrip.model import ContactModel
from vegrip.trials.layout import FLAGS, SLOTS, TrialLayout
from vegrip.types import Floats
from vegrip.virtual import Disturbance, HandSettings, profile
from vegrip.virtual.disturbance import burden_rows
from vegrip.virtual.hand import CLEARANCE_M
from vegrip.virtual.patch import even_grid
from vegrip.virtual.sensor import Sensors
from vegrip.virtual.settings import FingertipSettings

SLIP_CHANNELS = {"absent": 0.0, "sound": 1.0, "dead": 2.0, "stuck": 3.0, "noisy": 1.0}
"""Codes of slip channels by name.

dead: flag and speed are 0, whatever slides; stuck: they say slip, whatever holds; noisy: 2 % of the flags are
wrong, and the speed has the noise below besides."""

WRONG_FLAGS, SPEED_NOISE_M_S = 0.02, 2e-3  # of a noisy slip channel

POLICIES = {"margin": 0.0, "constant": 1.0, "cone": 2.0, "elastic": 3.0}


def hand_memory(
    layout: TrialLayout, settings: HandSettings, seed: int, period: float, slip_channel: str
) -> Floats:
    """Return the array of a hand at time zero, the control in it still unset."""
    h = np.zeros(layout.size)
    at = layout.places()
    tips = settings.tips(np.random.default_rng([seed, 0]))
    drives, plate, sensor = settings.actuator, settings.plate, settings.sensor
    grid = even_grid(settings.rings, settings.spokes)
    scalars: dict[str, ArrayLike] = {
        "STEP": settings.step, "FORCE_LIMIT": drives.force_limit, "FORCE_RATE": drives.force_rate,
        "BANDWIDTH": drives.bandwidth, "DRIVE_SPEED": drives.speed, "STICTION": drives.stiction,
        "INITIAL_FORCE": drives.initial_force, "CLOSE_TIME": drives.close_time,
        "LIFT_TIME": drives.lift_time, "MASS": plate.mass, "INERTIA": plate.inertia,
        "GRAVITY": plate.gravity, "FAR_LOST": plate.drop_distance, "ANGLE_LOST": plate.drop_angle,
        "SAMPLE_TIME": period, "SLIP_SENSOR": SLIP_CHANNELS[slip_channel if sensor.slip_sensor else "absent"],
        "SLIP_THRESHOLD": sensor.slip_threshold,
        "SLIP_DELAY": min(round(sensor.slip_delay / period), FLAGS - 1),
    }  # fmt: skip
    fingers: dict[str, ArrayLike] = {
        "D0": [tip.reference_indentation for tip in tips], "POWER": [tip.exponent for tip in tips],
        "FORCE_SCALE": [tip.reference_force for tip in tips], "TIP_RADIUS": [tip.radius for tip in tips],
        "FINAL": [1.0 - sum(tip.amplitudes) for tip in tips], "K": profile.HERTZ,
        "INSTANT": [1.0 - sum(_lost(tip, settings.step)) for tip in tips],
        "MU": [tip.friction for tip in tips], "MU_DRY": [tip.friction for tip in tips],
        "STIFFNESS": [tip.bristle_stiffness for tip in tips],
        "DAMPING": [tip.bristle_damping for tip in tips],
        "DRIVE": [0.0, *[-CLEARANCE_M] * (len(tips) - 1)], "TARGET": math.nan, "COMMAND": math.nan,
        "BRANCH_DECAY": [math.exp(-nu * settings.step) for tip in tips for nu in tip.rates],
        "BRANCH_SHARE": [
            c * _mean_decay(nu * settings.step)
            for tip in tips
            for c, nu in zip(tip.amplitudes, tip.rates, strict=True)
        ],
        "STEPS": [sensor.force_step, sensor.torque_step, sensor.displacement_step],
        "POSE": [plate.offset_x, plate.offset_y, 0.0, 0.0, 0.0, 0.0],
        "START": [plate.offset_x, plate.offset_y, 0.0],
        "PLACE": np.column_stack([settings.x, settings.y]).ravel(),
        "REACH": grid.reach, "AREA": grid.area, "COSINE": grid.cosine, "SINE": grid.sine,
        "EXPONENT_TABLE": profile.coefficient_logarithms(),
        "RING_TABLE": (profile.ring_shares(grid.edges) / grid.spokes).ravel(),
    }  # fmt: skip
    for name, value in (scalars | fingers).items():
        h[at[f"H_{name}"]] = np.asarray(value, float)
    return h


def _mean_decay(x: float) -> float:
    """Return (1 - exp(-x)) / x."""
    return -math.expm1(-x) / x


def _lost(tip: FingertipSettings, step: float) -> list[float]:
    """Return how much of an increment each branch has lost by the end of its step [-]."""
    return [c * (1.0 - _mean_decay(nu * step)) for c, nu in zip(tip.amplitudes, tip.rates, strict=True)]


def set_control(
    h: Floats, layout: TrialLayout, settings: GraspParameters, at_quantile: float, known_quantile: float
) -> None:
    """Write the control's settings into ``h``; nothing has been sensed yet."""
    at, grip, limits = layout.places(), settings.grip, settings.limits
    safe, elastic, cone = settings.fail_safe, settings.elastic, settings.cone
    values: dict[str, ArrayLike] = {
        "POLICY": POLICIES[settings.policy], "MARGIN": grip.wanted_margin, "QUANTILE": at_quantile,
        "QUANTILE_KNOWN": known_quantile,
        "DEAD_BAND": grip.dead_band, "RELEASE_TIME": grip.release_time, "SETTLE_TIME": grip.settle_time,
        "SLOT": grip.usual_time / SLOTS, "PROVEN_TIME": grip.proven_time,
        "SLIP_GROWTH": grip.slip_growth, "MIN_FORCE": limits.min_force,
        "MAX_FORCE": limits.max_force, "RAISE_RATE": limits.raise_rate, "LOWER_RATE": limits.lower_rate,
        "LIFETIME": limits.lifetime, "FAIL_FORCE": safe.force, "FAIL_HOLD": safe.hold_time,
        "FAIL_RAMP": safe.ramp_rate, "CONSTANT": settings.constant.force,
        "LEARNS": float(settings.policy == "margin" and settings.friction.shared),
        "CONE": (1.0 + cone.safety) / cone.friction, "LONGEST_GAP": settings.estimator.longest_gap,
        "ELASTIC": [elastic.friction, elastic.safety, elastic.radius, elastic.power, elastic.exponent],
        "RECOVERY": settings.watchdog.recover_after, "COMMAND": math.nan, "INFORMED": math.inf,
        "CONFIRMED": math.nan,
    }  # fmt: skip
    for name, value in values.items():
        h[at[f"G_{name}"]] = np.asarray(value, float)


def burden_table(events: Sequence[Disturbance], step: float, duration: float) -> Floats:
    """Return force x, y, torque, mass, turn, friction factor at every tick; (ticks + 2, 6)."""
    return _burdens(tuple(events), step, duration)


@lru_cache(maxsize=64)
def _burdens(events: tuple[Disturbance, ...], step: float, duration: float) -> Floats:
    ticks = round(duration / step) + 2
    return burden_rows(events, np.arange(ticks, dtype=np.float64) * step)


@lru_cache(maxsize=64)
def noise_table(settings: HandSettings, seed: int, samples: int, slip_channel: str) -> Floats:
    """Return bias and noise of every sample as :class:`vegrip.virtual.sensor.Sensors` draws them.

    Shape (samples, fingers, 8); the last column is 1 where the slip flag is wrong.
    """
    sensors = Sensors(settings.sensor, settings.fingers, np.random.default_rng([seed, 1]))
    table = np.stack([sensors.draw()[0].copy() for _ in range(samples)])
    table[:, :, 7] = 0.0
    if slip_channel == "noisy":
        rng = np.random.default_rng([seed, 4])
        table[:, :, 6] += SPEED_NOISE_M_S * rng.standard_normal(table.shape[:2])
        table[:, :, 7] = rng.random(table.shape[:2]) < WRONG_FLAGS
    return table


def correlation_of(settings: GraspParameters, model: ContactModel) -> float:
    """Return the correlation of what is not known of the fingers, as the node has it."""
    friction = settings.friction
    if not (friction.shared and settings.policy == "margin"):
        return FINGER_CORRELATION
    return shared_part(model.values[friction_symbol(model)].std, friction.own_spread)


def learning_memory(settings: GraspParameters, model: ContactModel, fingers: int) -> tuple[Floats, Floats]:
    """Return the belief of the grasp before anything was felt, and the state of its probing."""
    g, q = np.zeros(BELIEF_SIZE), np.zeros(TRUST_SIZE)
    mu = model.values[friction_symbol(model)]
    f = settings.friction
    begin_belief(g, fingers, settings.estimator.friction_drift, f.shock)
    for i in range(fingers):
        expect_finger(g, i, math.log(mu.value), mu.std, f.own_spread)
    probing = f.probing and not f.why_too_coarse
    begin_probing(
        q, f.climb if probing else 0.0, f.rate if probing else 0.0, f.unknown, f.known, f.quiet_time,
        f.quiet_change, f.pause, f.reach,
    )  # fmt: skip
    begin_onsets(q, f.onset_noise if f.onsets else math.inf, f.shock)
    noise = settings.noise
    grip = settings.grip
    begin_drives(q, noise.normal_force)
    tell_drives(q, grip.drive_lag, grip.measure_lag, grip.burst_rate)
    begin_lead(q, noise.tangential_force, noise.torque_z)
    begin_felt_slip(q, f.sliding_speed, f.slip_delay)
    begin_late_slip(q)
    begin_changes(q)
    begin_trust(g, q)
    return g, q
