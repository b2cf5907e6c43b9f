"""The topics of running nodes, each received at its senders, else at one of its receivers."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any

from vegrip.errors import VegripError
from vegrip.messages import Message
from vegrip.runtime.registry import Entry, ask, running_nodes
from vegrip.runtime.telemetry_socket import NEWEST, TelemetryReader
from vegrip.transport.codec.msgpack_codec import MsgpackCodec

ANSWER_PATIENCE = 1.0  # [s] for a node to answer; one that is starting is asked again later
READ_PERIOD = 0.02  # [s] of one look at the telemetry


@dataclass(frozen=True, slots=True)
class Source:
    """Where a topic is received, and what travels on it."""

    kind: type[Message]
    direction: str  # "out": its senders are received, "in": a receiver, of what no node here sends
    entries: list[Entry]  # several senders of diagnostics, each of its own


class NodeTopics:
    """What the nodes of this machine say on the topics that are asked for; each costs its node time."""

    def __init__(self, *, newest: bool = False) -> None:
        self._begin = NEWEST if newest else ""
        self._sources: dict[str, Source] = {}
        self._reader: TelemetryReader | None = None
        self._asked: set[tuple[str, str]] = set()  # node and topic

    def look(self) -> dict[str, type[Message]]:
        """Ask the nodes; return topic -> kind of message of all topics that were ever there."""
        found: dict[str, Source] = {}
        for entry in running_nodes():
            topics = MsgpackCodec(entry.namespace, remap=entry.remap).topics
            for topic, counts in _counts(entry).items():
                direction = "out" if counts["out"] else "in"
                route = topics.incoming(topic)
                known = found.get(topic)
                if route is not None and (known is None or (known.direction, direction) == ("in", "out")):
                    found[topic] = Source(route.schema.cls, direction, [entry])
                elif known is not None and direction == known.direction == "out":
                    known.entries.append(entry)
        self._sources = self._sources | found
        return {topic: source.kind for topic, source in self._sources.items()}

    def read(self, topics: Collection[str], period: float = READ_PERIOD) -> list[tuple[str, Message]]:
        """Return topic and message of what comes on ``topics`` within ``period`` [s]."""
        self._reader = self._reader or TelemetryReader(())
        places = set()
        for topic in self._sources.keys() & topics:
            for entry in self._sources[topic].entries:
                places.add((entry.name, topic, self._sources[topic].direction))
                if (pair := (entry.name, topic)) not in self._asked:
                    self._asked.add(pair)
                    self._reader.add(entry, [self._begin + topic])
        received = self._reader.read(period)
        return [(topic, one) for entry, topic, way, one in received if (entry.name, topic, way) in places]

    def rest(self) -> None:
        """Leave the nodes alone until :meth:`read` is called again: a node forgets who has disconnected."""
        if self._reader is not None:
            self._asked.clear()
            self._reader.close()
            self._reader = None


def _counts(entry: Entry) -> dict[str, dict[str, int]]:
    try:
        counts: dict[str, dict[str, int]] = ask(entry, "topics", ANSWER_PATIENCE)
    except VegripError:
        return {}
    return counts


def node_parameters() -> Iterator[tuple[Entry, dict[str, Any]]]:
    """Yield every node with its parameters, but those that are starting or have just ended."""
    for entry in running_nodes():
        try:
            yield entry, {row["name"]: row["value"] for row in ask(entry, "parameters", ANSWER_PATIENCE)}
        except VegripError:
            continue
