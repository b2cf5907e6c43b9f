"""The grasp force node on a bus: fingertip states in, slip margins and force commands out."""

from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Any

from vegrip.config import build as build_parameters
from vegrip.estimator import ContactEstimator
from vegrip.grip.background_diagnosis import BackgroundDiagnosis
from vegrip.grip.model_swap import ModelSwap
from vegrip.grip.node import GraspForce
from vegrip.grip.parameters import GraspParameters, estimator_factory, learned_store_of, models_of
from vegrip.identification.sensors import lacking
from vegrip.model import ContactModel
from vegrip.runtime import NodeContext


def build(settings: Mapping[str, Any], context: NodeContext) -> GraspForce:
    """Make the node; the fingers are those of the bus."""
    parameters = build_parameters(GraspParameters, settings, f"{context.name} [parameters]")
    node = node_of(parameters, context)
    node.limit_is_stated = "max_force" in settings.get("limits", {})
    return node


def node_of(parameters: GraspParameters, context: NodeContext) -> GraspForce:
    """Make the node of ``parameters``, in which constants may have other values."""
    where = f"{context.name} [parameters]"
    store, fingers = learned_store_of(parameters), context.fingers

    def factory(parameters: GraspParameters) -> Callable[[str], ContactEstimator]:
        return estimator_factory(parameters, fingers, where, store)

    def models(parameters: GraspParameters) -> list[ContactModel]:
        return models_of(parameters, fingers, where)

    def present_models() -> dict[str, ContactModel]:
        now: Any = node.parameters
        return dict(zip(fingers, models_of(now, fingers, where), strict=True))

    swap = ModelSwap(factory, models, context.name)
    diagnoser = (
        BackgroundDiagnosis(present_models, asdict(parameters.noise), context.name)
        if parameters.suspects
        else None
    )
    node = GraspForce(context.name, fingers, factory(parameters), parameters, store, swap, diagnoser)
    node.lacking = lacking
    return node
