"""Watch running nodes through their telemetry, whatever their transport is."""

import time
from collections.abc import Iterator
from dataclasses import replace

from vegrip.errors import DeviceError, UsageError
from vegrip.messages import Message, NodeStatus
from vegrip.node.client import ask
from vegrip.node.registry import Entry, running_nodes
from vegrip.node.telemetry_socket import TelemetryReader

KINDS = ("contact", "slip_margin", "force_command", "model_health", "diagnostics")
"""What is asked for. Not the states: at 500 Hz each they would cost the node more than they show here."""

PATIENCE = 0.05  # [s] of one look


def watch(duration: float = 0.0) -> Iterator[Message | None]:
    """Yield what the running nodes send, and None from time to time; fingers carry their namespace.

    Args:
        duration: [s] end after this; 0 = never.

    Raises:
        UsageError: no node runs, or none of them says anything of a finger yet.

    """
    entries = running_nodes()
    if not entries:
        raise UsageError("no node runs; start one with `vegrip launch demo`")
    reader = TelemetryReader(entries, _topics(entries))
    ends = time.monotonic() + duration if duration > 0.0 else None
    try:
        while ends is None or time.monotonic() < ends:
            for entry, _, direction, message in reader.read(PATIENCE):
                if direction == "out":
                    yield _named(message, entry.namespace)
            yield None
    finally:
        reader.close()


def _topics(entries: list[Entry]) -> list[str]:
    topics: set[str] = set()
    for entry in entries:
        try:
            seen = ask(entry, "topics", patience=2.0)
        except DeviceError:
            continue  # still starting
        topics |= {topic for topic in seen if topic.rpartition("/")[2] in KINDS}
    if not topics:
        raise UsageError("no running node says anything of a finger yet; try again in a moment")
    return sorted(topics)


def _named(message: Message, namespace: str) -> Message:
    if isinstance(message, NodeStatus) or not namespace:
        return message
    return replace(message, finger=f"{namespace}/{message.finger}")
