"""Adhesion: in contact the surfaces pull with ``F = 2 pi R W``, and part over a neck.

The pull acts as in [DerjaguinMullerToporov1975]_: it is subtracted from the force of the contact, so
contact begins with a jump to -F and the pull-off force is F. This is the stiff, small limit; the soft one is
:mod:`jkr_adhesion <vegrip.effects.jkr_adhesion>`. On retraction a neck stretches to the length l before it
parts: ``F (1 + x / l)^2`` for ``-l < x < 0``. While surfaces are drawn apart at speed v the work grows,
``W = W_0 [1 + g (v / v_ref)^n]``, ``v_ref = x_ref / s``, [MaugisBarquins1978]_.

F is given in units of the elastic force K at x_ref, so W is ``pull K / (2 pi R)``.
"""

from vegrip.effects.contract import Effect, State, hook
from vegrip.parameters import Parameter

TOUCH = 0.02  # [x_ref] depth of a first touch; in air just above the surface, noise would touch at 0


def force(
    adhesion: float,
    x: float,
    speed: float,
    reference_depth: float,
    K: float,
    pull: float,
    neck: float,
    g_v: float,
    n_v: float,
    sticking: float,
) -> tuple[float, float]:
    """Return the pull [N] and whether the surfaces stick (1) or not (0)."""
    if x > TOUCH * reference_depth:
        sticking = 1.0
    stretched = min(max(1.0 + x / (neck * reference_depth), 0.0), 1.0)
    if stretched <= 0.0:
        sticking = 0.0
    grown = 1.0 + g_v * (max(-speed, 0.0) / reference_depth) ** n_v
    return adhesion + pull * K * sticking * stretched * stretched * grown, sticking


EFFECT = Effect(
    name="adhesion",
    summary="the surfaces attract each other, and the force is negative before they part",
    residual="a jump at first touch, negative force before the tip parts",
    cites=("DerjaguinMullerToporov1975", "MaugisBarquins1978"),
    parameters=(
        Parameter("pull", "1", 0.05, 0.05, 0.0, 10.0, "pull-off force over K", null=0.0, of="K"),
        Parameter(
            "neck", "1", 0.2, 0.7, 1e-3, 10.0, "length of the neck, in x_ref", transform="log", of="x_ref"
        ),
        Parameter("g_v", "1", 0.1, 0.2, 0.0, 100.0, "growth of W at a retraction of x_ref per s", null=0.0),
        Parameter("n_v", "1", 0.5, 0.1, 0.1, 1.0, "exponent of that growth"),
    ),
    states=(State("sticking", "1", "1 from the first touch until the neck parts", extreme=True),),
    hooks=(hook(force, gives="adhesion"),),
    confounded=("jkr_adhesion", "force_drift"),
    experiment="slow tap and pull-off at several speeds, with air before and after",
    kinked=True,
    companions=("jkr_adhesion",),
)
