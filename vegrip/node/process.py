"""Run one node in this process: bus, loop, telemetry, control, signals, and an orderly end."""

import logging
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager

from vegrip.clock import WallClock
from vegrip.codec.msgpack_codec import MsgpackCodec
from vegrip.errors import VegripError
from vegrip.messages import Lifecycle, NodeStatus
from vegrip.node import last_words
from vegrip.node.control import Control, ControlServer
from vegrip.node.handle import NodeHandle, Supervised
from vegrip.node.launch_file import NodeConfig
from vegrip.node.logs import node_logs
from vegrip.node.program import NodeContext, find_program
from vegrip.node.registry import Entry, registered
from vegrip.node.runner import Runner
from vegrip.node.telemetry import Direction, Telemetry
from vegrip.node.telemetry_socket import TelemetrySocket
from vegrip.transport.endpoint import Endpoint
from vegrip.transport.open import Hand, open_endpoint

FAREWELL = 0.25  # [s] in which those who follow a node that came back have connected to its telemetry
SWITCH_INTERVAL = 0.0005
"""[s] after which a side thread must yield to the loop; the 5 ms of Python are more than two ticks."""


def run_node(config: NodeConfig, autostart: bool = True) -> None:
    """Run the node of ``config`` until it has finished or the process is told to end (SIGINT, SIGTERM).

    Raises:
        VegripError: it cannot be started; the message says what to do.

    """
    name = config.full_name
    context = NodeContext(name.rpartition("/")[2], config.namespace, config.fingers, config.loop.tick_period)
    node = find_program(config.program)(config.parameters, context)
    hand = Hand(config.fingers, config.hand, config.namespace, config.remap)
    fingers, status_period = list(config.fingers), config.loop.status_period
    entry = Entry(
        name, config.program, config.namespace, dict(config.remap), os.getpid(), fingers, status_period
    )
    with ExitStack() as stack:
        stack.enter_context(node_logs(name))
        stack.enter_context(registered(entry))
        stack.enter_context(_last_words(entry))
        codec = MsgpackCodec(config.namespace, remap=config.remap)
        sink = TelemetrySocket(entry.telemetry, codec)
        telemetry = stack.enter_context(closing(Telemetry(sink)))
        with _told(telemetry, sink, name):
            endpoint = open_endpoint(config.transport, hand, f"{name} [transport]")
        stack.enter_context(closing(endpoint))
        runner = Runner(node, endpoint, WallClock(), config.loop, telemetry, name)
        control = Control(runner, sink.topics)
        stack.enter_context(closing(ControlServer(entry.control, control)))
        stack.enter_context(_stopped_by_signals(runner))
        stack.enter_context(_brisk_switching())
        telemetry.start()
        _run(runner, endpoint, autostart)


@contextmanager
def _last_words(entry: Entry) -> Iterator[None]:
    """Leave the reason of a bad end for those who ask after it."""
    try:
        yield
    except VegripError as error:
        last_words.leave(last_words.LastWords(entry.name, entry.program, str(error), error.exit_code))
        raise


@contextmanager
def _told(telemetry: Telemetry, sink: TelemetrySocket, name: str) -> Iterator[None]:
    """Tell those who follow the telemetry of a node without a bus that it is finalized."""
    try:
        yield
    except VegripError:
        time.sleep(FAREWELL)
        sink.listen()
        status = NodeStatus(time.monotonic_ns(), name, 0, Lifecycle.FINALIZED, rejected={"bus_not_opened": 1})
        telemetry.offer(status, Direction.OUT)
        raise


def _run(runner: Runner, endpoint: Endpoint, autostart: bool) -> None:
    logger = logging.getLogger(f"vegrip.{runner.full_name}")
    if isinstance(endpoint, Supervised):
        if autostart:
            _start(runner, lambda: runner.change("configure"))
        endpoint.supervise(NodeHandle(runner), autostart=autostart)
    elif autostart:
        _start(runner, runner.bring_up)
    runner.run()
    logger.info("ended")


def _start(runner: Runner, begin: Callable[[], None]) -> None:
    """Start the node; what somebody's own effect or program raises becomes one sentence, too."""
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


@contextmanager
def _stopped_by_signals(runner: Runner) -> Iterator[None]:
    """Let signals end the loop; while the node is still being configured they interrupt at once."""

    def end(*_: object) -> None:
        runner.stop()
        if not runner.running and runner.state is Lifecycle.UNCONFIGURED:
            raise KeyboardInterrupt

    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    for number in before:
        signal.signal(number, end)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def _brisk_switching() -> Iterator[None]:
    before = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH_INTERVAL)
    try:
        yield
    finally:
        sys.setswitchinterval(before)
