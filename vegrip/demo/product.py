"""The demonstration as a product: the virtual hand behind the virtual device of a map.

Hand and node speak the product's own protocol, with its rate, polls, steps and gaps. The node copies what it
receives and sends to the bus of the demonstration, where it is watched and recorded.
"""

import os
import socket
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from vegrip.config import read_toml
from vegrip.connect.writer import checked
from vegrip.errors import ConfigError
from vegrip.grip.parameters import GraspParameters
from vegrip.messages import FingertipState, Message
from vegrip.transport.codec.frame_codec import Line
from vegrip.transport.endpoint import Endpoint
from vegrip.transport.mapped.plan import Plan
from vegrip.transport.mapped.price import settings
from vegrip.transport.maps.products import map_of, virtual_text
from vegrip.trials import candidates
from vegrip.trials.closed_loop import Scenario
from vegrip.virtual import HandSettings
from vegrip.whole_file import write_whole

COUNTER_FACE: Final = "counter_face"
"""The other jaw of a gripper that has one sensor: nothing is measured there."""
MOST_FINGERS: Final = 5
OPPOSING: Final = {"radius": HandSettings().opposing_radius}  # the tip of the first finger
USUAL_LATENCY_S: Final = 1e-3


@dataclass(frozen=True)
class Product:
    """A map, and how it is demonstrated."""

    path: Path  # of the map as the virtual device speaks it
    plan: Plan
    name: str
    latency: float  # [s] of the device

    @property
    def fingers(self) -> tuple[str, ...]:
        return tuple(finger.name for finger in self.plan.fingers)

    def scenario(self, seed: int, duration: float) -> Scenario:
        """Return what its fingers go through; one alone has a bare jaw against it."""
        fingers = self.fingers if len(self.fingers) > 1 else (COUNTER_FACE, *self.fingers)
        if len(fingers) > MOST_FINGERS:
            raise ConfigError(f"{self.path}: has {len(fingers)} fingers; the virtual hand has {MOST_FINGERS}")
        grasp = "pinch" if len(fingers) == 2 else "hand"
        return Scenario(seed, duration, grasp, relaxes_slowly=False, names=fingers)

    def parameters(self, scenario: Scenario) -> GraspParameters:
        """Return the parameters of the node: those of the demonstration, with what follows from the map."""
        feels_slip = all("slip" in finger.measured for finger in self.plan.fingers)
        name = candidates.DEMONSTRATED if feels_slip else "vegrip"
        base = candidates.parameters(name, candidates.KNOBS[scenario.grasp][name])
        first = scenario.settings.fingers[0]
        found = settings(self.plan)
        return replace(
            base,
            tips=dict.fromkeys({first} & set(self.fingers), OPPOSING),
            noise=replace(base.noise, **found.get("noise", {})),
            watchdog=replace(base.watchdog, **found.get("watchdog", {})),
            limits=replace(base.limits, **found.get("limits", {})),
        )

    def transports(self, folder: Path) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the transports of the virtual device and of the node."""
        table = dict(self.plan.hand.transport)
        at = {
            "can": {"channel": f"demo-{os.getpid()}-device", "interface": "vegrip"},
            "serial": {"address": str(folder / "tty")},
        }.get(table["kind"], {"address": f"127.0.0.1:{free_port(table['kind'])}"})
        device = {"kind": "device", "map": str(self.path), "latency": self.latency, **at}
        return device, {**table, **at, "map": str(self.path)}

    def describe(self) -> str:
        """Return how it speaks, and what of the load it does not measure."""
        hand = self.plan.hand
        parts = [f"over {hand.transport['kind']}", f"{hand.rate:g} states/s" if hand.rate else ""]
        parts.append(f"asked {len(hand.device.poll)} ways" if hand.device.poll else "sending by itself")
        parts.append(f"answers after {1e3 * self.latency:g} ms")
        blind = [finger.name for finger in self.plan.fingers if "torque_z" not in finger.measured]
        twisted = (
            f"\n{', '.join(blind)}: no torque is measured, so the force does not rise as the object is "
            "twisted, and it may slip or be dropped"
        )
        return f"{self.name}: {', '.join(one for one in parts if one)}{twisted if blind else ''}"


def open_product(name: str, folder: Path) -> Product:
    """Return the product, or the map at a path, ``name``; its map is written to ``folder``."""
    source = Path(name) if name.endswith(".toml") else map_of(name)
    latency = read_toml(source).get("product", {}).get("virtual", {}).get("latency", USUAL_LATENCY_S)
    path = folder / "device.toml"
    plan, text = checked(virtual_text(source), path, [])
    if all(finger.is_drive for finger in plan.fingers):
        raise ConfigError(f"{name} is a drive and feels nothing; name a product that measures a force")
    folder.mkdir(parents=True, exist_ok=True)
    write_whole(path, text)
    return Product(path, plan, plan.hand.product.get("name", source.stem), float(latency))


class CopyingEndpoint(Endpoint):
    """An endpoint of which all that comes and goes is also sent to a bus."""

    def __init__(self, inner: Endpoint, bus: Endpoint) -> None:
        self._inner, self._bus, self.broken = inner, bus, inner.broken

    @property
    def rejected(self) -> Mapping[str, int]:
        return self._inner.rejected

    @property
    def sentences(self) -> Sequence[str]:
        return self._inner.sentences

    def receive(self, timeout: float) -> Sequence[Message]:
        """Receive, and copy the states."""
        messages = self._inner.receive(timeout)
        self.arrivals = self._inner.arrivals
        self._bus.send_all([one for one in messages if isinstance(one, FingertipState)])
        return messages

    def send(self, message: Message) -> None:
        self._inner.send(message)
        self._bus.send(message)

    def line(self, finger: str) -> Line | None:  # noqa: ARG002
        """Return None: what travels as bytes would not be copied."""
        return None

    def bus_load(self) -> float:
        return self._inner.bus_load()

    def zero(self) -> bool:
        return self._inner.zero()

    def close(self) -> None:
        self._inner.close()
        self._bus.close()


def free_port(kind: str) -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM if kind == "tcp" else socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])
