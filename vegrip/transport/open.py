"""Make an endpoint from the ``[transport]`` table of a configuration."""

import errno
import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import can

from vegrip.config import build, parameter
from vegrip.errors import ConfigError, DeviceError, first_line
from vegrip.messages import USUAL_FINGERS
from vegrip.transport.can_endpoint import CanEndpoint
from vegrip.transport.can_port import check_link, check_rates
from vegrip.transport.canbus.frame_time import BitTiming
from vegrip.transport.codec import CanCodec
from vegrip.transport.endpoint import Endpoint
from vegrip.transport.sender_clock import SenderClock

TRANSPORTS: dict[str, str] = {
    # kind: module:function of (table, hand, where)
    "can": "vegrip.transport.open:open_can",
    "canopen": "vegrip.canopen.hand_endpoint:open_canopen",
    "zmq": "vegrip.transport.open:open_zmq",
    **dict.fromkeys(("udp", "tcp", "serial"), "vegrip.transport.hands.link_endpoint:open_link"),
    "device": "vegrip.transport.hands.device_endpoint:open_device",
    "bench": "vegrip.transport.hands.bench:open_bench",
}
"""What may stand as ``kind`` in a ``[transport]`` table; a transport is imported when one is opened."""

SETTINGS: dict[str, str] = {
    "can": "vegrip.transport.open:CanSettings",
    "canopen": "vegrip.canopen.network:CanopenSettings",
    "zmq": "vegrip.transport.open:ZmqSettings",
    **dict.fromkeys(("udp", "tcp", "serial"), "vegrip.transport.hands.link_endpoint:LinkSettings"),
    "device": "vegrip.transport.hands.device_endpoint:DeviceSettings",
    "bench": "vegrip.transport.hands.bench:BenchSettings",
}
"""What such a table may hold, by its kind."""

GROUP = "vegrip.transports"
"""Entry-point group under which other packages offer transports, each a function like :data:`Opener`."""

ORDER_REACH_STATES = 16
"""States by which another may be overtaken while its order can be restored."""


@dataclass(frozen=True)
class Hand:
    """What a transport must know of the hand at its end."""

    fingers: tuple[str, ...]  # in the order of their numbers on the bus
    number: int = 0  # on CAN
    namespace: str = ""  # on a network
    remap: Mapping[str, str] = field(default_factory=dict)  # on a network: our topics -> topics outside


Opener = Callable[[Mapping[str, Any], Hand, str], Endpoint]
"""Function of a transport: from its table, the hand, and a name of the table for messages."""


@dataclass(frozen=True)
class CanSettings:
    """``[transport]`` with ``kind = "can"``."""

    kind: str = parameter("can")
    interface: str = parameter("vegrip", doc="python-can interface: vegrip, socketcan, virtual, slcan, ...")
    channel: str = parameter("vegrip0", doc="name of the bus or device")
    fd: bool = parameter(True, doc="CAN FD layout; false: classic CAN")
    bitrate: int = parameter(1_000_000, unit="bit/s", low=10_000, high=1_000_000)
    data_bitrate: int = parameter(5_000_000, unit="bit/s", low=10_000, high=10_000_000)
    sender_time: bool = parameter(False, doc="stamp with the sender's clock (FD layout, one clock for all)")
    estimate_clock: bool = parameter(
        False, doc="stamp states with the hand's own clock, its offset and drift estimated (FD layout)"
    )
    order_window: float = parameter(
        0.0, unit="s", low=0.0, high=0.1, doc="wait so long for states that were overtaken; 0 = refuse them"
    )
    options: dict[str, Any] = parameter({}, doc="anything else python-can's interface understands")
    map: str = parameter("", doc="file that says which signals of a hand of another make are meant")


@dataclass(frozen=True)
class ZmqSettings:
    """``[transport]`` with ``kind = "zmq"``."""

    kind: str = parameter("zmq")
    publish: str = parameter("", doc="address to publish at: ipc:NAME or tcp://127.0.0.1:PORT")
    subscribe: tuple[str, ...] = parameter((), doc="addresses to listen to")
    sender_time: bool = parameter(True, doc="keep the sender's stamps; false: the time of arrival")
    batch: bool = parameter(False, doc="states, commands and reports of all fingers as one message each")
    curve: dict[str, Any] = parameter({}, doc="key files: own, peers, publisher")
    map: str = parameter("", doc="file that says where the values stand in messages of another shape")


def map_and_port(text: str) -> tuple[str, str, str]:
    """Split ``PRODUCT@PORT`` or ``FILE[@PORT]`` as ``str.partition`` does; a folder may have an @."""
    file, at, port = text.partition(".toml@")
    if at:
        return f"{file}.toml", "@", port
    return (text, "", "") if text.endswith(".toml") else text.partition("@")


def open_endpoint(
    transport: str | Mapping[str, Any], hand: Hand | None = None, where: str = "", **settings: Any
) -> Endpoint:
    """Open a place on a bus or network, to be closed by ``with``.

    ::

        with open_endpoint("can", interface="socketcan", channel="can0") as bus:
            states = bus.receive(timeout=0.01)

    Args:
        transport: its kind, with its ``settings`` as keywords; or the ``[transport]`` table of a file.
        hand: fingers and number of the hand at the other end; five fingers from thumb to little by default.
        where: name of the table in complaints.
        settings: what the table of this kind of transport may have.

    Raises:
        ConfigError: there is no such kind, or its settings cannot be used.
        DeviceError: there is no such interface, or it is taken.

    """
    table = {"kind": transport, **settings} if isinstance(transport, str) else {**transport, **settings}
    where = where or (f"open_endpoint({transport!r})" if isinstance(transport, str) else "[transport]")
    hand = hand or Hand(USUAL_FINGERS)
    if table.get("map") and table.get("kind", "can") not in UNJOINED:
        joined: Endpoint = importlib.import_module(BENCH).open_map(table, hand, where)
        return joined
    return open_alone(table, hand, where)


def open_alone(table: Mapping[str, Any], hand: Hand, where: str) -> Endpoint:
    """Open what ``table`` says; as :func:`open_endpoint`, but a map not as a part of a hand."""
    return _opener(table.get("kind", "can"), where)(table, hand, where)


def check_settings(table: Mapping[str, Any], where: str) -> None:
    """Check a ``[transport]`` table of a kind of :data:`SETTINGS` without opening anything."""
    module, _, name = SETTINGS[table.get("kind", "can")].partition(":")
    settings = build(getattr(importlib.import_module(module), name), table, where)
    if isinstance(settings, ZmqSettings) and settings.curve:
        from vegrip.transport.curve import Curve  # noqa: PLC0415 (ZeroMQ is not needed on a CAN bus)

        build(Curve, settings.curve, f"{where}.curve")


def _opener(kind: object, where: str) -> Opener:
    known = TRANSPORTS
    if kind not in TRANSPORTS:
        known = {point.name: point.value for point in entry_points(group=GROUP)} | TRANSPORTS
    if not isinstance(kind, str) or kind not in known:
        raise ConfigError(f"{where}: 'kind' is {kind!r}; it must be one of {', '.join(known)}")
    module, _, function = known[kind].partition(":")
    try:
        opener: Opener = getattr(importlib.import_module(module), function)
    except Exception as error:
        if kind in TRANSPORTS:
            raise
        raise ConfigError(
            f"{where}: the transport {kind!r} cannot be loaded from {known[kind]}: {first_line(error)}"
        ) from None
    return opener


def open_bus(settings: CanSettings) -> tuple[can.BusABC, Callable[[], can.BusABC], BitTiming | None]:
    """Return a bus, a function that opens it again, and the bit rates if the load must be estimated."""

    def again() -> can.BusABC:
        if settings.interface == "socketcan":
            check_link(settings.channel, fd=settings.fd)
        options = {"patience": 0.0} if settings.interface == "vegrip" else {}  # frames that end together
        return can.Bus(
            interface=settings.interface,
            channel=settings.channel,
            fd=settings.fd,
            bitrate=settings.bitrate,
            data_bitrate=settings.data_bitrate,
            **{**options, **settings.options},
        )

    try:
        if settings.interface == "socketcan":
            check_link(settings.channel, fd=settings.fd)
            check_rates(settings.channel, settings.bitrate, settings.data_bitrate, fd=settings.fd)
        bus = again()
    except (can.CanError, OSError, ValueError, TypeError, ImportError) as error:
        raise DeviceError(_remedy(settings, error)) from None
    measured = settings.interface == "vegrip"  # the virtual bus knows its load itself
    return bus, again, None if measured else BitTiming(settings.bitrate, settings.data_bitrate)


def open_can(table: Mapping[str, Any], hand: Hand, where: str) -> Endpoint:
    """Open a CAN bus; arguments and errors are those of :func:`open_endpoint`."""
    settings = build(CanSettings, table, where)
    if settings.map:
        mapped: Endpoint = importlib.import_module(MAPPED).open_mapped_can(settings, hand)
        return mapped
    clock = SenderClock() if settings.estimate_clock else None
    codec = CanCodec(
        hand.fingers,
        fd=settings.fd,
        hand=hand.number,
        use_sender_time=settings.sender_time,
        hand_clock=clock.observe if clock is not None else None,
        reach=ORDER_REACH_STATES if settings.order_window > 0.0 else 0,
    )
    bus, again, timing = open_bus(settings)
    return CanEndpoint(bus, codec, again, timing, settings.order_window, clock)


BENCH = "vegrip.transport.hands.bench"
"""Where the parts of a hand are joined."""
UNJOINED = ("device", "bench")
"""Kinds with a map, or several, that are no part themselves."""
MAPPED = "vegrip.transport.hands.endpoints"
"""Where hands of another make are opened; imported when a transport has a map."""


def settings_of_map(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = importlib.import_module(MAPPED).settings_of(path)
    return found


def whole_map(table: Mapping[str, Any], where: str) -> Mapping[str, Any]:
    """Return the map of a hand with what it takes from a product in the box."""
    found: Mapping[str, Any] = importlib.import_module("vegrip.transport.maps.map_text").whole(table, where)
    return found


def parts_of(table: Mapping[str, Any], where: str) -> tuple[tuple[str, ...], dict[str, Any]]:
    """Return the fingers of a hand in parts, and the parameters of the grip controller that follow."""
    fingers, parameters = importlib.import_module(BENCH).settings_of_bench(table, where)
    return fingers, parameters


def _remedy(settings: CanSettings, error: Exception) -> str:
    channel = settings.channel
    what = f"the CAN channel {channel!r} of interface {settings.interface!r} cannot be opened"
    if isinstance(error, can.CanInterfaceNotImplementedError):
        return f"{what}: {error}; interfaces that need nothing else are vegrip and socketcan"
    remedy = {
        errno.EAFNOSUPPORT: "this kernel has no SocketCAN; `sudo modprobe can_raw`",
        errno.ENODEV: "there is no such device; see `ip link`, or for a virtual one "
        f"`sudo ip link add {channel} type vcan && sudo ip link set {channel} up`",
        errno.ENETDOWN: f"it is down; `sudo ip link set {channel} up`",
    }.get(getattr(error, "errno", None) or 0)
    return f'{what}: {remedy}, or use interface = "vegrip"' if remedy else f"{what}: {error}"


def open_zmq(table: Mapping[str, Any], hand: Hand, where: str) -> Endpoint:
    """Open a ZeroMQ endpoint; arguments and errors are those of :func:`open_endpoint`."""
    from vegrip.transport.codec.msgpack_codec import MsgpackCodec  # noqa: PLC0415 (ZeroMQ is not needed on a CAN bus)
    from vegrip.transport.curve import Curve, Keys  # noqa: PLC0415
    from vegrip.transport.zmq_endpoint import ZmqEndpoint  # noqa: PLC0415

    settings = build(ZmqSettings, table, where)
    if not (settings.publish or settings.subscribe):
        raise ConfigError(
            f"{where}: neither 'publish' nor 'subscribe' is given; a node without both is deaf and mute"
        )
    keys = Keys(build(Curve, settings.curve, f"{where}.curve")) if settings.curve else None
    if settings.map:
        mapped: Endpoint = importlib.import_module(MAPPED).open_mapped_zmq(settings, hand, keys)
        return mapped
    codec = MsgpackCodec(hand.namespace, hand.fingers, remap=hand.remap, use_sender_time=settings.sender_time)
    if settings.batch:
        from vegrip.transport.codec.batch_codec import BatchCodec  # noqa: PLC0415
        from vegrip.transport.zmq_endpoint import BatchEndpoint  # noqa: PLC0415

        batches = BatchCodec(hand.fingers, hand.namespace, use_sender_time=settings.sender_time)
        return BatchEndpoint(settings.publish, settings.subscribe, codec, batches, keys)
    return ZmqEndpoint(settings.publish, settings.subscribe, codec, keys)
