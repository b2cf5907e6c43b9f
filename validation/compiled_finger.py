"""States answered as CAN FD frames and as messages: the same into both, and every byte that comes out.

``python -m validation.compiled_finger`` records a hand in a closed loop, makes its states hostile, and
records a pinch under the faults of :mod:`validation.faults`; ``--quick`` records less. ``--bits``
compares C, numba and plain Python instead: every command and every number of all memories after 35 s of the
hand, as recorded and with hostile states. ``--learning`` does so with friction that is shared and probed.
"""

import argparse
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from validation.faults.table import CASES, FAULT_BEGIN_S, Case
from validation.faults.testbed import Scene
from validation.liars import Liar
from vegrip.grip.node import GraspForce
from vegrip.grip.parameters import GraspParameters
from vegrip.grip.wires import COMMANDED, LEFT_ALONE, REPORT
from vegrip.messages import Condition, ContactEstimate, ForceCommand, Message, SlipMargin
from vegrip.transport.codec import CanCodec, Frame
from vegrip.transport.codec.frame_codec import Line
from vegrip.trials.candidates import KNOBS, demo_parameters, make_node, parameters

QUICK_CASES = 4
HOSTILE_SEEDS = 20
SILENCES = 0.003  # share of frames after which nothing comes for a while
WATCHED_AFTER_S = 0.7
BITS_DURATION_S = 35.0  # [s] 35 000 frames
MODES = ("c", "numba", "python")
COUNTS = ("faults", "lost", "rejected", "clipped")
CLIPPED = ("normal_force", "adjustment", "reason", "expires")  # of commands; reports are not encoded here


@dataclass
class Event:
    """A frame that arrived, or a tick, or news of broken frames of ``finger``; answered at ``now`` [ns]."""

    now: int = 0
    frame: Frame | None = None
    finger: str = ""


@dataclass
class Log:
    """What a node met, in order."""

    fingers: tuple[str, ...]
    sender_time: bool = False
    events: list[Event] = field(default_factory=list)
    parameters: GraspParameters | None = None  # of the node; None: those of the demonstration

    @property
    def frames(self) -> int:
        """How many frames there are."""
        return sum(event.frame is not None for event in self.events)

    def codec(self) -> CanCodec:
        """Return a codec for the frames."""
        return CanCodec(self.fingers, fd=True, use_sender_time=self.sender_time)


@dataclass
class Answers:
    """What a node answered: the commands as bytes, and what it thought of its input after each event."""

    commands: list[tuple[int, bytes]] = field(default_factory=list)
    reports: list[tuple[int, bytes]] = field(default_factory=list)  # contacts and slip margins
    packed_reports: int = 0  # frames of them that the compiled step packed
    conditions: list[tuple[Condition, ...]] = field(default_factory=list)
    faults: dict[str, dict[Condition, int]] = field(default_factory=dict)
    lost: int = 0
    rejected: dict[str, int] = field(default_factory=dict)
    clipped: dict[str, int] = field(default_factory=dict)
    compiled_frames: int = 0


def listen(scene: Scene) -> Log:
    """Return a log that fills while ``scene`` runs, with what its present node meets."""
    log = Log(tuple(scene.fingers), scene.sender_time)
    codec, node = scene.grip.endpoint._codec, scene.grip.node
    assert isinstance(node, GraspForce)  # noqa: S101 (the scene made it)
    pending: dict[int, Event] = {}
    decode, on_message, on_tick, on_broken = codec.decode, node.on_message, node.on_tick, node.on_broken

    def logged_decode(frame: Frame) -> Message | None:
        message = decode(frame)
        event = Event(frame.stamp, frame)
        log.events.append(event)
        if message is not None:
            pending[id(message)] = event
        return message

    def logged_message(message: Message, now: int) -> Iterable[Message]:
        if event := pending.pop(id(message), None):
            event.now = now
        return on_message(message, now)

    def logged_tick(now: int) -> Iterable[Message]:
        log.events.append(Event(now))
        return on_tick(now)

    def logged_broken(finger: str, now: int) -> None:
        log.events.append(Event(now, finger=finger))
        on_broken(finger, now)

    scene.grip.endpoint.intercept = None  # everything goes by messages, to be seen here
    parts: Any = codec, node  # methods of two instances are replaced
    parts[0].decode, parts[1].on_message = logged_decode, logged_message
    parts[1].on_tick, parts[1].on_broken = logged_tick, logged_broken
    return log


def record(case: Case | None, duration: float, grasp: str = "pinch", controller: str = "vegrip") -> Log:
    """Return what the node of a scene meets under a fault, or for ``duration`` [s] without one."""
    settings = parameters(controller, KNOBS[grasp][controller])
    sender_time = case.sender_time if case is not None else True
    scene = Scene(grasp, sender_time=sender_time, parameters=settings)
    log = listen(scene)
    log.parameters = settings
    if case is None:
        scene.run_until(duration)
        return log
    fault = case.make()
    scene.run_until(FAULT_BEGIN_S)
    fault.begin(scene)
    scene.run_until(FAULT_BEGIN_S + case.duration)
    fault.end(scene)
    scene.run_until(FAULT_BEGIN_S + case.duration + WATCHED_AFTER_S)
    return log


def hostile(log: Log, seed: int) -> Log:
    """Return ``log`` with false states, and silences now and then."""
    lines = [line for finger in log.fingers if (line := log.codec().line(finger)) is not None]
    liars = {line.state_id: Liar((seed, line.state_id)) for line in lines}
    rng, later = np.random.default_rng(seed), 0  # [ns]
    found = replace(log, events=[])
    for event in log.events:
        frame = event.frame
        if frame is not None and frame.arbitration_id in liars:
            data = liars[frame.arbitration_id].falsified(frame, later)
            frame = frame._replace(data=data)
        if rng.random() < SILENCES:
            later += int(10 ** rng.uniform(6.0, 9.5))
        frame = frame._replace(stamp=frame.stamp + later) if frame is not None else None
        found.events.append(Event(event.now + later, frame, event.finger))
    return found


class Replay:
    """A node that meets a log, by its objects or compiled.

    Args:
        log: what it meets.
        mode: what runs the compiled step: ``c``, ``numba``, ``python``; empty: the objects do everything.
        parameters: of the node.

    """

    def __init__(self, log: Log, mode: str = "", parameters: GraspParameters | None = None) -> None:
        self.log, self.codec = log, log.codec()
        self.node = make_node(parameters or log.parameters or demo_parameters(), log.fingers)
        self.node.configure()
        self.node.activate()
        self.answers = Answers()
        self.lines: dict[int, tuple[str, Line]] = {}  # by identifier of a state: finger, line
        if mode:
            lines = {finger: line for finger in log.fingers if (line := self.codec.line(finger))}
            self.node.run_compiled(lines, mode)
            self.lines = {line.state_id: (finger, line) for finger, line in lines.items()}

    def run(self) -> Answers:
        """Meet all of the log."""
        for event in self.log.events:
            self.meet(event)
        return self.finish()

    def meet(self, event: Event) -> None:
        """Meet one event."""
        if event.frame is not None:
            self._frame(event.frame, event.now)
        elif event.finger:
            self.node.on_broken(event.finger, event.now)
        else:
            self._answered(self.node.on_tick(event.now))
        self.answers.conditions.append(tuple(self._condition(finger) for finger in self.log.fingers))

    def finish(self) -> Answers:
        """Return the answers."""
        self.node.leave_lines()
        answers, codec = self.answers, self.codec
        answers.faults = {name: f.faults for name, f in self.node.fingers.items()}
        answers.lost, answers.rejected = codec.lost, dict(codec.rejected)
        answers.clipped = {name: count for name, count in codec.clipped.items() if name in CLIPPED}
        return answers

    def _frame(self, frame: Frame, now: int) -> None:
        known = self.lines.get(frame.arbitration_id)
        if known is not None and frame.fd:
            finger, line = known
            data = np.zeros(64, dtype=np.uint8)
            data[: len(frame.data)] = np.frombuffer(frame.data, dtype=np.uint8)
            done = self.node.on_frame(finger, data, len(frame.data), frame.stamp, now)
            told = self.node.fingers[finger]
            if done & COMMANDED:
                self.answers.commands.append((line.command_id, told.numbers.answer_frame.tobytes()))
            if done & REPORT:
                pairs = (
                    zip(told.numbers.on_wire.report_ids, told.numbers.report_frames, strict=True)
                    if told.numbers.report_as_frames(now)
                    else ()
                )
                packed = [(name, data.tobytes()) for name, data in pairs]
                self.answers.reports += packed
                self.answers.packed_reports += len(packed)
                if told.reports.are_due(now):
                    self._answered(self.node.reports(finger, now))
            if done != LEFT_ALONE:
                self.answers.compiled_frames += 1
                return
        message = self.codec.decode(frame)
        if message is not None:
            self._answered(self.node.on_message(message, now))

    def _answered(self, messages: Iterable[Message]) -> None:
        for message in messages:
            if isinstance(message, ForceCommand | ContactEstimate | SlipMargin):
                sent = [(frame.arbitration_id, frame.data) for frame in self.codec.encode(message)]
                kept = self.answers.commands if isinstance(message, ForceCommand) else self.answers.reports
                kept += sent

    def _condition(self, finger: str) -> Condition:
        return self.node.fingers[finger].condition


def differences(left: Answers, right: Answers) -> list[str]:
    """Return in sentences what two nodes answered differently; empty: nothing."""
    found = _unequal("commands", left.commands, right.commands)
    found += _unequal("reports", left.reports, right.reports)
    states = [i for i, (a, b) in enumerate(zip(left.conditions, right.conditions, strict=True)) if a != b]
    if states:
        i = states[0]
        both = f"{left.conditions[i]}, {right.conditions[i]}"
        found.append(f"conditions differ after {len(states)} events, first after {i}: {both}")
    counts = {name: (getattr(left, name), getattr(right, name)) for name in COUNTS}
    return found + [f"{name}: {a}, {b}" for name, (a, b) in counts.items() if a != b]


def _unequal(what: str, left: list[tuple[int, bytes]], right: list[tuple[int, bytes]]) -> list[str]:
    found = []
    pairs = list(zip(left, right, strict=False))
    unequal = [i for i, (a, b) in enumerate(pairs) if a != b]
    if unequal:
        i = unequal[0]
        a, b = (f"{identifier:#x} {data.hex()}" for identifier, data in pairs[i])
        found.append(f"{len(unequal)} of {len(pairs)} {what} differ, first number {i}: {a}, {b}")
    if len(left) != len(right):
        found.append(f"{len(left)} {what} and {len(right)}")
    return found


def bits_left(replay: Replay) -> tuple[int, dict[str, bytes]]:
    """Return how many frames ran compiled, and the bits of all commands and memories after a log."""
    answers = replay.run()
    sent = [*answers.commands, *answers.reports]
    left = {"commands and reports": b"".join(data for _, data in sent)}
    for name, finger in replay.node.compiled_fingers.items():
        f = np.where(np.isnan(finger.memory.f), np.nan, finger.memory.f)  # NaN has many bits, and one meaning
        left[f"{name}, real numbers"], left[f"{name}, whole numbers"] = f.tobytes(), finger.memory.t.tobytes()
    return answers.compiled_frames, left


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare on the table of faults and print a line for each case; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="few and short recordings")
    parser.add_argument("--mode", default="c", choices=MODES, help="what runs the step")
    parser.add_argument("--bits", action="store_true", help="compare C, numba and Python instead")
    parser.add_argument("--learning", action="store_true", help="with friction shared and probed, loads led")
    chosen = parser.parse_args(arguments)
    controller = "learning" if chosen.learning else "vegrip"
    seconds = 2.0 if chosen.quick else BITS_DURATION_S if chosen.bits else 10.0
    hand = record(None, seconds, "hand", controller)
    if chosen.bits:
        return 4 if _compare_bits(hand) else 0
    cases = [case for case in CASES if not case.slow]
    cases = cases[:: max(1, len(cases) // QUICK_CASES)] if chosen.quick else cases
    failed = _compare("a hand, undisturbed", hand, chosen.mode)
    for seed in range(2 if chosen.quick else HOSTILE_SEEDS):
        name = f"a hand, hostile states, seed {seed}"
        failed += _compare(name, hostile(hand, seed), chosen.mode)
    for case in cases:
        failed += _compare(case.name, record(case, 0.0, controller=controller), chosen.mode)
    sys.stdout.write(f"{failed} differ\n")
    return 4 if failed else 0


def _compare_bits(hand: Log) -> int:
    """Print for a log and its hostile form what C, numba and Python left differently; return how much."""
    failed = 0
    for name, log in {"a hand, undisturbed": hand, "a hand, hostile states": hostile(hand, 0)}.items():
        left = {mode: bits_left(Replay(log, mode)) for mode in MODES}
        frames, expected = left["c"]
        unequal = [
            f"{mode}: {key}" for mode in MODES for key in expected if left[mode][1][key] != expected[key]
        ]
        sys.stdout.write(f"{name}: {', '.join(unequal) or 'equal to the bit'} ({frames} frames compiled)\n")
        sys.stdout.flush()
        failed += len(unequal)
    return failed


def _compare(name: str, log: Log, mode: str) -> int:
    objects, compiled = Replay(log).run(), Replay(log, mode).run()
    found = differences(objects, compiled)
    share = f"{compiled.compiled_frames} of {log.frames} frames compiled"
    told = f"{compiled.packed_reports} of {len(objects.reports)} frames of reports packed by it"
    verdict = "; ".join(found) or "equal"
    sys.stdout.write(f"{name}: {verdict} ({len(objects.commands)} commands, {share}, {told})\n")
    sys.stdout.flush()
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main())
