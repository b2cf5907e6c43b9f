"""A hand in parts, as a launch file names them: pads that feel, a drive that presses, a sensor at the wrist.

::

    sensors = ["left.toml", "right.toml"]    # [FINGER=]FILE[@PORT], or [FINGER=]PRODUCT@PORT
    drive = "robotiq-2f85@/dev/ttyUSB0"
    serves = ["left", "right"]               # the drive's fingers; none: all
    load = { from = "wrist.toml", mass = 0.9 }

A hand of one map is the case where all of it is one file.
"""

import math
import os
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

from vegrip.config import build, merged, parameter
from vegrip.errors import ConfigError, suggestion
from vegrip.grip.safety import NOT_MEASURED_S, WatchdogSettings
from vegrip.grip.safety.drive import DriveLimits
from vegrip.transport.byte_link import host_and_port
from vegrip.transport.endpoint import Endpoint
from vegrip.transport.hands.bench_endpoint import BenchEndpoint, Drive, Part
from vegrip.transport.hands.drive_steps import range_of
from vegrip.transport.hands.virtual_bench import VirtualBench
from vegrip.transport.hands.wrist_load import LoadSettings, WristLoad, read_load
from vegrip.transport.mapped.largest_force import USUAL_N, largest_felt, largest_force
from vegrip.transport.mapped.plan import Plan, open_plan
from vegrip.transport.mapped.price import price, price_of_drive, price_of_sensors, settings
from vegrip.transport.maps import products
from vegrip.transport.maps.products import map_of
from vegrip.transport.open import Hand, map_and_port, open_alone

JAWS: Final = ("left", "right")
"""The fingers of a gripper without sensors in them, unless ``serves`` names them."""
OTHER_PARTS: Final = ("drive", "wrist")
"""What the parts without fingers are called in counts and logs; no finger is."""
MOST_LAG: Final = 0.05
"""[s] by which a load is led at most, in a straight line: of a shake at 4 Hz it makes 1.6 times as much, and
0.2 s would make 5.1 times. A drive that is slower holds the largest need of half a second in any case."""

SOFT_PA: Final = 3e5  # [Pa] the usual ``tip.modulus``, of tips that bear the usual limit (USUAL_N)
FELT_OVER: Final = 1.5
"""Times the largest force that a pad may feel: gains of drive and pads, noise, what presses besides."""


@dataclass(frozen=True)
class BenchSettings:
    """``[transport]`` of a hand in parts."""

    kind: str = parameter("bench")
    sensors: tuple[str, ...] = parameter((), doc="maps that feel: [FINGER=]FILE[@PORT] or PRODUCT@PORT")
    drive: str = parameter("", doc="map of the gripper that presses")
    serves: tuple[str, ...] = parameter((), doc="fingers that it presses with; none: all")
    load: dict[str, Any] = parameter({}, doc="from, mass [kg], share, share_std: of a sensor at the wrist")
    largest: float = parameter(math.inf, unit="N", low=0.0, doc="limits.max_force, which no step is above")
    virtual: bool = parameter(False, doc="be the devices, for a virtual hand, instead of speaking to them")


@dataclass(frozen=True)
class Source:
    """One map and where its device is."""

    text: str  # as it is named
    path: Path
    plan: Plan = field(compare=False)  # that of the map
    transport: Mapping[str, Any]
    names: Mapping[str, str]  # its finger -> that of the hand

    @property
    def where(self) -> str:
        port = self.transport.get("address") or self.transport.get("channel") or "its port"
        return self.text if map_and_port(self.text)[1] else f"{self.text} at {port}"

    @property
    def commanded(self) -> tuple[str, ...]:
        return tuple(name for name, finger in self.plan.hand.fingers.items() if finger.command is not None)

    def under_our_names(self, besides: Collection[str]) -> Iterator[str]:
        """Yield what its owner must know, with our names of its fingers; ``besides`` is what others feel."""
        for text in price_of_sensors(self.plan, besides):
            head, colon, rest = text.partition(": ")
            yield f"{self.names[head]}{colon}{rest}" if head in self.names else text

    def open(self, where: str, *, virtual: bool = False) -> Endpoint:
        table = {**self.transport, "map": str(self.path)}
        if virtual:
            at = {"address": self.transport.get("address"), "channel": self.transport.get("channel")}
            table = {"kind": "device", "map": str(self.path)} | {key: one for key, one in at.items() if one}
        return open_alone(table, Hand(tuple(one.name for one in self.plan.fingers)), where)


@dataclass(frozen=True)
class Bench:
    """All parts of a hand."""

    sensors: tuple[Source, ...]
    drive: Source | None
    wrist: Source | None
    load: LoadSettings | None
    serves: tuple[str, ...]
    largest: float = math.inf  # [N] that the drive is asked for

    @property
    def fingers(self) -> tuple[str, ...]:
        felt = [ours for source in self.sensors for ours in source.names.values()]
        return tuple(dict.fromkeys([*felt, *self.serves]))

    @property
    def parts(self) -> dict[str, Source]:
        """Each device once, by what it is called."""
        found = {"_".join(source.names.values()): source for source in self.sensors}
        others = dict(zip(OTHER_PARTS, (self.drive, self.wrist), strict=True))
        return found | {
            name: one for name, one in others.items() if one is not None and one not in found.values()
        }

    def parameters(self) -> dict[str, Any]:
        """Return the parameters of the grip controller that follow from the parts."""
        both: dict[str, Any] = {}
        for source in self.sensors:
            found = settings(source.plan)
            if gains := found.pop("sensors", {}):
                own = {ours: gains.get("fingers", {}).get(name, {}) for name, ours in source.names.items()}
                rest = {key: value for key, value in gains.items() if key != "fingers"}
                found["sensors"] = {"fingers": {ours: rest | one for ours, one in own.items()}}
            both = _largest(both, found)
        if self.wrist is not None and self.load is not None:
            found = settings(self.wrist.plan)
            told = {"tangential_force", *(("torque_z",) if self.load.reach else ())}
            noise = {k: one * self.load.share for k, one in found.get("noise", {}).items() if k in told}
            both = _largest(both, {"noise": noise} if noise else {})
            blind = [name for name in self.serves if not self._feels_load(name)]
            gains = dict.fromkeys(blind, self.load.parameters)
            both = _largest(both, {"sensors": {"fingers": gains}} if gains else {})
            if not self.sensors:
                wait = found.get("watchdog", {})
                both["watchdog"] = wait | {"force_frozen_after": NOT_MEASURED_S}
        return both if self.drive is None else merged(both, self._of_drive(both.get("limits", {})))

    def _of_drive(self, limits: Mapping[str, Any]) -> dict[str, Any]:
        assert self.drive is not None  # noqa: S101 (asked by the caller)
        hand = self.drive.plan.hand
        known = [largest_force(self.drive.plan), *(largest_felt(source.plan) for source in self.sensors)]
        forces = [one.force for one in known if one is not None]
        limits = {**limits, **({"max_force": min(forces)} if forces else {}), **hand.limits}
        lag = hand.drive.delay + (1.0 / hand.drive.rate if hand.drive.rate > 0.0 else 0.0)
        grip = {"grip": {"drive_lag": round(min(lag, MOST_LAG), 4)}} if lag else {}
        found = {"limits": limits, "thumb": self.serves[0] if len(self.serves) == 2 else "", **grip}
        return found | ({} if math.isinf(self.largest) else self._of_largest())

    def _of_largest(self) -> dict[str, Any]:
        """Return that pads bear the largest force, and are believed to feel somewhat more."""
        low, most = WatchdogSettings().ranges.normal_force
        ranges = {"normal_force": [low, max(most, FELT_OVER * self.largest)]}
        return {"watchdog": {"ranges": ranges}, "tip": {"modulus": self._modulus}}

    @property
    def _modulus(self) -> float:
        """Modulus [Pa] with which a tip bears the largest force as the usual one bears the usual."""
        return SOFT_PA * max(self.largest / USUAL_N, 1.0)

    def _feels_load(self, finger: str) -> bool:
        return any(
            "tangential_force_x" in one.measured
            for source in self.sensors
            for one in source.plan.fingers
            if source.names[one.name] == finger
        )

    def sentences(self) -> list[str]:
        """Return what the owner must know before it grips."""
        if self.drive is None and self.wrist is None:
            return [text for source in self.sensors for text in price(source.plan)]
        shared = ["tangential_force_x", "tangential_force_y"] if self.wrist is not None else []
        shared += ["torque_z"] if self.load is not None and self.load.reach else []
        said = [text for source in self.sensors for text in source.under_our_names(shared)]
        if self.wrist is not None and self.load is not None:
            said.append(
                f"the load of {', '.join(self.serves)} is felt at {self.wrist.where}, and a finger "
                f"carries {self.load.share:g} +- {self.load.share_std:g} of it; "
                + ("" if self.load.reach else "no torque is known without its 'reach', and ")
                + "the gripper must be empty for a second at the start, and be weighed again (`vegrip zero`) "
                "once it is turned"
            )
        if self.drive is not None:
            said += [*price_of_drive(self.drive.plan), *_of_steps(self.drive.plan.hand.drive)]
            if math.isfinite(self.largest):
                said.append(
                    f"tip.modulus is {self._modulus / 1e6:.2g} MPa where you state none: of pads that bear "
                    f"{self.largest:g} N"
                )
        return list(dict.fromkeys(said))


def read_bench(given: BenchSettings, where: str) -> Bench:
    """Read all maps of a hand in parts.

    Raises:
        ConfigError: a map that is not there or not one, or parts that do not belong together.

    """
    sensors = tuple(read_source(text, where) for text in given.sensors)
    drive = read_source(given.drive, where) if given.drive else None
    load = read_load(given.load, f"{where}: [load]") if given.load else None
    wrist = read_source(load.source, where) if load is not None else None
    felt = tuple(ours for source in sensors for ours in source.names.values())
    serves = (given.serves or felt or JAWS) if drive is not None else ()
    bench = Bench(sensors, drive, wrist, load, serves, given.largest)
    for said in (*_misfits_of_parts(bench), *_misfits_of_drive(bench, given)):
        raise ConfigError(f"{where}: {said}")
    return bench


def _misfits_of_parts(bench: Bench) -> Iterator[str]:
    """Yield which parts have a finger, or a port, that another has."""
    if taken := [name for name in bench.fingers if name in OTHER_PARTS]:
        yield f"{taken[0]!r} is what another part of a bench is called; give this finger another name"
    owner: dict[str, Source] = {}
    for source in bench.sensors:
        for ours in source.names.values():
            if ours in owner:
                yield (
                    f"{ours} is a finger of {owner[ours].text} and of {source.text}; say whose is which, as "
                    f"in 'left={source.text.rpartition('=')[2]}', or rename one in its file"
                )
            owner[ours] = source
    at: dict[str, Source] = {}
    for source in bench.parts.values():
        port = str(source.transport.get("address", ""))
        other = at.setdefault(os.path.realpath(port), source)  # /dev/serial/by-id has links
        if port and other is not source:
            yield (
                f"{other.text} and {source.text} are both at {port}; each has its own port, and a hub of two "
                "pads is named once"
            )


def _misfits_of_drive(bench: Bench, given: BenchSettings) -> Iterator[str]:
    """Yield what the drive cannot do for the fingers that it serves, or that there is none."""
    drives, drive, served = "`vegrip connect --list` has those with commands", bench.drive, bench.serves
    if drive is None:
        if given.serves or bench.wrist is not None:
            why = f"'serves' names {', '.join(given.serves)}" if given.serves else "[load] is of a gripper"
            yield f"{why}, and no 'drive' presses; add drive = 'PRODUCT@PORT', {drives}"
        return
    felt = [ours for source in bench.sensors for ours in source.names.values()]
    for finger in served if felt else ():
        if finger not in felt:
            hint = suggestion(finger, felt, "there are")
            yield f"'serves' has {finger!r}, which no sensor feels; {hint}"
    if len(set(served)) < len(served):
        yield f"'serves' names a finger twice: {', '.join(served)}"
    if not drive.commanded:
        yield f"{drive.text} maps no command, so it is no drive; {drives}"
    yield from _misfits_of_wrist(bench)
    if not felt and bench.wrist is None:
        yield "nothing feels: name 'sensors', or a sensor at the wrist by [load] from = 'wrist.toml'"
    if (least := drive.plan.hand.drive.minimum) >= given.largest:
        yield (
            f"limits.max_force is {given.largest:g} N, and the least that {drive.text} can is {least:g} N; "
            "state what fingers and object bear, or take another gripper"
        )
    for source in (one for one in bench.sensors if one.path != drive.path):
        for finger in (ours for name, ours in source.names.items() if name in source.commanded):
            if finger in served:
                yield (
                    f"{finger} is commanded by {source.text} and by {drive.text}; leave it out of 'serves', "
                    f"or take [fingers.{finger}.command] out of {source.text}"
                )


def _misfits_of_wrist(bench: Bench) -> Iterator[str]:
    """Yield what the sensor at the wrist does not feel of a load."""
    if bench.wrist is None or bench.load is None:
        return
    for finger in bench.wrist.plan.fingers:
        if lacking := sorted(bench.load.needs - finger.measured):
            remedy = (
                "write what is '?' in its map" if bench.wrist.plan.hand.open else "take a sensor that does"
            )
            yield (
                f"{bench.wrist.text} at the wrist feels no {' and no '.join(lacking)}, without which no load "
                f"is known; {remedy}"
            )


def read_source(text: str, where: str) -> Source:
    """Read ``[FINGER=]FILE[@PORT]`` or ``[FINGER=]PRODUCT@PORT``; with FINGER= only its first finger."""
    head, at, port = map_and_port(text)
    is_alone = "=" not in head or Path(head).is_file()  # a folder may have one, too
    finger, equals, product = ("", "", head) if is_alone else head.partition("=")
    path = map_of(product) if at and not product.endswith(".toml") else Path(product)
    if not port and (at or text in products.names()):
        raise ConfigError(f"{where}: {text!r} does not say at which port it is, as {head}@/dev/ttyUSB0")
    if not path.is_file():
        raise ConfigError(f"{where}: there is no map {product!r}; give a file, or PRODUCT@PORT")
    plan = open_plan(path)
    if equals:
        plan = open_plan(path, (plan.fingers[0].name,))
    transport = dict(plan.hand.transport)
    if not transport:
        raise ConfigError(f"{where}: {text} does not say where its device is; add [transport] to it")
    if at:
        transport["channel" if transport.get("kind", "can") == "can" else "address"] = port
    kind, address = transport.get("kind", "can"), transport.get("address")
    if kind in ("tcp", "udp") and isinstance(address, str) and address:
        host_and_port(kind, address, f"{where}: {text}")
    names = {one.name: finger or one.name for one in plan.fingers}
    return Source(text, path, plan, transport, names)


def open_bench(table: Mapping[str, Any], hand: Hand, where: str) -> Endpoint:
    """Open all parts of a hand."""
    given = build(BenchSettings, table, where)
    bench = read_bench(given, where)
    missing = [finger for finger in hand.fingers if finger not in bench.fingers]
    if missing:
        raise ConfigError(
            f"{where}: no part has the finger {missing[0]!r}; "
            f"{suggestion(missing[0], bench.fingers, 'there are')}"
        )
    parts = {}
    with ExitStack() as stack:
        for name, source in bench.parts.items():
            endpoint = stack.enter_context(source.open(f"{where} {source.text}", virtual=given.virtual))
            role = name if name in OTHER_PARTS else "sensor"
            parts[name] = Part(name, source.where, endpoint, source.names, role)
        stack.pop_all()
    return _joined(bench, parts, given)


def _joined(bench: Bench, parts: Mapping[str, Part], given: BenchSettings) -> Endpoint:
    if given.virtual:
        mass = bench.load.mass if bench.load is not None else 0.0
        return VirtualBench(list(parts.values()), bench.serves or bench.fingers, mass)
    drives = []
    if (driven := bench.drive) is not None:
        part = next(parts[name] for name, source in bench.parts.items() if source == driven)
        limits = driven.plan.hand.drive
        if limits.minimum < given.largest < limits.maximum:
            limits = replace(limits, maximum=given.largest)
        drives.append(Drive(part, driven.commanded, bench.serves, limits))
    wrist = WristLoad(bench.load) if bench.load is not None else None
    return BenchEndpoint(list(parts.values()), drives, wrist, bench.sentences)


def open_map(table: Mapping[str, Any], hand: Hand, where: str) -> Endpoint:
    """Open a hand of one map: the case of one part, which presses with its own fingers."""
    plan = open_plan(table["map"], hand.fingers)
    endpoint = open_alone(table, hand, where)
    part = Part("hand", str(table["map"]), endpoint, {one.name: one.name for one in plan.fingers})
    commanded = [name for name in part.names if plan.hand.fingers[name].command is not None]
    limits = plan.hand.drive
    drives = [Drive(part, (name,), (name,), limits) for name in commanded if limits != DriveLimits()]
    return BenchEndpoint([part], drives, sentences=lambda: endpoint.sentences)


def settings_of_bench(table: Mapping[str, Any], where: str) -> tuple[tuple[str, ...], dict[str, Any]]:
    """Return the fingers of a hand in parts, and the parameters of the grip controller that follow."""
    bench = read_bench(build(BenchSettings, table, where), where)
    return bench.fingers, bench.parameters()


def _largest(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Return both; of two numbers the larger: one noise and one patience serve all fingers."""
    both: dict[str, Any] = {**base, **over}
    for key in base.keys() & over.keys():
        one, other = base[key], over[key]
        if isinstance(one, Mapping) and isinstance(other, Mapping):
            both[key] = _largest(one, other)
        elif not isinstance(one, (str, bool)) and not isinstance(other, (str, bool)):
            both[key] = max(one, other)
    return both


def _of_steps(drive: DriveLimits) -> Sequence[str]:
    if drive == DriveLimits():
        return [
            "[drive] of the gripper's map says nothing of steps, pace and delay: it is asked for any force"
        ]
    pace = f", at most {drive.rate:g} a second" if drive.rate else ""
    return [
        f"the gripper makes forces from {range_of(drive)}{pace}, {1e3 * drive.delay:.0f} ms late: what is "
        "needed is rounded up"
    ]
