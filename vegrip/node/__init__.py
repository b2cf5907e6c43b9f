"""The node runtime: lifecycle, loop, parameters, telemetry and control of a running node."""

from vegrip.node.node import Node, NodeBase
from vegrip.node.program import NodeContext

__all__ = ["Node", "NodeBase", "NodeContext"]
