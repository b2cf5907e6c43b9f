"""A node without physics: answers every state at once, to measure the latency of bus and runtime alone."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from vegrip.clock import NS
from vegrip.config import build as build_parameters
from vegrip.config import parameter
from vegrip.host.realtime import NODE_PRIORITY
from vegrip.messages import FingertipState, ForceCommand, Message, NodeStatus, Reason
from vegrip.runtime.node import NodeBase, NodeContext


@dataclass(frozen=True)
class EchoParameters:
    """What the echo answers."""

    normal_force: float = parameter(1.0, unit="N", low=0.0, high=20.0, doc="of every command")
    validity: float = parameter(0.1, unit="s", low=0.001, high=10.0, doc="of every command")


class EchoNode(NodeBase):
    """Answers each state with a command that has its number."""

    exclusive_messages: tuple[type[Message], ...] = (ForceCommand,)
    received_messages: tuple[type[Message], ...] = (
        FingertipState,
        ForceCommand,
        NodeStatus,
    )  # also of rivals
    realtime_priority = NODE_PRIORITY

    parameters: EchoParameters

    def on_message(self, message: Message, now: int) -> Iterable[Message]:
        if not isinstance(message, FingertipState):
            return ()
        p = self.parameters
        expires = now + round(p.validity * NS)
        return (ForceCommand(now, message.finger, message.seq, p.normal_force, 0.0, Reason.HOLD, expires),)


def build(settings: Mapping[str, Any], context: NodeContext) -> EchoNode:
    parameters = build_parameters(EchoParameters, settings, f"{context.name} [parameters]")
    return EchoNode(context.name, parameters)
