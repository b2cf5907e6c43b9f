"""The controllers of the comparison, each in the settings that ``docs/demo.md`` explains."""

from dataclasses import replace

from vegrip.control.baselines import ConeSettings, ConstantSettings
from vegrip.grasp.node import GraspForce
from vegrip.grasp.parameters import GraspParameters, TipParameters, estimator_factory
from vegrip.virtual import HandSettings

NAMES = ("vegrip", "constant", "cone")


def parameters(name: str, knob: float | None = None) -> GraspParameters:
    """Return the parameters of the controller ``name``.

    Args:
        name: one of :data:`NAMES`.
        knob: its one trade-off between force and risk: wanted margin [-], force [N] or safety [-]; None = the
            one tuned.

    """
    base = demo_parameters()
    if name == "constant":
        return replace(base, policy="constant", constant=ConstantSettings(**_given("force", knob)))
    if name == "cone":
        return replace(base, policy="cone", cone=ConeSettings(**_given("safety", knob)))
    return replace(base, grip=replace(base.grip, **_given("wanted_margin", knob)))


def demo_parameters() -> GraspParameters:
    """Return the parameters of the node in the demonstration: nominal tips, nothing of their scatter."""
    hand = HandSettings()
    return GraspParameters(
        tip=TipParameters(radius=hand.tip.radius),
        tips={hand.fingers[0]: {"radius": hand.opposing_radius}},
        report_period=0.02,
    )


def make_node(settings: GraspParameters, fingers: tuple[str, ...], name: str = "grasp_force") -> GraspForce:
    """Return a node of these parameters, not configured yet."""
    return GraspForce(name, fingers, estimator_factory(settings, fingers, name), settings)


def _given(field: str, knob: float | None) -> dict[str, float]:
    return {} if knob is None else {field: knob}
