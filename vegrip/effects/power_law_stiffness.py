"""Power-law stiffness.

``N_e = K (x / x_ref)^p``, with ``x_ref = R / 10``.

[TiezziKao2007]_, eq. (14), whose ``m x^(b+1) / (b+1)`` it equals with ``p = b + 1`` and
``K = m x_ref^p / p``. Written with a reference depth, K is a force and p can change without changing the
order of magnitude of K, so the same prior serves a silicone fingertip and an AFM tip.
"""

from vegrip.effects.contract import Effect, hook
from vegrip.parameters import Parameter


def elastic(x: float, reference_depth: float, K: float, p: float) -> float:
    """Return the elastic force [N] at indentation x [m]."""
    if x <= 0.0:
        return 0.0
    return float(K * (x / reference_depth) ** p)


EFFECT = Effect(
    name="power_law_stiffness",
    summary="the elastic force is a power of the indentation",
    cites=("TiezziKao2007",),
    parameters=(
        Parameter(
            "K", "N", 1.0, 0.5, 1e-15, 1e9, "elastic force at x_ref", transform="log", learn=True, drift=1e-3
        ),
        Parameter("p", "1", 1.5, 0.1, 0.8, 4.0, "exponent; 3/2 is Hertz", learn=True),
    ),
    hooks=(hook(elastic),),
)
