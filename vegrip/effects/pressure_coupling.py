"""Pressure exponent by the coupling of radius and pressure: ``C_k = C_k0 / H``.

[TiezziKao2007]_, eqs. (25), (36) and (48): a patch that grows by creep has a flatter pressure. The creep
ratio is ``H = x / x_e(N_ref)``, with ``x_e`` the elastic indentation under ``N_ref``, the largest force of
this contact. With the instantaneous force instead, a constant indentation would raise k while N relaxes,
against the paper's own section III; with the largest one H stays 1 in such a hold and is the creep h(t)
under constant load. With ``N_e ~ x^n`` near x: ``H = (N_e / N_ref)^(1/n)``.

``H < C_k0`` is the end of the law: k grows without bound. C_k is kept above 1 + 1e-4 (k = 180).
"""

import math

from vegrip.effects.contract import Effect, State, hook
from vegrip.parameters import Parameter

FLATTEST = 1e-4  # least C_k - 1


def excess_of(k: float) -> float:
    """Return ``C_k - 1``, eq. (4), ``C_k = Gamma(1 + 3/k) / (Gamma(1 + 1/k) Gamma(1 + 2/k))``, to 3e-7.

    ``(C_k - 1) k^2`` is smooth in 1 / k; fitted in Chebyshev nodes for k = 1 .. 20, held beyond. A fifth of
    the time of three gamma functions.
    """
    u = min(max(1.0 / k, 0.05), 1.0) if k > 0.0 else 1.0
    s = (u - 0.525) / 0.475
    p = -0.0044687621003 + 0.00247237781147 * s
    p = 4.27457743266e-05 + p * s
    p = -8.06731474446e-05 + p * s
    p = 0.0101987089552 + p * s
    p = -0.0184528917118 + p * s
    p = 0.0274125491694 + p * s
    p = -0.049439219027 + p * s
    p = 0.0936189770009 + p * s
    p = -0.155405547379 + p * s
    p = 0.370448252603 + p * s
    p = -0.26153169103 + p * s
    p = 1.98518538809 + p * s
    return u * u * p


def exponent_of(excess: float) -> float:
    """Return k for ``excess = C_k - 1`` in 1e-4 .. 2, the inverse of eq. (4) to 2e-6.

    ``1 / k`` is a smooth function of ``w = sqrt(excess)`` (it starts as ``w sqrt(3) / pi``), fitted in
    Chebyshev nodes; a tenth of the time of Newton's method, and this runs at every output.
    """
    w = math.sqrt(excess)
    s = 0.08780621536206655 - 0.013435811126933995 * w
    s = -0.2226987737552641 + s * w
    s = 0.23884537768018593 + s * w
    s = -0.0027464348359497043 + s * w
    s = -0.17724269773987175 + s * w
    s = -0.07552958554914087 + s * w
    s = 0.333171421417534 + s * w
    s = 0.5513291562927749 + s * w
    return 1.0 / (w * s)


def largest(force: float, largest_force: float) -> float:
    """Return the largest force [N] since the contact was made; 0 out of contact."""
    if force <= 0.0:
        return 0.0
    return max(force, largest_force)


def profile(elastic_force: float, elastic_exponent: float, largest_force: float, k0: float) -> float:
    """Return the pressure exponent k."""
    creep = 1.0
    if largest_force > 0.0 and elastic_force > largest_force:
        creep = (elastic_force / largest_force) ** (1.0 / elastic_exponent)
    return exponent_of(min(max((1.0 + excess_of(k0)) / creep - 1.0, FLATTEST), 2.0))


EFFECT = Effect(
    name="pressure_coupling",
    summary="a patch that creeps wider gets a flatter pressure profile",
    cites=("TiezziKao2007",),
    parameters=(
        Parameter("k0", "1", 2.0, 0.05, 1.0, 20.0, "pressure exponent of the elastic contact; 2 is Hertz"),
    ),
    states=(
        State(
            "largest_force",
            "N",
            "largest force of this contact",
            low="force",
            high="elastic_force",
            extreme=True,
        ),
    ),
    hooks=(hook(largest, stage="force", gives=""), hook(profile)),
)
