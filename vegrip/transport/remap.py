"""Topic remaps: other names on the outside than in the node, whole or from the front."""

from collections.abc import Mapping

from vegrip.errors import ConfigError


class Remap:
    """A table ``{"/hand/thumb": "/gripper/left"}``; the longest entry that is a whole part of the path wins.

    ``/hand/thumb/state`` goes out as ``/gripper/left/state``, and what comes in so is seen as the former.

    Raises:
        ConfigError: a name without leading slash, or two names for one.

    """

    def __init__(self, table: Mapping[str, str] | None = None) -> None:
        table = dict(table or {})
        for name in [*table.keys(), *table.values()]:
            if not name.startswith("/") or name.endswith("/"):
                raise ConfigError(f"the topic {name!r} of a remap must begin with / and not end with it")
        if len(set(table.values())) != len(table):
            raise ConfigError("two topics are remapped to the same name")
        self._outward = table
        self._inward = {outer: inner for inner, outer in table.items()}

    def outward(self, topic: str) -> str:
        """Return the name outside of the node's ``topic``."""
        return _renamed(topic, self._outward)

    def inward(self, topic: str) -> str:
        """Return the node's name of the ``topic`` outside."""
        return _renamed(topic, self._inward)


def _renamed(topic: str, table: Mapping[str, str]) -> str:
    if not table:
        return topic
    head = topic
    while head:
        if head in table:
            return table[head] + topic[len(head) :]
        head = head.rpartition("/")[0]
    return topic
