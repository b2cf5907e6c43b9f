"""The grasp force node on a bus: fingertip states in, slip margins and force commands out."""

from collections.abc import Mapping
from typing import Any

from vegrip.config import build as build_parameters
from vegrip.grasp.node import GraspForce
from vegrip.grasp.parameters import GraspParameters, estimator_factory, memory_of
from vegrip.node import NodeContext


def build(settings: Mapping[str, Any], context: NodeContext) -> GraspForce:
    """Make the node; the fingers are those of the bus."""
    where = f"{context.name} [parameters]"
    parameters = build_parameters(GraspParameters, settings, where)
    memory = memory_of(parameters)
    make_estimator = estimator_factory(parameters, context.fingers, where, memory)
    return GraspForce(context.name, context.fingers, make_estimator, parameters, memory)
