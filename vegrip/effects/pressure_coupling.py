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

    ``(C_k - 1) k^2`` is smooth in 1 / k; fitted in Chebyshev nodes for k = 1 .. 20, held beyond. A tenth of
    the time of three gamma functions; powers gathered in pairs are computed side by side.
    """
    u = min(max(1.0 / k, 0.05), 1.0) if k > 0.0 else 1.0
    s = u * 2.105263157894737 - 1.105263157894737
    q = s * s
    r = q * q
    p = 4.27457743266e-05 - 0.0044687621003 * s + 0.00247237781147 * q
    p = (0.0101987089552 - 8.06731474446e-05 * s) + q * p
    p = (0.0936189770009 - 0.049439219027 * s) + q * (0.0274125491694 - 0.0184528917118 * s) + r * p
    p = (1.98518538809 - 0.26153169103 * s) + q * (0.370448252603 - 0.155405547379 * s) + r * p
    return u * u * p


def exponent_of(excess: float) -> float:
    """Return k for ``excess = C_k - 1`` in 1e-4 .. 2, the inverse of eq. (4) to 2e-6.

    ``1 / k`` is a smooth function of ``w = sqrt(excess)`` (it starts as ``w sqrt(3) / pi``), fitted in
    Chebyshev nodes; a tenth of the time of Newton's method, and this runs at every output.
    """
    w = math.sqrt(excess)
    q = excess
    s = -0.2226987737552641 + 0.08780621536206655 * w - 0.013435811126933995 * q
    s = (-0.0027464348359497043 + 0.23884537768018593 * w) + q * s
    s = (
        (0.5513291562927749 + 0.333171421417534 * w)
        + q * (-0.07552958554914087 - 0.17724269773987175 * w)
        + q * q * s
    )
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
