"""The control socket of a node: parameters, lifecycle and status, asked for by other processes.

A side thread answers. What changes the node is handed to the loop and happens between two messages; what only
reads a frozen value is answered at once.
"""

import dataclasses
import threading
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import msgpack
import zmq

from vegrip.errors import UsageError, VegripError
from vegrip.messages import Lifecycle
from vegrip.runtime.handle import NodeHandle
from vegrip.runtime.lifecycle import allowed_transitions, describe_parameters, route
from vegrip.runtime.runner import Runner
from vegrip.transport.connection_limit import ConnectionLimit

MAX_REQUEST_BYTES = 65_536  # [bytes] of a request
STOP_POLL_MS = 100  # [ms] between two looks at whether to stop
LOOP_TIMEOUT_S = 120.0  # [s] for the loop; configuring may compile

Call = Callable[..., Any]


class NodeCalls:
    """What may be asked of a running node."""

    def __init__(self, runner: Runner, topics: Callable[[], Mapping[str, Any]]) -> None:
        self._runner = runner
        self._node = NodeHandle(runner)
        self.calls: dict[str, Call] = {
            "parameters": self.parameters,
            "set_parameter": self.set_parameter,
            "state": self.state,
            "set_state": self.set_state,
            "status": self.status,
            "zero": self.zero,
            "grasp": lambda **goal: self._of_grip("grasp", goal),
            "release": lambda **goal: self._of_grip("release", goal),
            "grasp_status": lambda: self._of_grip("grasp_status", time.monotonic_ns()),
            "topics": lambda: dict(topics()),
        }

    def parameters(self) -> list[dict[str, Any]]:
        return describe_parameters(self._runner.managed.node.parameters)

    def set_parameter(self, name: str, value: Any) -> list[dict[str, Any]]:
        self._in_loop(lambda: self._node.set_parameter(name, value))
        return self.parameters()

    def state(self) -> dict[str, Any]:
        managed = self._runner.managed
        return {
            "state": managed.state.name.lower(),
            "on_hold": managed.on_hold,
            "transitions": allowed_transitions(managed.state),
        }

    def set_state(self, target: str) -> dict[str, Any]:
        """Go to the state ``target``, over others if need be, or make the transition ``target``."""
        states = {state.name.lower(): state for state in Lifecycle}

        def change() -> None:
            current = self._runner.state
            steps = route(current, states[target]) if target in states else [target]
            for step in steps:
                self._runner.change(step)

        self._in_loop(change)
        return self.state()

    def status(self) -> dict[str, Any] | None:
        """Return the last NodeStatus, and the clock of the sender where it is estimated."""
        status, clock = self._runner.status, self._runner.clock
        if status is None:
            return None
        extra: dict[str, Any] = {} if clock is None else {"clock": dataclasses.asdict(clock)}
        if path := self._runner.path_taken:
            extra["path"] = path
        return {**dataclasses.asdict(status), "state": status.state.name.lower(), **extra}

    def zero(self) -> None:
        """Have the devices of the hand take their own zeros; never while they may hold something."""

        def call() -> None:
            if self._runner.state is Lifecycle.ACTIVE:
                raise UsageError(
                    "the node is active and may hold something, whose load would become zero; open the hand, "
                    "`vegrip lifecycle set NODE inactive`, then zero it"
                )
            if not self._runner.zero():
                raise UsageError(
                    "this hand has no command for its zero; state it as `zero` in [device] of its map"
                )

        self._in_loop(call)

    def _of_grip(self, name: str, argument: Any) -> dict[str, Any] | None:
        node = self._runner.managed.node
        call = getattr(node, name, None)
        if call is None:
            raise UsageError(f"{node.name} does not grip; give the name of a grasp_force")
        status = self._in_loop(lambda: call(argument))
        if status is None:
            return None
        return {**dataclasses.asdict(status), "phase": status.phase.name.lower()}

    def _in_loop(self, call: Call) -> Any:
        return self._runner.inbox.put(call).result(timeout=LOOP_TIMEOUT_S)


class Answers:
    """The answer to any request; the part of the server that knows no socket."""

    def __init__(self, calls: Mapping[str, Call], counts: Counter[str]) -> None:
        self._calls = calls
        self._counts = counts

    def answer(self, request: Sequence[bytes]) -> bytes:
        """Return the answer to the frames of a request, of which there should be one."""
        try:
            (body,) = request
            asked = msgpack.unpackb(body)
            call, arguments = self._calls[asked["call"]], asked.get("arguments", {})
            result = call(**arguments)
            return bytes(msgpack.packb({"result": result}, default=str))
        except VegripError as error:
            sentence, exit_code = str(error), error.exit_code
        except Exception as error:  # noqa: BLE001 (a bad request must not end the thread)
            self._counts["request"] += 1
            sentence = f"the request cannot be answered: {error!r}"
            exit_code = UsageError.exit_code
        plain = sentence.encode("utf-8", "replace").decode()  # names that were asked for may be no text
        return bytes(msgpack.packb({"error": plain, "exit_code": exit_code}))


class ControlServer:
    """The thread that answers at ``address``.

    A request is one frame of msgpack, after an empty one as a socket of kind REQ puts it. Every other one
    is answered with an error and counted as ``request``, and the next request is answered as well.
    """

    def __init__(self, address: str, control: NodeCalls, counts: Counter[str] | None = None) -> None:
        self._counts = Counter() if counts is None else counts
        self._answers = Answers(control.calls, self._counts)
        self._context = zmq.Context()
        self._socket = self._context.socket(zmq.ROUTER)
        self._socket.setsockopt(zmq.MAXMSGSIZE, MAX_REQUEST_BYTES)
        self._limit = ConnectionLimit(self._socket, address, self._counts)
        self._socket.bind(address)
        self._limit.start()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="control", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the thread."""
        self._stop.set()
        self._thread.join()
        self._limit.close()
        self._socket.close(linger=0)
        self._context.term()

    def _run(self) -> None:
        while not self._stop.is_set():
            try:
                if self._socket.poll(STOP_POLL_MS):
                    frames = self._socket.recv_multipart()
                    end = 2 if b"" in frames[1:2] else 1  # of the envelope
                    answer = self._answers.answer(frames[end:])
                    self._socket.send_multipart([*frames[:end], answer], zmq.DONTWAIT)
            except zmq.ZMQError:  # of this one request; it must not end the thread
                self._counts["request"] += 1
