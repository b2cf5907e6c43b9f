"""The model of the paper, with a prior that covers silicone fingertips of ordinary hardness."""

from vegrip.effects import effect
from vegrip.errors import ModelError
from vegrip.model.model import ContactModel
from vegrip.parameters import changed, declared

BASE = ("power_law_stiffness", "relaxation", "geometric_radius", "pressure_coupling", "coulomb_friction")
"""Effects of the base model, in order."""


MAX_RADIUS_M = 1.0  # [m]


def paper_model(tip_radius: float, *, modulus: float = 3e5) -> ContactModel:
    """Return the base model of a fingertip of radius ``tip_radius`` [m].

    Args:
        tip_radius: R of the undeformed fingertip [m].
        modulus: a guess of the effective modulus E* [Pa] for the prior of K, Hertz' ``4/3 E* sqrt(R) x^1.5``
            at ``x_ref = R / 10``. Silicone 1e5 .. 1e6, living cells 1e2 .. 1e4. The prior is wide, a factor
            of 1.6.

    Raises:
        ModelError: a radius that no tip has: above 1 m it is millimetres taken for metres.

    """
    if not 0.0 < tip_radius <= MAX_RADIUS_M:
        raise ModelError(
            f"tip_radius is {tip_radius:g} m; give it in metres, above 0 and up to {MAX_RADIUS_M:g}"
        )
    depth = tip_radius / 10.0
    effects = tuple(effect(name) for name in BASE)
    values = {p.symbol: declared(p) for e in effects for p in e.parameters}
    values["K"] = changed(values["K"], value=4.0 / 3.0 * modulus * tip_radius**0.5 * depth**1.5)
    return ContactModel(
        effects, values, tip_radius, depth, provenance={"origin": "prior of the paper's model"}
    )
