"""Launch files: which nodes belong together, and how each is configured.

What stands above the first ``[[node]]`` (``fingers``, ``hand``, ``namespace``, ``transport``, ``realtime``)
holds for every node that does not say otherwise. ``sensors``, ``drive``, ``serves`` and ``[load]`` there are
a transport, too: that of a hand in parts (:mod:`vegrip.transport.hands.bench`).
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

from vegrip.config import build, merged, parameter, read_toml
from vegrip.errors import ConfigError, suggestion
from vegrip.messages import USUAL_FINGERS
from vegrip.runtime.runner import LoopSettings
from vegrip.transport.open import (
    TRANSPORTS,
    check_settings,
    map_and_port,
    parts_of,
    settings_of_map,
    whole_map,
)

_NAME = re.compile(r"[a-zA-Z][a-zA-Z0-9_]*")


def full_name(namespace: str, name: str) -> str:
    parts = [part for part in namespace.split("/") if part] + [name]
    for part in parts:
        if not _NAME.fullmatch(part):
            raise ConfigError(f"{part!r} is no name for a node or namespace: letters, digits and _ only")
    return "/" + "/".join(parts)


CONTROLLER = {"program": "grasp_force", "required": True, "restart": "always"}
"""The node of a file that names none."""

SHARED = ("fingers", "hand", "namespace", "transport", "realtime")
PARTS = ("sensors", "drive", "serves", "load")
"""What names the parts of a hand; each map has a transport of its own."""


@dataclass(frozen=True)
class NodeConfig:
    """One ``[[node]]`` of a launch file."""

    program: str = parameter(doc="name of a program or module:function")
    name: str = parameter("", doc="of the node; empty: that of the program")
    namespace: str = parameter("", doc="in front of names and topics, one per hand")
    fingers: tuple[str, ...] = parameter(USUAL_FINGERS, doc="in the order of their numbers on the bus")
    hand: int = parameter(0, low=0, high=7, doc="number of the hand on a CAN bus")
    transport: dict[str, Any] = parameter({}, doc="kind and what belongs to it")
    loop: LoopSettings = parameter(LoopSettings(), doc="tick_period, status_period, deadline")
    parameters: dict[str, Any] = parameter({}, doc="of the program")
    remap: dict[str, str] = parameter({}, doc="full topic of the node = full topic outside")
    restart: str = parameter("never", choices=("never", "on-failure", "always"), doc="when it ends by itself")
    required: bool = parameter(False, doc="when it ends for good, everything ends")
    wait: bool = parameter(False, doc="the next node is started when this one is active")
    realtime: bool = parameter(True, doc="real-time priority and locked memory, where they are permitted")

    def __post_init__(self) -> None:
        if not self.fingers:
            raise ConfigError(
                f"{self.program}: 'fingers' is empty; name at least one, as in {list(USUAL_FINGERS[:2])}"
            )

    @property
    def full_name(self) -> str:
        return full_name(self.namespace, self.name or self.program.rpartition(":")[2])


@dataclass(frozen=True)
class _LaunchFile:
    node: tuple[dict[str, Any], ...] = parameter(doc="one [[node]] for each")
    fingers: tuple[str, ...] = parameter(USUAL_FINGERS)
    hand: int = parameter(0)
    namespace: str = parameter("")
    transport: dict[str, Any] = parameter({})
    realtime: bool = parameter(True)


def find_launch_file(name: str) -> Path:
    """Return the path of a launch file: a path, or the name of one that comes with vegrip."""
    given = Path(name)
    for path in (given, Path(f"{name}.toml")):
        if path.is_file():
            return path
    shipped = Path(str(files("vegrip.launch")))
    candidate = shipped / f"{name}.toml"
    if candidate.is_file():
        return candidate
    known = sorted(path.stem for path in shipped.glob("*.toml"))
    raise ConfigError(f"there is no launch file {name!r}; {suggestion(name, known, 'give a path or one of')}")


def read_launch_file(path: Path) -> list[NodeConfig]:
    table = read_toml(path)
    if _is_map(table):
        table = _launch_of(path, whole_map(table, str(path)))
    elif not table.keys().isdisjoint(PARTS):
        table = _launch_of_parts(path, table)
    top = build(_LaunchFile, table, str(path))
    shared = {key: table[key] for key in SHARED if key in table}
    nodes = [
        with_map(path, _node({**shared, **entry}, f"{path} [[node]] number {i}"))
        for i, entry in enumerate(top.node, 1)
    ]
    names = [node.full_name for node in nodes]
    for name in names:
        if names.count(name) > 1:
            raise ConfigError(
                f"{path}: two nodes are called {name}; give each a name or namespace of its own"
            )
    return nodes


def _is_map(table: Mapping[str, Any]) -> bool:
    """Whether ``table`` is the map of a hand of another make: it has fingers and no nodes."""
    return "node" not in table and ("like" in table or isinstance(table.get("fingers"), Mapping))


def _launch_of(path: Path, table: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a launch file for the map of a hand would say: the grip controller on its bus."""
    transport = table.get("transport")
    if not isinstance(transport, Mapping):
        raise ConfigError(
            f"{path}: is the map of a hand and does not say where the hand is; add [transport] with kind, "
            'interface and channel, or name the map in a launch file: transport.map = "..."'
        )
    return {
        "fingers": [name for name in table["fingers"] if name != "*"],
        "transport": {**transport, "map": path.name},
        "node": [{**CONTROLLER}],
    }


def _launch_of_parts(path: Path, table: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a launch file with the parts of a hand says, with a transport made of them."""
    if "transport" in table:
        raise ConfigError(
            f"{path}: [transport] is of a hand of one map; sensors and drive have theirs in their own maps"
        )
    known = [*PARTS, *(field.name for field in fields(_LaunchFile))]
    for key in [
        key for key in table if key not in known
    ]:  # before the parts are read, which a misspelt one is missing from
        raise ConfigError(f"{path}: unknown key {key!r}; {suggestion(key, known, 'known are')}")
    parts = {key: table[key] for key in PARTS if key in table}
    transport = {"kind": "bench", **{key: _beside(path, value) for key, value in parts.items()}}
    rest = {key: value for key, value in table.items() if key not in PARTS}
    for entry in rest.get("node", ()):
        if entry.get("transport", {}).keys() == {"virtual"}:  # of a virtual hand: it is the devices
            entry["transport"] = transport | entry["transport"]
    fingers = rest.get("fingers") or list(parts_of(transport, str(path))[0])
    return {"node": [{**CONTROLLER}], **rest, "fingers": fingers, "transport": transport}


def _beside(path: Path, value: Any) -> Any:
    """Return ``value`` with the files in it that lie beside ``path``."""
    if isinstance(value, Mapping):
        return {key: _beside(path, one) if key == "from" else one for key, one in value.items()}
    if isinstance(value, list):
        return [_beside(path, one) for one in value]
    return _file_beside(path, value) if isinstance(value, str) else value


def _file_beside(path: Path, text: str) -> str:
    """Return ``[FINGER=]FILE[@PORT]`` with the file as it lies beside ``path``, all else as it is."""
    head, at, port = map_and_port(text)
    before, equals, after = head.partition("=")
    for first, name in (("", head), (before + equals, after)):
        beside = path.parent / name
        if beside.is_file() and (not at or name.endswith(".toml")):
            return f"{first}{beside}{at}{port}"
    return text


def _with_parts(path: Path, node: NodeConfig) -> NodeConfig:
    """Return ``node`` with parameters of the parts of its hand, where it has none itself."""
    parameters = merged(parts_of(node.transport, str(path))[1], node.parameters)
    limits = parameters.get("limits", {})
    largest = limits.get("max_force", math.inf) if isinstance(limits, Mapping) else limits
    if not isinstance(largest, (int, float)) or not largest >= 0.0:
        raise ConfigError(f"{path}: limits.max_force is {largest!r}; give a number in N, such as 40.0")
    transport = {**node.transport, "largest": float(largest)} if largest < math.inf else node.transport
    parameters = merged(parts_of(transport, str(path))[1], node.parameters)  # with what follows from it
    return replace(node, parameters=parameters, transport=transport)


def with_map(path: Path, node: NodeConfig) -> NodeConfig:
    """Return ``node`` with parameters of the map of its hand, beside ``path``, where it has none itself."""
    if node.transport.get("kind") == "bench" and node.program == "grasp_force":
        return _with_parts(path, node)
    name = node.transport.get("map")
    if not isinstance(name, str) or not name:
        return node
    beside = path.parent / name
    found = beside if beside.is_file() else Path(name)
    node = replace(node, transport={**node.transport, "map": str(found)})
    if node.program != "grasp_force":
        return node
    return replace(node, parameters=merged(settings_of_map(found), node.parameters))


def _node(table: Mapping[str, Any], where: str) -> NodeConfig:
    name = table.get("name") or table.get("program")
    where = f"{where} ({name})" if name else where
    node = build(NodeConfig, table, where)
    kind = node.transport.get("kind", "can")
    if not isinstance(kind, str) or kind not in TRANSPORTS:
        raise ConfigError(
            f"{where}: 'kind' of the transport is {kind!r}; it must be one of {', '.join(TRANSPORTS)}"
        )
    check_settings(node.transport, f"{where} [transport]")
    return node
