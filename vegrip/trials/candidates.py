"""The controllers of the comparison, each in the settings that ``docs/grip-quality.md`` explains."""

import math
from dataclasses import replace

from vegrip.estimator import EstimatorSettings
from vegrip.grip.node import GraspForce
from vegrip.grip.parameters import GraspParameters, TipParameters, estimator_factory
from vegrip.virtual import HandSettings
from vegrip.virtual.settings import SensorSettings

KNOBS = {
    "hand": {
        "vegrip": 0.15,
        "learning": 0.1,
        "known": 0.1,
        "ellipse": 0.15,
        "constant": 4.0,
        "cone": 1.5,
        "elastic": 0.35,
    },
    "pinch": {
        "vegrip": 0.15,
        "learning": 0.05,
        "known": 0.1,
        "ellipse": 0.15,
        "constant": 8.0,
        "cone": 11.0,
        "elastic": 0.35,
    },
}
"""By grasp, the trade-off between force and risk as tuned.

Wanted margin [-] of vegrip, of learning, of one that knows the truth of friction and contact at every instant
(the bound of what any of them can reach), and of the ellipse. Force [N], safety [-] and friction
coefficient [-] set by hand of the others: tuned for each grasp.
"""

DEMONSTRATED = "learning"
"""What the demonstration shows as vegrip: the parameters that suit a hand that feels slip at once."""

BOUND = "known"
"""What knows the truth (:mod:`vegrip.trials.known_contact`); only a simulated hand tells it."""

LABEL = {"vegrip": "vegrip", "constant": "constant grip", "cone": "Coulomb cone"}
"""What those of the demonstration are called in tables and pictures."""

INFORMED = {"vegrip, told": 0.15, "elastic, told": 1.0}
"""Controllers that know the friction of every object before they touch it.

Their knobs: wanted margin [-], and how much of that friction the elastic surface assumes [-].
"""

INFORMED_SPREAD = 0.1
"""Std of ln mu with which vegrip takes what is stated; the fingertips alone scatter by 0.08."""

NAMES = (*(name for name in KNOBS["hand"] if name != BOUND), *INFORMED)


def parameters(name: str, knob: float, friction: float = math.nan) -> GraspParameters:
    """Return the parameters of the controller ``name``, one of :data:`NAMES`, with its knob set.

    ``friction`` is that of the object, for the controllers of :data:`INFORMED`.
    """
    base = demo_parameters()
    if name in ("elastic", "elastic, told"):
        believed = knob * friction if name in INFORMED else knob
        return replace(base, policy="elastic", policy_settings={"friction": believed})
    if name in ("learning", "known"):
        base = learning_parameters(base)
    if name == "ellipse":
        base = replace(base, estimator=replace(base.estimator, surface="ellipse"))
    if name == "vegrip, told":
        base = replace(base, tip=replace(base.tip, friction=friction, friction_spread=INFORMED_SPREAD))
    if name == "constant":
        return replace(base, policy="constant", policy_settings={"force": knob})
    if name == "cone":
        return replace(base, policy="cone", policy_settings={"safety": knob})
    return replace(base, grip=replace(base.grip, wanted_margin=knob))


def learning_parameters(base: GraspParameters) -> GraspParameters:
    """Return ``base`` with friction learned by all fingers together.

    It knows the lag of the drives of the virtual hand, and how coarse and how late its slip channel is.
    """
    grip = replace(base.grip, drive_lag=0.01)
    learning = replace(base, friction=replace(base.friction, learning=True), grip=grip)
    return with_slip_channel(learning, HandSettings().sensor)


def with_slip_channel(settings: GraspParameters, sensor: SensorSettings) -> GraspParameters:
    """Return ``settings`` with how slip is felt."""
    friction = replace(settings.friction, slip_threshold=sensor.slip_threshold, slip_delay=sensor.slip_delay)
    return replace(settings, friction=friction)


def demonstrated_parameters(grasp: str) -> GraspParameters:
    return parameters(DEMONSTRATED, KNOBS[grasp][DEMONSTRATED])


def demo_parameters() -> GraspParameters:
    """Return what every controller knows: the nominal tips, nothing of their scatter or of the object."""
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
