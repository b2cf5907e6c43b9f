"""A second body, touched at a depth: ``N_e += K_2 ((x - x_2) / x_ref)^p_2`` for x > x_2.

p_2 is 1 for a spring or a stop, 3/2 for a core or another sphere, [Hertz1882]_, and never more: a higher
power is no kink, and imitates an exponential stiffness. It relaxes as the tip does. K_2 is in units of K,
x_2 in x_ref.
"""

from collections.abc import Iterator, Mapping

from vegrip.effects.contract import Effect, hook
from vegrip.parameters import Parameter


def pressed(depth: float, start: float, exponent: float) -> float:
    """Return ``(depth - start)^exponent``, nothing before the start."""
    return (depth - start) ** exponent if depth > start else 0.0


def elastic(
    elastic_force: float, x: float, reference_depth: float, K: float, K_2: float, x_2: float, p_2: float
) -> float:
    """Return the elastic force [N]."""
    return elastic_force + K_2 * K * pressed(x / reference_depth, x_2, p_2)


def depths(values: Mapping[str, float], greatest: float, *shares: float) -> Iterator[float]:
    """Yield shares of the deepest press [x_ref]: what is touched beyond it shows nothing."""
    if "K" in values and "p" in values:
        for share in shares:
            yield min(share * (greatest / values["K"]) ** (1.0 / values["p"]), 10.0)


def _trials(values: Mapping[str, float], greatest: float) -> Iterator[dict[str, float]]:
    for depth in depths(values, greatest, 0.3, 0.55, 0.8):
        yield {"K_2": 0.5, "x_2": depth, "p_2": 1.25}


EFFECT = Effect(
    name="second_contact",
    summary="beyond a depth a second body is touched",
    residual="a kink at one depth, both ways",
    cites=("Hertz1882",),
    parameters=(
        Parameter("K_2", "1", 0.5, 1.0, 0.0, 1e3, "its force x_ref beyond x_2, over K", null=0.0, of="K"),
        Parameter("x_2", "1", 1.2, 0.5, 0.0, 10.0, "depth at which it is touched", of="x_ref"),
        Parameter("p_2", "1", 1.25, 0.25, 1.0, 1.5, "exponent of its law"),
    ),
    hooks=(hook(elastic),),
    confounded=("layer_over_core", "exponential_stiffness"),
    experiment="slow deep ramp up and down",
    trial_shapes=(("x_2", (1.2,)),),
    trials_at=_trials,
)
