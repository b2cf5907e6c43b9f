"""What a newcomer to the virtual bus says of itself, checked by one rule where it is said and heard."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Final

from vegrip.config import build, parameter
from vegrip.errors import ConfigError
from vegrip.transport.canbus.frame_time import BitTiming
from vegrip.transport.canbus.hub_wire import HUB_VERSION
from vegrip.transport.canbus.node_faults import NodeFaults

MIN_BIT_RATE: Final = 1_000  # [bit/s]
MAX_BIT_RATE: Final = 20_000_000  # [bit/s]
MAX_REASON_CHARS: Final = 200  # characters; the answer must fit into a packet


@dataclass(frozen=True)
class Rates:
    """The bit rates it asks for."""

    bitrate: int = parameter(1_000_000, unit="bit/s", low=MIN_BIT_RATE, high=MAX_BIT_RATE)
    data_bitrate: int = parameter(5_000_000, unit="bit/s", low=MIN_BIT_RATE, high=MAX_BIT_RATE)

    @property
    def timing(self) -> BitTiming:
        """The same for the model of the bus."""
        return BitTiming(self.bitrate, self.data_bitrate)


@dataclass(frozen=True)
class Greeting:
    """What a newcomer says; ``build`` refuses everything that has another type or is out of bounds."""

    version: int = parameter(HUB_VERSION)
    timing: Rates = parameter(Rates())
    must_match_rates: bool = parameter(False, doc="the bit rates must be these")
    wants_own_frames: bool = parameter(False, doc="it wants to hear its own frames")
    listen_only: bool = parameter(False)
    patience: float = parameter(
        -1.0, unit="s", low=-1.0, high=0.1, doc="frames may wait so long to share a packet; negative: none do"
    )
    faults: NodeFaults = parameter(NodeFaults())


def make_greeting(table: Mapping[str, Any]) -> bytes:
    """Return the packet that says ``table``, without what is None.

    Raises:
        ConfigError: it would be refused.

    """
    given = {name: value for name, value in table.items() if value is not None}
    return json.dumps(asdict(build(Greeting, given, "virtual CAN bus"))).encode()


def read_greeting(packet: bytes) -> Greeting:
    """Return what ``packet`` says.

    Raises:
        ConfigError: it is no greeting; the reason is short enough for an answer.

    """
    try:
        said = json.loads(packet)
    except (ValueError, RecursionError):
        said = None
    if not isinstance(said, dict):
        raise ConfigError("it does not speak the language of this bus")
    if said.get("version") != HUB_VERSION:
        raise ConfigError(
            _short(
                f"its version is {said.get('version')}, that of the bus {HUB_VERSION}; "
                "stop the older programs"
            )
        )
    try:
        return build(Greeting, said, "greeting")
    except (ConfigError, TypeError) as error:
        raise ConfigError(_short(str(error))) from None


def _short(reason: str) -> str:
    plain = "".join(c if c.isascii() and c.isprintable() else "?" for c in reason)
    return plain[:MAX_REASON_CHARS]
