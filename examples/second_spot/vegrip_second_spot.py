"""A second spot of the fingertip touches at the depth x_s: ``N_e += s_s K ((x - x_s) / x_ref)^(3/2)``.

Replace this by your own law: its equation, what it assumes, where it comes from. Forces in units of K (the
elastic force at the reference depth ``x_ref = R / 10``) and depths in x_ref serve fingertips of any size.
"""

from vegrip.effects import Effect, hook
from vegrip.parameters import Parameter


def elastic(
    elastic_force: float, x: float, reference_depth: float, K: float, s_s: float, x_s: float
) -> float:
    """Return the elastic force [N].

    A hook is scalar Python with nothing but math, numbers and functions of this file. It takes what it
    needs by the names of its arguments; `vegrip/effects/contract.py` lists stages and names.
    """
    beyond = max(x / reference_depth - x_s, 0.0)
    return elastic_force + s_s * K * beyond**1.5


EFFECT = Effect(
    name="second_spot",
    summary="another part of the fingertip touches when it is pressed in deeper",
    cites=("own",),
    parameters=(
        # symbol, unit, default, std of the prior, lower and upper bound, what it is; null: where it is absent
        Parameter("s_s", "1", 0.5, 0.5, 0.0, 100.0, "stiffness of the second spot over K", null=0.0),
        Parameter("x_s", "1", 1.2, 0.5, 0.0, 20.0, "depth at which it touches, in x_ref"),
    ),
    hooks=(hook(elastic),),
    confounded=("second_contact", "layer_over_core"),
    experiment="slow press to beyond the depth at which the spot touches",
)
