"""``vegrip topic``: what travels between nodes, seen through their telemetry, whatever the transport is."""

import dataclasses
import json
import math
import time
from collections import defaultdict
from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Any

import typer

from vegrip.cli._options import group
from vegrip.cli._terminal import complain, print_json, show, table
from vegrip.errors import DeviceError, UsageError, suggestion
from vegrip.jsonable import jsonable

app = group(
    "Look at topics of running nodes.\n\nExample: vegrip topic echo /hand/thumb/slip_margin --count 3"
)
Prefix = Annotated[str, typer.Argument(help="Topic, or the beginning of several, e.g. /hand/thumb.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object per message (echo) or one in all.")]
Count = Annotated[int, typer.Option(help="End after so many messages; 0: no limit.")]
Duration = Annotated[float, typer.Option(help="End after so many seconds; 0: no limit.")]
LOOK_PERIOD_S = 0.1  # [s]
GONE = 3.0  # [s] without any of the nodes; one that is restarted comes back within


@app.command("list")
def list_(as_json: Json = False) -> None:
    """List the topics, who sends and who receives them, and how many messages there were.

    Example: vegrip topic list

    """
    topics = _topics()
    if as_json:
        print_json(topics)
        return
    if not topics:
        typer.echo("no topic yet; does a node run? See: vegrip lifecycle list")
        return
    content = table("topic", "sent by", "received by", "messages", wraps="received by")
    for topic, row in sorted(topics.items()):
        content.add_row(
            topic, ", ".join(row["from"]) or "(the bus)", ", ".join(row["to"]), str(row["messages"])
        )
    show(content)


@app.command()
def echo(topic: Prefix, count: Count = 0, duration: Duration = 0.0, as_json: Json = False) -> None:
    """Print messages as they come.

    Example: vegrip topic echo /hand/thumb/slip_margin --count 3

    """
    for name, message in _messages(topic, count, duration):
        fields = jsonable(dataclasses.asdict(message), says_infinity=True)
        text = "\n".join(f"  {key}: {value}" for key, value in fields.items() if value is not None)
        print(json.dumps({"topic": name, **fields}) if as_json else f"{name}\n{text}\n---", flush=True)  # noqa: T201


@app.command()
def hz(topic: Prefix = "/", count: Count = 0, duration: Duration = 5.0, as_json: Json = False) -> None:
    """Measure rates: mean, and the shortest and longest time between two messages as they arrive here.

    Example: vegrip topic hz /hand/thumb --duration 2

    """
    arrivals: dict[str, list[float]] = defaultdict(list)
    for name, _ in _messages(topic, count, duration):
        arrivals[name].append(time.monotonic())
    rates = {name: _rate(times) for name, times in sorted(arrivals.items())}
    if as_json:
        print_json(rates)
        return
    if not rates:
        typer.echo(f"nothing came on {topic} within {duration:g} s")
        return
    content = table("topic", "Hz", "shortest/ms", "longest/ms", "messages")
    for name, rate in rates.items():
        numbers = [f"{rate[key]:.2f}" for key in ("hz", "shortest_ms", "longest_ms")]
        content.add_row(name, *numbers, str(rate["messages"]))
    show(content)


def _rate(times: list[float]) -> dict[str, float]:
    gaps = [1e3 * (after - before) for before, after in pairwise(times)]
    mean = (len(times) - 1) / (times[-1] - times[0]) if gaps and times[-1] > times[0] else math.nan
    shortest, longest = (min(gaps), max(gaps)) if gaps else (math.nan, math.nan)
    return {"hz": mean, "shortest_ms": shortest, "longest_ms": longest, "messages": len(times)}


def _messages(prefix: str, count: int, duration: float) -> Iterator[tuple[str, Any]]:
    """Yield topic and message, each message once: as sent or, when no node of ours sends it, as received."""
    from vegrip.runtime.registry import running_nodes
    from vegrip.runtime.telemetry_socket import TelemetryReader

    nodes = running_nodes()
    if not nodes:
        raise UsageError("no node runs; try `vegrip launch demo`")
    there = _topics()
    if there and not any(_is_asked(topic, prefix) for topic in there):
        complain(f"there is no topic {prefix} yet; {suggestion(prefix, there)}; waiting for it")
    sources = _Sources()
    reader = TelemetryReader(nodes, [prefix])
    alive = time.monotonic()
    ends = alive + (duration or math.inf)
    left = count or math.inf
    try:
        while left > 0 and time.monotonic() < ends:
            received = False
            for entry, topic, direction, message in reader.read(min(LOOK_PERIOD_S, ends - time.monotonic())):
                received = True
                if left > 0 and _is_asked(topic, prefix) and sources.counts(topic, entry.name, direction):
                    left -= 1
                    yield topic, message
            if received or running_nodes():
                alive = time.monotonic()
            elif time.monotonic() - alive > GONE:
                raise DeviceError(f"{', '.join(node.name for node in nodes)} ended: nothing comes any more")
    finally:
        reader.close()


class _Sources:
    """Decides which of several sights of one message counts."""

    def __init__(self) -> None:
        topics = _topics()
        self._sent = {topic for topic, row in topics.items() if row["from"]}
        self._receiver = {topic: row["to"][0] for topic, row in topics.items() if row["to"]}

    def counts(self, topic: str, node: str, direction: str) -> bool:
        if direction == "out":
            self._sent.add(topic)
            return True
        return topic not in self._sent and self._receiver.setdefault(topic, node) == node


def _is_asked(topic: str, prefix: str) -> bool:
    return topic == prefix or topic.startswith(prefix.rstrip("/") + "/")


def _topics() -> dict[str, dict[str, Any]]:
    from vegrip.runtime.registry import ask, running_nodes

    found: dict[str, dict[str, Any]] = {}
    for entry in running_nodes():
        try:
            seen = ask(entry, "topics", patience=1.0)
        except DeviceError:
            continue  # still starting
        for topic, counts in seen.items():
            row = found.setdefault(topic, {"from": [], "to": [], "messages": 0})
            row["from"] += [entry.name] if counts["out"] else []
            row["to"] += [entry.name] if counts["in"] else []
            row["messages"] = max(row["messages"], counts["out"], counts["in"])
    return found
