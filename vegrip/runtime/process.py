"""Run one node in this process: bus, loop, telemetry, control, signals, and an orderly end."""

import logging
import math
import os
import queue
import signal
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from logging.handlers import QueueHandler, QueueListener

from vegrip.clock import WallClock
from vegrip.errors import DeviceError, VegripError
from vegrip.host import realtime
from vegrip.host.descriptors import NODE_NEEDS, require_descriptors
from vegrip.messages import Lifecycle, NodeStatus
from vegrip.runtime.channel_watch import ChannelWatch
from vegrip.runtime.control_socket import ControlServer, NodeCalls
from vegrip.runtime.handle import NodeHandle, Supervised
from vegrip.runtime.launch_file import NodeConfig
from vegrip.runtime.node import NodeContext, find_program
from vegrip.runtime.registry import Entry, ExitReport, registered, write_report
from vegrip.runtime.runner import Runner
from vegrip.runtime.telemetry import Direction, Telemetry
from vegrip.runtime.telemetry_socket import TelemetrySocket
from vegrip.transport.can_endpoint import CanEndpoint
from vegrip.transport.codec.msgpack_codec import MsgpackCodec
from vegrip.transport.endpoint import Endpoint
from vegrip.transport.open import Hand, open_endpoint

REPEAT_PERIOD_S = 0.9  # [s] less than between two reports, whose sentences are news each
MOST_LINES = 1024  # source lines remembered


class OncePerSecond(logging.Filter):
    """Lets a record of a source line and level through per ``REPEAT_PERIOD_S``, with the number held back."""

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        super().__init__()
        self._now = now
        self._lines: dict[tuple[str, int, int], tuple[float, int]] = {}  # (when let through, how many not)

    def filter(self, record: logging.LogRecord) -> bool:
        """Return whether ``record`` is to be written."""
        line, now = (record.pathname, record.lineno, record.levelno), self._now()
        last, suppressed = self._lines.get(line, (-REPEAT_PERIOD_S, 0))
        if now - last < REPEAT_PERIOD_S:
            self._lines[line] = (last, suppressed + 1)
            return False
        if line in self._lines or len(self._lines) < MOST_LINES:
            self._lines[line] = (now, 0)
        if suppressed:
            record.msg = f"{record.msg} ({suppressed} more like this in the last second)"
        return True


@contextmanager
def node_logs(name: str, level: int = logging.INFO) -> Iterator[None]:
    """Write the logs of this process to standard error under ``name``, without making the loop wait."""
    records: queue.SimpleQueue[logging.LogRecord] = queue.SimpleQueue()
    writer = logging.StreamHandler()
    writer.setFormatter(logging.Formatter(f"%(levelname)s {name}: %(message)s"))
    listener = QueueListener(records, writer)
    handler = QueueHandler(records)
    handler.addFilter(OncePerSecond())
    root = logging.getLogger()
    before = root.level
    root.addHandler(handler)
    root.setLevel(logging.WARNING)
    logging.getLogger("vegrip").setLevel(level)
    listener.start()
    try:
        yield
    finally:
        root.removeHandler(handler)
        root.setLevel(before)
        listener.stop()


LAST_STATUS_DELAY_S = (
    0.25  # [s] in which those who follow a node that came back have connected to its telemetry
)
REPEAT_SIGNAL_S = (
    1.0  # [s] until a signal interrupts again, should the first interruption have been swallowed
)
SWITCH_INTERVAL = 0.0005
"""[s] after which a side thread must yield to the loop; the 5 ms of Python are more than two ticks."""


def run_node(config: NodeConfig, autostart: bool = True) -> None:
    """Run the node of ``config`` until it has finished or the process is asked to end (SIGINT, SIGTERM)."""
    require_descriptors(NODE_NEEDS)
    name = config.full_name
    context = NodeContext(name.rpartition("/")[2], config.namespace, config.fingers, config.loop.tick_period)
    node = find_program(config.program)(config.parameters, context)
    hand = Hand(config.fingers, config.hand, config.namespace, config.remap)
    fingers, status_period = list(config.fingers), config.loop.status_period
    entry = Entry(
        name, config.program, config.namespace, dict(config.remap), os.getpid(), fingers, status_period
    )
    with ExitStack() as stack:
        stack.enter_context(realtime.switched(on=config.realtime))
        ending = stack.enter_context(_ended_by_signals())
        stack.enter_context(node_logs(name))
        stack.enter_context(registered(entry))
        stack.enter_context(_last_words(entry))
        codec = MsgpackCodec(config.namespace, remap=config.remap)
        beside: Counter[str] = Counter()
        sink = TelemetrySocket(entry.telemetry, codec, config.fingers, beside)
        telemetry = stack.enter_context(closing(Telemetry(sink)))
        with _connected(telemetry, sink, name):
            endpoint = open_endpoint(config.transport, hand, f"{name} [transport]")
        stack.enter_context(closing(endpoint))
        if isinstance(endpoint, CanEndpoint):
            endpoint.patience_s = getattr(node, "patience_s", 0.0)
        priority = realtime.priority_of(
            getattr(node, "realtime_priority", 0)
        )  # nodes of others may have none
        stack.callback(priority.give_back)
        runner = Runner(node, endpoint, WallClock(), config.loop, telemetry, name, beside, priority)
        control = NodeCalls(runner, sink.topics)
        stack.enter_context(closing(ControlServer(entry.control, control, beside)))
        stack.enter_context(_brisk_switching())
        telemetry.start()
        ending.runner = runner
        stack.callback(ending.begin)
        _run(runner, endpoint, autostart)


@contextmanager
def _last_words(entry: Entry) -> Iterator[None]:
    try:
        yield
    except Exception as error:
        reason, code = f"{type(error).__name__}: {error}", 1
        if isinstance(error, VegripError):
            reason, code = str(error), error.exit_code
        write_report(ExitReport(entry.name, entry.program, reason, code))
        raise


@contextmanager
def _connected(telemetry: Telemetry, sink: TelemetrySocket, name: str) -> Iterator[None]:
    try:
        yield
    except VegripError:
        time.sleep(LAST_STATUS_DELAY_S)
        sink.listen()
        status = NodeStatus(time.monotonic_ns(), name, 0, Lifecycle.FINALIZED, rejected={"bus_not_opened": 1})
        telemetry.offer(status, Direction.OUT)
        raise


def _run(runner: Runner, endpoint: Endpoint, autostart: bool) -> None:
    logger = logging.getLogger(f"vegrip.{runner.full_name}")
    if runner.channels is not None and endpoint.sentences:
        runner.channels = ChannelWatch(runner.channels.lacking, endpoint.sentences)
        logger.warning("this hand does not measure everything:\n  %s", "\n  ".join(endpoint.sentences))
    if isinstance(endpoint, Supervised):
        if autostart:
            _start(runner, lambda: runner.change("configure"))
        endpoint.supervise(NodeHandle(runner), autostart=autostart)
    elif autostart:
        _start(runner, runner.bring_up)
    runner.run()
    logger.info("ended")
    if failure := getattr(runner.managed.node, "failure", ""):  # nodes of others may have none
        raise DeviceError(failure)


def _start(runner: Runner, begin: Callable[[], None]) -> None:
    """Start the node; an exception in a user's effect or program becomes one sentence, too."""
    try:
        begin()
    except VegripError:
        runner.give_up()
        raise
    except Exception as error:
        runner.give_up()
        reason = str(error).partition("\n")[0]
        name = runner.full_name
        raise VegripError(f"{name} cannot be started: {type(error).__name__}: {reason}") from error


class Ending:
    """What SIGINT and SIGTERM do: the first lets the loop end, and none disturbs what is tidied up after it.

    A launcher that is killed has the kernel send SIGTERM once for each thread it had.
    """

    def __init__(self) -> None:
        self.runner: Runner | None = None
        self.asked = False
        self._begun = False
        self._interrupted = -math.inf  # [s] when last

    def begin(self, *_: object) -> None:
        self._begun = True

    def __call__(self, *_: object) -> None:
        """Take a signal; before the loop and while the node is being configured it interrupts at once."""
        self.asked = True
        runner = self.runner
        if runner is not None:
            runner.stop()
        configured = runner is not None and (runner.running or runner.state is not Lifecycle.UNCONFIGURED)
        if self._begun or configured or time.monotonic() - self._interrupted < REPEAT_SIGNAL_S:
            return
        self._interrupted = time.monotonic()
        raise KeyboardInterrupt


@contextmanager
def _ended_by_signals() -> Iterator[Ending]:
    ending = Ending()
    before = {number: signal.signal(number, ending) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield ending
    finally:
        ending.begin()
        for number, handler in before.items():
            after = signal.SIG_IGN if number == signal.SIGTERM and ending.asked else handler
            signal.signal(number, after)


@contextmanager
def _brisk_switching() -> Iterator[None]:
    before = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH_INTERVAL)
    try:
        yield
    finally:
        sys.setswitchinterval(before)
