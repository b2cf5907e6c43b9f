"""Friction falls with the load: what is believed of ln mu at a normal force N is a straight line in ln N.

The belief is a Gaussian over ``ln mu`` at the reference load ``N_0`` and the exponent g of
[Schallamach1952]_::

    mu(N) = mu (N / N_0)^-g ,      ln mu(N) = ln mu - g l ,      l = ln(N / N_0) ,
    var(N) = var(ln mu) - 2 l cov(ln mu, g) + l^2 var(g)

so what was learned at one load is known less well at another. ``g = 0 +- 0`` is Coulomb's law.
"""

import math

from vegrip.estimator.kernels.generated import *

REFERENCE_LOAD = 5.0  # [N] N_0: in the middle of the loads at which friction of soft tips was published
LIGHTEST_LOAD = 0.1  # [N] below it the law is not continued: nothing was published, and mu would be infinite
HEAVIEST_LOAD = 100.0  # [N] nor beyond this: five times the largest load of a publication
LEAST_REST = 1e-3  # of the variance's inverse: less is left of a belief only by rounding and forgetting
LEAST_VARIANCE = 1e-8  # of ln mu: no number of observations brings it lower


def relative_load(force: float) -> float:
    """Return ``l``, the logarithm of a normal force [N] over the reference load."""
    return math.log(min(max(force, LIGHTEST_LOAD), HEAVIEST_LOAD) / REFERENCE_LOAD)


def friction_factor(m: Floats, force: float) -> float:
    """Return mu at the normal force [N] over mu at the reference load."""
    g = m.friction.exponent
    return math.exp(-g * relative_load(force)) if g != 0.0 else 1.0


def friction_variance(m: Floats, load: float) -> float:
    """Return the variance of ln mu at the relative ``load``."""
    if m.friction.exponent_var == 0.0:
        return m.friction.var
    return m.friction.var - 2.0 * load * m.friction.cov + load * load * m.friction.exponent_var


def base_variance(m: Floats, load: float) -> float:
    """Return the same, as it was before the present loading."""
    if m.friction.base_exponent_var == 0.0:
        return m.friction.base_var
    return m.friction.base_var - 2.0 * load * m.friction.base_cov + load * load * m.friction.base_exponent_var


def observe_base(m: Floats, gain: float, shrink: float) -> None:
    """Set the belief to that before this loading, after an observation of ``ln mu - g l``.

    With the direction ``h = (1, -l)`` of the present load the mean moves by ``P h gain``, and the covariance
    shrinks by ``P h h' P shrink``.
    """
    load = m.friction.load
    along = m.friction.base_var - load * m.friction.base_cov
    across = m.friction.base_cov - load * m.friction.base_exponent_var
    m.friction.ln_mu = m.friction.base_ln + gain * along
    m.friction.exponent = m.friction.base_exponent + gain * across
    m.friction.var = max(
        m.friction.base_var - shrink * along * along, min(m.friction.base_var, LEAST_VARIANCE)
    )
    m.friction.cov = m.friction.base_cov - shrink * along * across
    m.friction.exponent_var = max(m.friction.base_exponent_var - shrink * across * across, 0.0)


def remove_site(m: Floats, load: float, precision: float, weighted: float) -> None:
    """Set the belief before this loading to the present one without a Gaussian factor.

    That is the evidence of the loading: its precision and that times its mean, of ``ln mu - g l`` at
    ``load``.
    """
    along = m.friction.var - load * m.friction.cov
    across = m.friction.cov - load * m.friction.exponent_var
    left = 1.0 - precision * (along - load * across)
    m.friction.base_ln, m.friction.base_exponent = m.friction.ln_mu, m.friction.exponent
    m.friction.base_var, m.friction.base_cov = m.friction.var, m.friction.cov
    m.friction.base_exponent_var = m.friction.exponent_var
    if precision == 0.0 or not left > LEAST_REST:
        return
    off = (precision * (m.friction.ln_mu - load * m.friction.exponent) - weighted) / left
    m.friction.base_ln += off * along
    m.friction.base_exponent += off * across
    m.friction.base_var += precision / left * along * along
    m.friction.base_cov += precision / left * along * across
    m.friction.base_exponent_var += precision / left * across * across
