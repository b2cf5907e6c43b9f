"""The main job, end to end: virtual hand -> virtual CAN bus -> grasp force node, watched and recorded.

Three processes on one bus: the hand, the node, and this one, which listens as a monitor and recorder would.
It keeps the frames, decodes what is looked at (all of them when a page is open), and writes the recording in
the end: what it takes of the machine the loops of hand and node do not have.
Latency is measured in the node, from the arrival of a state to the departure of its command.
"""

import math
import os
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from vegrip.clock import NS
from vegrip.demo.bench import BenchProduct
from vegrip.demo.product import Product
from vegrip.demo.worker import DemoHand, HandNews, Job, RunStatistics, WorkerHandle
from vegrip.host.realtime import NODE_PRIORITY, choose_scheduling, is_switched_on, permission, processor_time
from vegrip.identification.recording.frame_log import FrameLog
from vegrip.identification.recording.writer import RecordingWriter
from vegrip.messages import ContactEstimate, ForceCommand, Message, Reason
from vegrip.runtime.monitor import Board
from vegrip.transport.can_endpoint import CanEndpoint
from vegrip.transport.canbus.virtual_can import hub_process
from vegrip.transport.codec import CanCodec, Frame
from vegrip.transport.open import Hand, open_endpoint
from vegrip.trials import candidates
from vegrip.trials.closed_loop import Course, Scenario

REFRESH_PERIOD_S = 0.1  # [s] of the screen
LOOK_PAUSE_S = 0.02  # [s] between two looks at the bus: a process that waits for each frame is woken by each
FLUSH_PERIOD_S = 1.0  # [s] between two flushes of what is recorded
TICK_PERIODS_S = {"hand": 0.002, "node": 0.005}  # [s]


FRAMES = "frames.log"
"""In the folder of the recording while the demonstration runs, and after one that was killed."""

HOLD_REASONS = (Reason.INPUT_HOLD, Reason.FAIL_SAFE)


class FrameRecorder:
    """Keeps the frames of one hand, and writes what they say when it is closed."""

    def __init__(self, writer: RecordingWriter, channel: str, fingers: Sequence[str]) -> None:
        self.commands = 0
        """Commands since the hand has reported; known when it is closed, as the next."""
        self.held = 0  # of them that only held, because states came too late or not at all
        self.since: int | None = None  # [ns] when the hand reported first
        self._writer, self._fingers = writer, fingers
        self.log = FrameLog(writer.folder / FRAMES, channel)

    def close(self) -> None:
        """Decode what was kept, write it to the recording, and close that."""
        self.log.flush()
        codec = CanCodec(self._fingers, fd=True, use_sender_time=True)
        for frame in self.log.frames():
            message = codec.decode(frame)
            if message is None:
                continue
            self._writer.write(message)
            if isinstance(message, ForceCommand) and self.since is not None and frame.stamp >= self.since:
                self.commands += 1
                self.held += message.reason in HOLD_REASONS
        self._writer.dropped = self.log.lost
        self._writer.close()
        if not self._writer.problem:
            self.log.path.unlink(missing_ok=True)


NODE = "/grasp_force"  # as a page calls it


class Page(Protocol):
    """A page that shows what is on the bus."""

    def receive(self, message: Message, now: int, node: str) -> None:
        """Receive a message that came at ``now`` [ns]."""

    def tick(self) -> None:
        """Show what is new, when that is due."""


@dataclass
class Outcome:
    """What a demonstration leaves behind."""

    folder: Path
    course: Course
    node: RunStatistics
    bus_load: float  # [-] mean over the run
    held: float  # [-] share of the commands that only held, because states came too late or not at all
    cores: dict[str, float]  # processor time over time while the hand held, by program; NaN = not known
    interrupted: bool = False
    problem: str = ""  # what is not in the recording, in a sentence


@dataclass
class Demo:
    """A demonstration under way."""

    scenario: Scenario
    folder: Path
    board: Board
    loads: list[float] = field(default_factory=list)
    acting: frozenset[str] = frozenset()
    news: HandNews | None = None
    page: Page | None = None
    codec: CanCodec | None = None  # of what is shown
    believed: Course = field(default_factory=lambda: Course(()))  # of friction, by the time of the hand
    _load_due: float = 0.0
    _flush_due: float = 0.0

    def watch(self, endpoint: CanEndpoint, recorder: FrameRecorder) -> None:
        """Take what is on the bus: the newest of every kind to show it, everything to record it."""
        time.sleep(LOOK_PAUSE_S)
        for frame in self.take(endpoint, recorder):
            self._show(frame)
        if self.page is not None:
            self.page.tick()
        now = time.monotonic()
        if now >= self._flush_due:
            self._flush_due = now + FLUSH_PERIOD_S
            recorder.log.flush()
        if now >= self._load_due:
            self._load_due = now + 1.0
            load = endpoint.bus_load()
            if not math.isnan(load):
                self.loads.append(load)

    def take(self, endpoint: CanEndpoint, recorder: FrameRecorder) -> Sequence[Frame]:
        """Record what has come; return what of it is to be shown."""
        if (block := endpoint.take_block()) is not None:
            recorder.log.offer_block(block)
            return block.newest() if self.page is None else block.frames()
        shown: dict[int, Frame] = {}
        while (frame := endpoint.next_frame(0.0)) is not None:
            recorder.log.offer(frame)
            shown[frame.arbitration_id if self.page is None else len(shown)] = frame
        return list(shown.values())

    def _show(self, frame: Frame) -> None:
        message = self.codec.decode(frame) if self.codec is not None else None
        if message is None:
            return
        now = time.monotonic_ns()
        self.board.receive(message, now)
        if isinstance(message, ContactEstimate) and self.news is not None:
            self.believed.believe(message, self.news.time)
        if self.page is not None:
            self.page.receive(message, now, NODE)

    def title(self) -> str:
        """Return the headline of the screen; the scenario's time is behind the clock on a slow machine."""
        load = f", bus load {100.0 * self.loads[-1]:.0f} %" if self.loads else ""
        fingers = f"vegrip demo: {len(self.board.fingers)} fingers"
        if self.news is None:
            return fingers + load
        return f"{fingers}, scenario {self.news.time:.0f} s, slips: {self.news.slips}{load}"

    def update(self, news: HandNews | None) -> None:
        """Put what happens to the object on the board's log."""
        if news is None:
            return
        if self.news is not None and news.slips > self.news.slips:
            self.board.say("the object slipped", time.monotonic_ns(), "bold red")
        self.news = news
        now = time.monotonic_ns()
        for name in sorted(set(news.acting) - self.acting):
            self.board.say(f"{news.time:.1f} s in the scenario: {DESCRIPTION.get(name, name)}", now, "yellow")
        self.acting = frozenset(news.acting)


DESCRIPTION = {
    "Push": "push",
    "Twist": "twist",
    "SlowLoad": "slowly growing load",
    "Shake": "shaking",
    "AddedMass": "mass added",
    "Turn": "hand turned against gravity",
    "Wetting": "faces get wet, friction falls",
}


def run(
    scenario: Scenario,
    folder: Path,
    refresh: Callable[[Demo], None],
    say: Callable[[str], None],
    page: Page | None = None,
    product: Product | BenchProduct | None = None,
) -> Outcome:
    """Run the demonstration; Ctrl-C ends it early and in order.

    Args:
        scenario: what the hand goes through.
        folder: where the recording goes; must not hold one.
        refresh: called some times a second to draw.
        say: called with a sentence while things get ready.
        page: shows it besides, where there is one.
        product: whose protocol hand and node speak; else ours.

    """
    if product is None:
        parameters = candidates.demonstrated_parameters(scenario.grasp)
        fingers = scenario.settings.fingers
    else:
        parameters, fingers = product.parameters(scenario), product.fingers
    transport: dict[str, Any] = {"kind": "can", "channel": f"demo-{os.getpid()}", "sender_time": True}
    demo = Demo(
        scenario,
        folder,
        Board(time.monotonic_ns(), fingers),
        page=page,
        codec=CanCodec(fingers, fd=True, use_sender_time=True),
        believed=Course(fingers),
    )
    noise = {name: getattr(parameters.noise, name) for name in ("normal_force", "displacement", "torque_z")}
    with ExitStack() as stack:
        writer = RecordingWriter(folder, radius=parameters.tip.radius, sensors=noise)
        recorder = stack.enter_context(closing(FrameRecorder(writer, transport["channel"], fingers)))
        listening = {**transport, "options": {"patience": LOOK_PAUSE_S}}
        endpoint = stack.enter_context(closing(open_endpoint(listening, Hand(fingers))))
        assert isinstance(endpoint, CanEndpoint)  # noqa: S101 (the transport of the table above)
        if sentence := choose_scheduling(NODE_PRIORITY, permission(), on=is_switched_on()).sentence:
            say(sentence)
        say("starting hand and node (the first run compiles, which takes a minute)")
        at_hand = at_node = transport
        if product is not None:
            at_hand, at_node = product.transports(folder)
        hand = WorkerHandle(
            "virtual_hand", Job(DemoHand, (scenario,), at_hand, fingers, TICK_PERIODS_S["hand"])
        )
        stack.callback(hand.stop)
        if product is not None:
            hand.wait("ready")  # its device is there
        copy_to = None if product is None else transport
        job = (candidates.make_node, (parameters, fingers), at_node, fingers, TICK_PERIODS_S["node"], copy_to)
        node = WorkerHandle("grasp_force", Job(*job))
        stack.callback(node.stop)
        demo.take(endpoint, recorder)  # nothing yet, but it compiles
        programs = {"hand": hand.process_id, "node": node.process_id, "watch": os.getpid()}
        if (hub := hub_process(transport["channel"])) is not None:
            programs["bus"] = hub
        cores = CoreCount(programs)
        interrupted = _play(demo, hand, node, endpoint, recorder, refresh, cores)
        hand.stop()
        node.stop()
        say("writing the recording ...")
    if hand.statistics_at_end is None or node.statistics_at_end is None:
        raise KeyboardInterrupt  # interrupted before there was anything to sum up
    load = sum(demo.loads) / len(demo.loads) if demo.loads else math.nan
    held = recorder.held / max(recorder.commands, 1)
    course: Course = hand.statistics_at_end.rest
    course.friction = demo.believed.friction
    return Outcome(
        folder,
        course,
        node.statistics_at_end,
        load,
        held,
        cores.shares(),
        interrupted,
        writer.problem,
    )


def _play(
    demo: Demo,
    hand: WorkerHandle,
    node: WorkerHandle,
    endpoint: CanEndpoint,
    recorder: FrameRecorder,
    refresh: Callable[[Demo], None],
    cores: "CoreCount",
) -> bool:
    """Start both nodes and watch until the hand is done; return whether it was interrupted."""
    for child in (node, hand):  # both compile at the same time; the node is active before the hand speaks
        child.wait("ready")
    for child in (node, hand):
        child.say("start")
        child.wait("active")
    demo.board.start = time.monotonic_ns()
    cores.begin()
    due = 0.0
    with suppress(KeyboardInterrupt):
        while hand.listen() and node.listen():
            cores.look()
            demo.watch(endpoint, recorder)
            demo.update(hand.news)
            if recorder.since is None and demo.news is not None:
                recorder.since = time.monotonic_ns()
            if time.monotonic() >= due:
                due = time.monotonic() + REFRESH_PERIOD_S
                demo.board.refresh(time.monotonic_ns())
                refresh(demo)
        demo.board.refresh(time.monotonic_ns())
        refresh(demo)
        return False
    return True


@dataclass
class CoreCount:
    """What programs take of the processor."""

    programs: dict[str, int]
    _looks: list[tuple[float, dict[str, float]]] = field(default_factory=list)  # the first and the last

    def begin(self) -> None:
        self._looks = [self._now()] * 2

    def look(self) -> None:
        """Count up to now; a process that has ended by the next time was there until now."""
        if time.monotonic() - self._looks[1][0] > REFRESH_PERIOD_S:
            now = self._now()
            if not any(math.isnan(taken) for taken in now[1].values()):
                self._looks[1] = now

    def shares(self) -> dict[str, float]:
        """Return processor time over time, by name."""
        (first, before), (last, after) = self._looks
        time_taken = last - first
        return {
            name: (after[name] - before[name]) / time_taken if time_taken > 0.0 else math.nan
            for name in self.programs
        }

    def _now(self) -> tuple[float, dict[str, float]]:
        return time.monotonic(), {name: processor_time(number) for name, number in self.programs.items()}


def elapsed(demo: Demo) -> float:
    return (time.monotonic_ns() - demo.board.start) / NS
