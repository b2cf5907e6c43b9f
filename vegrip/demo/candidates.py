"""The controllers of the comparison, each in the settings that ``docs/demo.md`` explains."""

from dataclasses import replace

from vegrip.estimator import EstimatorSettings
from vegrip.grasp.node import GraspForce
from vegrip.grasp.parameters import GraspParameters, TipParameters, estimator_factory
from vegrip.virtual import HandSettings

KNOBS = {
    "hand": {"vegrip": 0.15, "constant": 4.0, "cone": 1.5},
    "pinch": {"vegrip": 0.15, "constant": 8.0, "cone": 11.0},
}
"""By grasp, the trade-off between force and risk as tuned: wanted margin [-], force [N], safety [-].

That of vegrip is its default in both; those of the others had to be tuned for each grasp.
"""

NAMES = tuple(KNOBS["hand"])


def parameters(name: str, knob: float) -> GraspParameters:
    """Return the parameters of the controller ``name``, one of :data:`NAMES`, with its knob set."""
    base = demo_parameters()
    if name == "constant":
        return replace(base, policy="constant", constant=replace(base.constant, force=knob))
    if name == "cone":
        return replace(base, policy="cone", cone=replace(base.cone, safety=knob))
    return replace(base, grip=replace(base.grip, wanted_margin=knob))


def demo_parameters() -> GraspParameters:
    """Return what every controller is told: the nominal tips, nothing of their scatter or of the object."""
    hand = HandSettings()
    return GraspParameters(
        tip=TipParameters(radius=hand.tip.radius),
        tips={"thumb": {"radius": hand.opposing_radius}},
        estimator=EstimatorSettings(hold="force"),  # the drives of this hand are force-controlled
    )


def make_node(settings: GraspParameters, fingers: tuple[str, ...], name: str = "grasp_force") -> GraspForce:
    """Return a node of these parameters, not configured yet."""
    tips = {finger: tip for finger, tip in settings.tips.items() if finger in fingers}
    settings = replace(settings, tips=tips)
    return GraspForce(name, fingers, estimator_factory(settings, fingers, name), settings)
