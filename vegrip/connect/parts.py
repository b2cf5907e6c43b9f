"""The parts of a hand one by one: which answers, which pad is which, and the launch file that joins them."""

import math
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np

from vegrip.config import build
from vegrip.errors import VegripError
from vegrip.messages import FingertipState
from vegrip.runtime.doctor import Finding, fail, ok, warn
from vegrip.runtime.launch_file import NodeConfig, read_launch_file
from vegrip.transport.endpoint import Endpoint
from vegrip.transport.hands.bench import Bench, BenchSettings, Source, read_bench
from vegrip.transport.hands.drive_steps import range_of
from vegrip.transport.mapped.largest_force import BELIEVED_N
from vegrip.transport.open import map_and_port
from vegrip.types import Floats

LISTEN_S: Final = 3.0  # [s] for a device to answer; a Bota takes two to begin
LOOK_S: Final = 0.02  # [s] of one look at all parts
ENOUGH: Final = 50  # states of each finger
AT_REST_N: Final = 2.0  # [N] more than a zero that has drifted
OTHER_DEVICE: Final = ("unknown_packet", "bad_checksum", "bad_length", "bad_end", "bad_record", "foreign")
FORCES: Final = ("tangential_force_x", "tangential_force_y", "normal_force")


@dataclass
class Received:
    """What came of one part."""

    states: dict[str, list[FingertipState]] = field(default_factory=dict)
    seconds: float = 0.0
    rejected: Mapping[str, int] = field(default_factory=Counter)
    skipped: int = 0  # bytes that belong to no packet
    heard: bool = False  # an answer that is one of this map
    faults: Sequence[str] = ()  # that it says of itself

    def mean(self, finger: str) -> Floats:
        """Return the mean force (x, y, normal) [N], NaN where it is not felt."""
        rows = [[getattr(state, name) for name in FORCES] for state in self.states.get(finger, ())]
        return np.mean(rows, axis=0) if rows else np.full(3, np.nan)


def listen(endpoints: Mapping[str, Endpoint], seconds: float, enough: int = 0) -> dict[str, Received]:
    """Return what comes of each within ``seconds``; at once when ``enough`` states of a finger have come."""
    found, begin = {name: Received() for name in endpoints}, time.monotonic()
    while (now := time.monotonic()) < begin + seconds:
        for name, endpoint in endpoints.items():
            for message in endpoint.receive(min(LOOK_S / len(endpoints), begin + seconds - now)):
                if isinstance(message, FingertipState):
                    found[name].states.setdefault(message.finger, []).append(message)
        counts = [len(states) for one in found.values() for states in one.states.values()]
        if enough and counts and min(counts) >= enough:
            break
    for name, endpoint in endpoints.items():
        found[name].seconds, found[name].rejected = time.monotonic() - begin, endpoint.rejected
        found[name].skipped, found[name].heard = getattr(endpoint, "skipped", 0), endpoint.heard > 0
        found[name].faults = sorted(fault for _, fault in endpoint.device_faults)
    return found


def benches(path: Path) -> Iterator[tuple[NodeConfig, Bench]]:
    """Yield each hand in parts of a launch file, with its node."""
    for node in read_launch_file(path):
        if node.transport.get("kind") == "bench" and node.program == "grasp_force":
            yield node, read_bench(build(BenchSettings, node.transport, str(path)), str(path))


def try_parts(path: Path, seconds: float = LISTEN_S) -> list[Finding]:
    """Open each part of the hands in a launch file alone, and say what answers; of one map, none."""
    found = []
    for _, bench in benches(path):
        for name, source in bench.parts.items():
            key = {"drive": "'drive'", "wrist": "'from' of [load]"}.get(name, "'sensors'")
            place = f"{key} in {path}" if map_and_port(source.text)[1] else f"[transport] in {source.path}"
            found.append(_tried(name, source, place, seconds, is_drive=source == bench.drive))
    return found


def _tried(name: str, source: Source, place: str, seconds: float, *, is_drive: bool) -> Finding:
    """Return what comes of one part, whose port stands at ``place``."""
    try:
        with closing(source.open(source.text)) as endpoint:
            received = listen({name: endpoint}, seconds, 0 if is_drive else ENOUGH)[name]
    except VegripError as error:
        return fail(name, str(error), f"its port stands at {place}")
    return _of_drive(name, source, received) if is_drive else _of_sensor(name, source, received)


def _of_drive(name: str, source: Source, received: Received) -> Finding:
    missed = received.rejected.get("unanswered", 0)
    is_lost = any(map(received.rejected.get, ("silent", "link_lost", "no_traffic")))
    if is_lost or (missed and not received.heard):
        return _mute(name, source, received)
    text = f"{source.where} answers; it makes {range_of(source.plan.hand.drive)}"
    if received.faults:
        return warn(name, f"{text}; it says of itself: {', '.join(received.faults)}", "see its manual")
    if missed:
        return warn(name, f"{text}; {missed} requests had no answer", "look at its cable and its supply")
    return ok(name, text)


def _of_sensor(name: str, source: Source, received: Received) -> Finding:
    mute = [ours for theirs, ours in source.names.items() if theirs not in received.states]
    if len(mute) == len(source.names):
        return _mute(name, source, received)
    if mute:
        text = f"{source.where}: nothing comes of {', '.join(mute)}"
        return fail(name, text, "look at its plug, and at `trigger` in the map")
    forces = {ours: received.mean(theirs)[2] for theirs, ours in source.names.items()}
    rate = min(map(len, received.states.values())) / received.seconds
    felt = ", ".join(f"{ours} {force:.2f} N" for ours, force in forces.items())
    text = f"{source.where}: {rate:.0f} states/s, {felt}"
    largest = max((abs(force) for force in forces.values() if not math.isnan(force)), default=0.0)
    if largest > BELIEVED_N:
        return fail(
            name, f"{text}: no fingertip feels that at rest", "its 'unit' or 'scale' in the map is wrong"
        )
    if largest > AT_REST_N:
        return warn(name, text, "take its zero (`vegrip zero`), if nothing touches it")
    return ok(name, text)


def _mute(name: str, source: Source, received: Received) -> Finding:
    if received.skipped or any(received.rejected.get(each) for each in OTHER_DEVICE):
        text = f"{source.where}: bytes come, but nothing of this map: another device, or another baud rate"
        return fail(name, text, "swap the ports in the launch file, or see baud in the map")
    text = f"{source.where}: it opens, and nothing comes within {received.seconds:.0f} s"
    return fail(name, text, "switch it on; is it this port? another device there does not answer either")
