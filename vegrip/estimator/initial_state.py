"""The memory of an estimator before its first sample: settings, priors, bounds."""

import math

import numpy as np
from scipy.special import ndtri

from vegrip.effects.contract import OUTSIDE
from vegrip.estimator.friction_prior import prior_belief
from vegrip.estimator.layout import CHANNELS, FRICTION, PER_CHANNEL, SETTINGS, Layout
from vegrip.estimator.settings import EstimatorSettings, SensorNoise
from vegrip.model import ContactModel
from vegrip.parameters import coordinate
from vegrip.types import Floats


def initial_memory(
    model: ContactModel, layout: Layout, noise: SensorNoise, settings: EstimatorSettings
) -> Floats:
    """Return a memory in which nothing is known but the model's prior."""
    m = np.zeros(layout.size)
    at = {name: slice(*place) for name, place in layout.places().items()}
    m[at["VALUES"]] = model.vector
    m[at["EXOGENOUS"]] = [model.reference_temperature, *[0.0] * (len(OUTSIDE) - 1)]
    setting = _setting(model, layout, noise, settings)
    m[at["SET"]] = [setting[name] for name in SETTINGS]
    _state(model, layout, noise, settings, m, at)
    symbols = list(model.parameters)
    believed = prior_belief(model, symbols[layout.mu], settings.friction)
    friction = dict.fromkeys(FRICTION, 0.0)
    friction |= dict.fromkeys(("LN_MU", "BASE_LN"), believed.ln_mu)
    friction |= dict.fromkeys(("VAR", "BASE_VAR"), believed.variance)
    friction |= dict.fromkeys(("EXPONENT", "BASE_EXPONENT"), believed.exponent)
    friction |= dict.fromkeys(("EXPONENT_VAR", "BASE_EXPONENT_VAR"), believed.exponent_variance)
    m[at["VALUES"]][layout.mu] = math.exp(believed.ln_mu)
    friction |= {"UNCONFIRMED": math.inf, "SCATTER_VAR": settings.friction_scatter**2}
    m[at["FRICTION"]] = list(friction.values())
    m[at["CONSIDER"]] = [
        *(model.values[symbols[i]].std ** 2 for i in layout.considered[:-1]), believed.variance,
    ]  # fmt: skip
    channels = np.zeros((len(CHANNELS), len(PER_CHANNEL)))
    channels[:, PER_CHANNEL.index("AGE")] = math.inf
    m[at["CHANNEL"]] = channels.ravel()
    return m


def _state(
    model: ContactModel,
    layout: Layout,
    noise: SensorNoise,
    settings: EstimatorSettings,
    m: Floats,
    at: dict[str, slice],
) -> None:
    R, n_states = model.tip_radius, layout.n_states
    symbols = list(model.parameters)
    learned = [model.parameters[symbols[i]][1] for i in layout.learned]
    values = [model.values[p.symbol] for p in learned]
    means = [coordinate(p, v.value) for p, v in zip(learned, values, strict=True)]
    m[at["Y"]] = [0.0, 0.0, *model.initial_states, *means, 0.0, 0.0]
    offset, bias = settings.offset * R, settings.force_bias * noise.normal_force
    prior = [(0.3 * R) ** 2, (R * settings.agility) ** 2, *np.zeros(n_states), *(v.std**2 for v in values)]
    m[at["START"]] = m[at["Y"]]
    m[at["PRIOR"]] = [*prior, offset**2, bias**2]
    infinite = [math.inf] * layout.learned_from
    low = [coordinate(p, v.low) for p, v in zip(learned, values, strict=True)]
    high = [coordinate(p, v.high) for p, v in zip(learned, values, strict=True)]
    m[at["LOW"]] = [*(-x for x in infinite), *low, -math.inf, -math.inf]
    m[at["HIGH"]] = [*infinite, *high, math.inf, math.inf]
    # random walks that do what an Ornstein-Uhlenbeck disturbance of std s and time tau does: q = 2 s^2 / tau
    d0 = 2.0 * (settings.displacement_drift * noise.displacement) ** 2 / settings.displacement_drift_time
    bF = 2.0 * (settings.force_drift * noise.normal_force) ** 2 / settings.force_drift_time
    m[at["DRIFT"]] = [0.0, 0.0, *np.zeros(n_states), *(p.drift**2 for p in learned), d0, bF]


def _setting(
    model: ContactModel, layout: Layout, noise: SensorNoise, settings: EstimatorSettings
) -> dict[str, float]:
    symbol = list(model.parameters)[layout.mu]
    return {
        "ACCELERATION": model.tip_radius**2 * settings.agility**3,
        "R_FORCE": noise.normal_force**2,
        "R_DISPLACEMENT": noise.displacement**2,
        "R_RADIUS": noise.contact_radius**2,
        "S_TANGENTIAL": noise.tangential_force,
        "S_TORQUE": noise.torque_z,
        "LONGEST_GAP": settings.longest_gap,
        "TIP_RADIUS": model.tip_radius,
        "DEPTH": model.reference_depth,
        "QUANTILE": float(ndtri(settings.confidence)),
        "HORIZON": settings.horizon,
        "HOLD": {"position": math.inf, "force": 0.0, "mixed": settings.hold_stiffness}[settings.hold],
        "SCATTER": settings.friction_scatter,
        "MU_DRIFT": settings.friction_drift,
        "REGRASP": settings.regrasp,
        "MU_PRIOR_VAR": prior_belief(model, symbol, settings.friction).variance,
        "HEALTH_TIME": settings.health_time,
        "LEARNING_REST": settings.learning_rest,
    }
