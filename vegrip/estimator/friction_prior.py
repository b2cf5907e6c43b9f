"""What is believed of friction before anything is felt: its law over the load, as published of soft tips.

The belief is a Gaussian over ``ln mu`` at the reference load of 5 N and the exponent g
(:mod:`vegrip.estimator.kernels.load_law`). The table of docs/friction.md has the published figures. The
default is a choice that holds them: mu at 5 N lies between 0.25 and 1 (95 of 100), and g is 0.15 +- 0.12.

A tangential sensor whose gain is G reads G T, so what slides and holds show is the *apparent* friction G mu.
With that alone the margin is right, whatever G is: the unknown gain widens the prior, and what is learned
holds for the channel by which it was learned.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

from vegrip.config import fixed_parameter
from vegrip.model import ContactModel

PUBLISHED_COEFFICIENT = 0.5  # [-] median of mu at 5 N over soft tips
PUBLISHED_SPREAD = 0.35  # std of ln mu: 0.25 to 1 for 95 of 100


@dataclass(frozen=True)
class FrictionPrior:
    """Friction of the tips on what they hold, and the gain of the channels that show it."""

    coefficient: float = fixed_parameter(
        0.0, unit="1", low=0.0, high=20.0,
        doc="mu at a normal force of 5 N; 0 = as the model states, else as published",
    )  # fmt: skip
    coefficient_std: float = fixed_parameter(
        0.0, unit="1", low=0.0, high=2.0, doc="std of ln mu; 0 = as the model states, else as published"
    )
    load_exponent: float = fixed_parameter(
        0.15, unit="1", low=-0.5, high=0.9, doc="g of mu = mu_0 (N / 5 N)^-g; 0 = Coulomb's law"
    )
    load_exponent_std: float = fixed_parameter(0.12, unit="1", low=0.0, high=1.0, doc="std of g")
    tangential_gain: float = fixed_parameter(
        0.92, unit="1", low=0.5, high=2.0, doc="of the tangential channels: measured over true force"
    )
    tangential_gain_std: float = fixed_parameter(
        0.1, unit="1", low=0.0, high=1.0, doc="relative std of that gain"
    )
    as_modelled: bool = fixed_parameter(
        False, doc="the model's friction counts as stated, also where it is that of the catalogue"
    )


COULOMB = FrictionPrior(
    load_exponent=0.0, load_exponent_std=0.0, tangential_gain=1.0, tangential_gain_std=0.0, as_modelled=True
)
"""The paper's constant friction, as the model has it, by sensors whose gain is known."""


class FrictionBelief(NamedTuple):
    """Mean and variance of ln mu at the reference load, as the sensors show it, and of the exponent."""

    ln_mu: float
    variance: float
    exponent: float
    exponent_variance: float


def prior_belief(model: ContactModel, symbol: str, prior: FrictionPrior) -> FrictionBelief:
    """Return what is believed at first of the friction of ``model``, whose parameter is ``symbol``."""
    value, std = stated_friction(model, symbol, prior)
    if std == 0.0:  # friction that is stated and not learned
        return FrictionBelief(math.log(value), 0.0, 0.0, 0.0)
    has_own_law = any(effect.friction_over_load for effect in model.effects)
    exponent, spread = (0.0, 0.0) if has_own_law else (prior.load_exponent, prior.load_exponent_std)
    if is_fitted(model, symbol, prior):
        return FrictionBelief(math.log(value), std * std, exponent, spread * spread)
    gain, gain_std = prior.tangential_gain, prior.tangential_gain_std
    return FrictionBelief(math.log(value * gain), std * std + gain_std * gain_std, exponent, spread * spread)


def is_fitted(model: ContactModel, symbol: str, prior: FrictionPrior) -> bool:
    """Return whether friction is that of a fitted model: apparent already, as the channels show it."""
    return not (prior.coefficient or prior.as_modelled or is_guess(model, symbol))


def is_guess(model: ContactModel, symbol: str) -> bool:
    """Return whether the friction of ``model`` is the default of the catalogue, which states no material."""
    (_, declared), believed = model.parameters[symbol], model.values[symbol]
    return (believed.value, believed.std) == (declared.default, declared.std)


def stated_friction(model: ContactModel, symbol: str, prior: FrictionPrior) -> tuple[float, float]:
    """Return mu and the std of ln mu: stated, else those of a fitted model, else the published ones.

    The default of the catalogue states no material.
    """
    believed = model.values[symbol]
    is_stated = prior.as_modelled or not is_guess(model, symbol)
    value, std = (believed.value, believed.std) if is_stated else (PUBLISHED_COEFFICIENT, PUBLISHED_SPREAD)
    return prior.coefficient or value, prior.coefficient_std or std
