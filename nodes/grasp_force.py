"""The grasp force node on a bus: fingertip states in, slip margins and force commands out."""

from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Any

from vegrip.config import build as build_parameters
from vegrip.estimator import ContactEstimator
from vegrip.grip.background_diagnosis import Inquiries
from vegrip.grip.model_swap import Succession
from vegrip.grip.node import GraspForce
from vegrip.grip.parameters import GraspParameters, estimator_factory, memory_of, models_of
from vegrip.model import ContactModel
from vegrip.runtime import NodeContext


def build(settings: Mapping[str, Any], context: NodeContext) -> GraspForce:
    """Make the node; the fingers are those of the bus."""
    where = f"{context.name} [parameters]"
    parameters = build_parameters(GraspParameters, settings, where)
    memory, fingers = memory_of(parameters), context.fingers

    def factory(parameters: GraspParameters) -> Callable[[str], ContactEstimator]:
        return estimator_factory(parameters, fingers, where, memory)

    def models(parameters: GraspParameters) -> list[ContactModel]:
        return models_of(parameters, fingers, where)

    def present_models() -> dict[str, ContactModel]:
        now: Any = node.parameters
        return dict(zip(fingers, models_of(now, fingers, where), strict=True))

    succession = Succession(factory, models, context.name)
    inquiries = (
        Inquiries(present_models, asdict(parameters.noise), context.name) if parameters.suspects else None
    )
    node = GraspForce(context.name, fingers, factory(parameters), parameters, memory, succession, inquiries)
    return node
