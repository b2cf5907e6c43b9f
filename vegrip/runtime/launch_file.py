"""Launch files: which nodes belong together, and how each is configured.

What stands above the first ``[[node]]`` (``fingers``, ``hand``, ``namespace``, ``transport``) holds for every
node that does not say otherwise.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from vegrip.config import build, parameter, read_toml
from vegrip.errors import ConfigError
from vegrip.runtime.names import full_name
from vegrip.runtime.runner import LoopSettings
from vegrip.spelling import suggestion
from vegrip.transport.open import TRANSPORTS

FINGERS = ("thumb", "index", "middle", "ring", "little")
SHARED = ("fingers", "hand", "namespace", "transport")


@dataclass(frozen=True)
class NodeConfig:
    """One ``[[node]]`` of a launch file."""

    program: str = parameter(doc="name of a program or module:function")
    name: str = parameter("", doc="of the node; empty: that of the program")
    namespace: str = parameter("", doc="in front of names and topics, one per hand")
    fingers: tuple[str, ...] = parameter(FINGERS, doc="in the order of their numbers on the bus")
    hand: int = parameter(0, low=0, high=7, doc="number of the hand on a CAN bus")
    transport: dict[str, Any] = parameter({}, doc="kind and what belongs to it")
    loop: LoopSettings = parameter(LoopSettings(), doc="tick_period, status_period, deadline")
    parameters: dict[str, Any] = parameter({}, doc="of the program")
    remap: dict[str, str] = parameter({}, doc="full topic of the node = full topic outside")
    restart: str = parameter("never", choices=("never", "on-failure", "always"), doc="when it ends by itself")
    required: bool = parameter(False, doc="when it ends for good, everything ends")
    wait: bool = parameter(False, doc="the next node is started when this one is active")

    def __post_init__(self) -> None:
        if not self.fingers:
            raise ConfigError(
                f"{self.program}: 'fingers' is empty; name at least one, as in {list(FINGERS[:2])}"
            )

    @property
    def full_name(self) -> str:
        """The name with the namespace."""
        return full_name(self.namespace, self.name or self.program.rpartition(":")[2])


@dataclass(frozen=True)
class _LaunchFile:
    node: tuple[dict[str, Any], ...] = parameter(doc="one [[node]] for each")
    fingers: tuple[str, ...] = parameter(FINGERS)
    hand: int = parameter(0)
    namespace: str = parameter("")
    transport: dict[str, Any] = parameter({})


def find_launch_file(name: str) -> Path:
    """Return the path of a launch file: a path, or the name of one that comes with vegrip.

    Raises:
        ConfigError: there is none.

    """
    given = Path(name)
    if given.is_file():
        return given
    shipped = Path(str(files("vegrip.launch")))
    candidate = shipped / f"{name}.toml"
    if candidate.is_file():
        return candidate
    known = sorted(path.stem for path in shipped.glob("*.toml"))
    raise ConfigError(f"there is no launch file {name!r}; {suggestion(name, known, 'give a path or one of')}")


def read_launch_file(path: Path) -> list[NodeConfig]:
    """Return the nodes of a launch file, in order.

    Raises:
        ConfigError: unknown keys, two nodes of one name, ...

    """
    table = read_toml(path)
    top = build(_LaunchFile, table, str(path))
    shared = {key: table[key] for key in SHARED if key in table}
    nodes = [_node({**shared, **entry}, f"{path} [[node]] number {i}") for i, entry in enumerate(top.node, 1)]
    names = [node.full_name for node in nodes]
    for name in names:
        if names.count(name) > 1:
            raise ConfigError(
                f"{path}: two nodes are called {name}; give each a name or namespace of its own"
            )
    return nodes


def _node(table: Mapping[str, Any], where: str) -> NodeConfig:
    name = table.get("name") or table.get("program")
    where = f"{where} ({name})" if name else where
    node = build(NodeConfig, table, where)
    kind = node.transport.get("kind", "can")
    if not isinstance(kind, str) or kind not in TRANSPORTS:
        raise ConfigError(
            f"{where}: 'kind' of the transport is {kind!r}; it must be one of {', '.join(TRANSPORTS)}"
        )
    return node
