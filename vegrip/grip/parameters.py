"""All parameters of the grasp force node: control, and for each fingertip its model and sensors."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from vegrip.config import build, constant, fixed_parameter, parameter
from vegrip.errors import ConfigError
from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise, Sensors
from vegrip.estimator.layout import friction_symbol
from vegrip.grip.learned_store import InMemory, OnDisk
from vegrip.grip.settings import ControlSettings
from vegrip.model import ContactModel, paper_model, read_model
from vegrip.parameters import changed

HEALTH_TIME_OUTS = 40
"""Times of silence over which an estimate is judged: as many samples at any rate, 2 s at the usual one."""


@dataclass(frozen=True)
class TipParameters:
    """The prior of one fingertip.

    A change in a running node is taken over without a gap, see :mod:`vegrip.grip.model_swap`.
    """

    model: str = parameter("", doc="model file (TOML); empty = the paper's model with the two below")
    radius: float = parameter(9e-3, unit="m", low=1e-9, high=1.0, doc="radius of the tip")
    modulus: float = parameter(3e5, unit="Pa", low=1.0, high=1e12, doc="guess of the effective modulus")
    friction: float = constant(0.0, unit="1", doc="guess of mu; 0 = that of the model")
    friction_spread: float = constant(0.0, unit="1", doc="std of ln mu; 0 = that of the model")


@dataclass(frozen=True)
class GraspParameters(ControlSettings):
    """The parameters of the program ``grasp_force``."""

    tip: TipParameters = fixed_parameter(TipParameters(), doc="every fingertip")
    tips: dict[str, Any] = fixed_parameter({}, doc="what is different at a finger, by its name")
    noise: SensorNoise = fixed_parameter(SensorNoise(), doc="of the sensors")
    sensors: Sensors = fixed_parameter(Sensors(), doc="gains of the sensors")
    estimator: EstimatorSettings = fixed_parameter(EstimatorSettings(), doc="the estimator")
    suspects: bool = fixed_parameter(
        True, doc="look for the effect that a failing model lacks, in a process of low priority"
    )
    learned: str = fixed_parameter(
        "", doc="folder that keeps what the fingers learn, read at the start; empty = none"
    )


def learned_store_of(parameters: GraspParameters) -> InMemory:
    return OnDisk(Path(parameters.learned)) if parameters.learned else InMemory()


def estimator_factory(
    parameters: GraspParameters, fingers: tuple[str, ...], where: str, store: InMemory | None = None
) -> Callable[[str], ContactEstimator]:
    """Return the function that makes the estimator of a finger, with what ``store`` has of it."""
    tips = {finger: _tip(parameters, finger, where) for finger in fingers}
    unknown = parameters.tips.keys() - tips.keys()
    if unknown:
        raise ConfigError(
            f"{where}: 'tips' has {', '.join(sorted(unknown))}; the fingers are {', '.join(fingers)}"
        )

    odd = parameters.sensors.fingers.keys() - tips.keys()
    if odd:
        raise ConfigError(
            f"{where}: 'sensors.fingers' has {', '.join(sorted(odd))}; the fingers are {', '.join(fingers)}"
        )

    def make(finger: str) -> ContactEstimator:
        tip, gain = tips[finger], parameters.sensors.of(finger)
        model, friction = _model(tip), parameters.friction
        if friction.coefficient == 0.0:  # a tip's own, also where it is what the catalogue has
            friction = replace(friction, coefficient=tip.friction)
        believed = friction.prior_of(gain.tangential_gain, gain.tangential_gain_std)
        settings = replace(_at_rate(parameters), friction=believed)
        if store is not None:
            return store.estimator(finger, model, parameters.noise, settings)
        return ContactEstimator(model, parameters.noise, settings)

    return make


def _at_rate(parameters: GraspParameters) -> EstimatorSettings:
    """Return the settings of the estimator; where states may be late, a gap is longer and a verdict, too."""
    given, silence = parameters.estimator, parameters.watchdog.time_out
    return replace(
        given,
        longest_gap=max(given.longest_gap, silence),
        health_time=max(given.health_time, HEALTH_TIME_OUTS * silence),
    )


def models_of(parameters: GraspParameters, fingers: tuple[str, ...], where: str) -> list[ContactModel]:
    return [_model(_tip(parameters, finger, where)) for finger in fingers]


def _tip(parameters: GraspParameters, finger: str, where: str) -> TipParameters:
    special: Mapping[str, Any] = parameters.tips.get(finger, {})
    table = {name: getattr(parameters.tip, name) for name in ("model", "radius", "modulus")}
    own = build(TipParameters, table | dict(special), f"{where}.tips.{finger}")
    return replace(own, friction=parameters.tip.friction, friction_spread=parameters.tip.friction_spread)


def _model(tip: TipParameters) -> ContactModel:
    return _made(tip, _stamp(Path(tip.model)) if tip.model else None)


@lru_cache(maxsize=64)
def _made(tip: TipParameters, stamp: object) -> ContactModel:  # noqa: ARG001 (a file that changed is read again)
    """Return the model of ``tip``; kept, because a running node asks again, whose loop 10 ms would delay."""
    model = read_model(Path(tip.model)) if tip.model else paper_model(tip.radius, modulus=tip.modulus)
    symbol = friction_symbol(model)
    mu = model.values[symbol]
    mu = changed(mu, value=tip.friction or mu.value, std=tip.friction_spread or mu.std)
    return replace(model, values={**model.values, symbol: mu})


def _stamp(file: Path) -> tuple[int, int] | None:
    try:
        status = file.stat()
    except OSError:
        return None  # reading it says what is wrong
    return status.st_mtime_ns, status.st_size
