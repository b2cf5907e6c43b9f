"""The gripper in MuJoCo on a bus, in place of the virtual hand: a program for `vegrip node`."""

from collections.abc import Mapping
from typing import Any

from vegrip.bridges.mujoco_plant import MujocoHand
from vegrip.errors import ConfigError
from vegrip.nodes import virtual_hand
from vegrip.nodes.virtual_bench import VirtualBenchNode
from vegrip.runtime import NodeContext


class MujocoHandNode(virtual_hand.VirtualHandNode):
    """The node of the virtual hand, with the parameters of that, in a world that is not ours."""

    plant = MujocoHand


def build(settings: Mapping[str, Any], context: NodeContext) -> MujocoHandNode:
    """Make the node; its two fingers are the first two of the bus, opposed to each other."""
    pinch = {"fingers": list(context.fingers[:2]), "x": [0.0, 0.0], "y": [0.0, 0.0]}
    node = virtual_hand.build({**settings, "hand": pinch | settings.get("hand", {})}, context)
    if isinstance(node, VirtualBenchNode):
        raise ConfigError(f"{context.name} [parameters]: 'protocol' is for fingertips without MuJoCo")
    return MujocoHandNode(node.name, node.parameters)
