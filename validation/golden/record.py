"""Record anew what the cases share: a hand with disturbances, one that learns, a pinch under every fault.

``python -m validation.golden.record`` writes ``inputs.npz``. All golden answers change with it: it is run
only when what is recorded is to be other (a fault more), never to follow the virtual hand or bus.
"""

import struct
import sys
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

from vegrip.nodes.virtual_hand import Parameters

from validation.faults.system_faults import Killed, Starved
from validation.faults.table import CASES, FAULT_BEGIN_S, Case
from validation.faults.testbed import Hand, Scene
from validation.golden.events import FOREIGN, STALL, STATE, STOP, Event, Tape, save
from vegrip.messages import Message
from vegrip.transport.codec import Frame
from vegrip.trials.candidates import KNOBS, parameters

STATE_IDS = range(0x200, 0x240)
COUNTER, TIME, VALUES = struct.Struct("<I"), struct.Struct("<I"), struct.Struct("<9f")
COUNTER_AT, TIME_AT, VALUES_AT, LENGTH = 2, 8, 12, 48
"""Where these stand in the frame of a state, and its length: known here by itself, not from the DBC."""
AFTER_S = 0.7  # [s] that a fault is watched after its end
MOST_FOREIGN = 40  # of a babbling node, so many are kept


class Recorder:
    """Keeps what arrives at the node that grips in ``scene``."""

    def __init__(self, scene: Scene) -> None:
        self.scene, self.events = scene, list[Event]()
        self._whole: dict[bytes, tuple[bytes, int]] = {}  # frame as harmed: as sent, and the harm
        self._foreign = 0
        self._listen()

    def follow(self) -> None:
        """Listen to a node that has been started in the place of the former."""
        self._listen()

    def tamper(self) -> None:
        """Remember what every harmed frame was, from now on."""
        inner: Any = self.scene.hand.endpoint.tamper

        def noted(frame: Frame, now: int) -> Iterable[tuple[int, Frame]]:
            for time, sent in inner(frame, now):
                if len(sent.data) < len(frame.data):
                    self._whole[sent.data] = frame.data, -len(sent.data)
                elif (bit := _flipped(frame.data, sent.data)) is not None:
                    self._whole[sent.data] = frame.data, 1 + bit
                yield time, sent

        if inner is not None:
            self.scene.hand.endpoint.tamper = noted

    def _listen(self) -> None:
        endpoint: Any = self.scene.grip.endpoint
        endpoint.intercept = None  # everything goes by messages, to be seen here
        endpoint.line = lambda _: None
        codec: Any = endpoint._codec
        decode = codec.decode

        def kept(frame: Frame) -> Message | None:
            self._keep(frame)
            found: Message | None = decode(frame)
            return found

        codec.decode = kept

    def _keep(self, frame: Frame) -> None:
        now = self.scene.clock.now()
        if frame.arbitration_id not in STATE_IDS:
            if frame.arbitration_id >= 0x7F0 and self._foreign < MOST_FOREIGN:
                self._foreign += 1
                self.events.append(Event(FOREIGN, now, frame.stamp))
            return
        data, harm = self._whole.get(frame.data, (frame.data, 0))
        if len(data) != LENGTH:
            raise ValueError(f"a state of {len(data)} bytes")
        finger = frame.arbitration_id & 0x7
        (seq,), (sent,) = COUNTER.unpack_from(data, COUNTER_AT), TIME.unpack_from(data, TIME_AT)
        values = VALUES.unpack_from(data, VALUES_AT)
        self.events.append(Event(STATE, now, frame.stamp, finger, seq, sent * 1000, values, harm))


def _flipped(whole: bytes, harmed: bytes) -> int | None:
    """Return the number of the one bit that differs, None where none does, or more."""
    bits = [
        8 * at + bit
        for at, (a, b) in enumerate(zip(whole, harmed, strict=True))
        for bit in range(8)
        if (a ^ b) >> bit & 1
    ]
    return bits[0] if len(bits) == 1 else None


def hand(controller: str, seconds: float, seed: int, grasp: str = "hand") -> Tape:
    """Return what a hand whose object is disturbed sends to a ``controller``."""
    scene = Scene(grasp, sender_time=True, parameters=parameters(controller, KNOBS[grasp][controller]))
    disturbed = replace(Parameters(), hand=scene.settings, seed=seed, disturbance_seed=seed)
    scene.simulation.kill(scene.hand)
    scene.hand_node = Hand("virtual_hand", disturbed)
    scene.hand = scene.simulation.add(scene.hand_node, scene.endpoint(), scene.loop)
    recorder = Recorder(scene)
    scene.run_until(seconds)
    return Tape(tuple(scene.fingers), tuple(recorder.events))


def pinch() -> Tape:
    """Return what comes before every fault."""
    scene = Scene(sender_time=True)
    recorder = Recorder(scene)
    scene.run_until(FAULT_BEGIN_S)
    return Tape(tuple(scene.fingers), tuple(recorder.events))


def faulty(case: Case) -> Tape:
    """Return what comes from the beginning of a fault on."""
    scene = Scene(sender_time=case.sender_time)
    scene.run_until(FAULT_BEGIN_S)
    fault, begin = case.make(), scene.clock.now()
    recorder = Recorder(scene)
    fault.begin(scene)
    recorder.tamper()
    scene.run_until(FAULT_BEGIN_S + case.duration)
    fault.end(scene)
    if isinstance(fault, Killed):
        recorder.follow()
        recorder.events.append(Event(STOP, begin, until=scene.clock.now()))
    if isinstance(fault, Starved):
        recorder.events.append(Event(STALL, begin, until=begin + round(fault.duration * 1e9)))
    scene.run_until(FAULT_BEGIN_S + case.duration + AFTER_S)
    return Tape(tuple(scene.fingers), ()).with_events(recorder.events)


def tapes() -> Iterator[tuple[str, Tape]]:
    """Yield the recordings and their names."""
    yield "hand", hand("vegrip", 4.0, 3)
    yield "learning", hand("learning", 6.0, 5)
    yield "pinch", pinch()
    for case in CASES:
        if case.duration <= 3.0:
            yield f"fault: {case.name}", faulty(case)


def main() -> None:
    """Write the recordings."""
    found = {}
    for name, tape in tapes():
        sys.stdout.write(f"{name}: {len(tape.events)} events\n")
        sys.stdout.flush()
        found[name] = tape
    save(found)


if __name__ == "__main__":
    main()
