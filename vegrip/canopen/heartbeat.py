"""The heartbeat consumer of CiA 301, which the package ``canopen`` lacks. Pure: time comes in."""

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(slots=True)
class _Watched:
    limit: int  # [ns]
    heard: int  # [ns] when last; when the watch began, if never
    state: int | None = None  # of the last heartbeat
    missing: bool = False
    grace: int = 0  # [ns] on top of the limit until the first heartbeat


class HeartbeatConsumer:
    """Watches that nodes go on beating.

    A node is missing when nothing was heard of it for longer than its limit, or nothing at all for ``first``
    since the watch began; stricter than CiA 301, which begins to watch with the first heartbeat and so never
    misses a node that was never there.

    Args:
        limits: node-ID -> longest time between two heartbeats [ns].
        now: [ns] when the watch begins.
        first: [ns] that a node may take to appear; 0: its limit.

    """

    def __init__(self, limits: Mapping[int, int], now: int, first: int = 0) -> None:
        self._nodes = {
            node: _Watched(limit, now, grace=max(first - limit, 0)) for node, limit in limits.items()
        }

    def take_heartbeat(self, node: int, state: int, now: int) -> bool:
        """Note a heartbeat; return whether the node had been missing."""
        watched = self._nodes.get(node)
        if watched is None:
            return False
        returned, watched.missing = watched.missing, False
        watched.heard, watched.state, watched.grace = now, state, 0
        return returned

    def newly_missing(self, now: int) -> list[int]:
        """Return the nodes that have become missing since the last call."""
        lost = []
        for node, watched in self._nodes.items():
            if not watched.missing and now - watched.heard > watched.limit + watched.grace:
                watched.missing, watched.state = True, None
                lost.append(node)
        return lost

    def state(self, node: int) -> int | None:
        return self._nodes[node].state

    @property
    def missing(self) -> list[int]:
        return [node for node, watched in self._nodes.items() if watched.missing]

    @property
    def due(self) -> int:
        """When the next node can become missing [ns]."""
        waiting = [w.heard + w.limit + w.grace + 1 for w in self._nodes.values() if not w.missing]
        return min(waiting, default=2**63 - 1)
