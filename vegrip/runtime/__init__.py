"""The node runtime: lifecycle, loop, parameters, telemetry and control of a running node."""

from vegrip.runtime.node import NodeBase, NodeContext

__all__ = ["NodeBase", "NodeContext"]
