"""Ask a running node something, from another process."""

from typing import Any

import msgpack
import zmq

from vegrip.errors import DeviceError, InputError, UsageError, VegripError
from vegrip.runtime.registry import Entry

ANSWER_TIMEOUT_S = 5.0  # [s]
CONFIGURING_MAY_TAKE = 120.0  # [s] it compiles
_ERRORS: dict[int, type[VegripError]] = {2: UsageError, 3: InputError, 4: DeviceError}


def ask(entry: Entry, call: str, patience: float = ANSWER_TIMEOUT_S, **arguments: Any) -> Any:
    """Return what the node answers to ``call``.

    Raises:
        VegripError: of the kind the node raised.
        DeviceError: no answer within ``patience`` [s].

    """
    with zmq.Context() as context, context.socket(zmq.REQ) as socket:
        socket.linger = 0
        socket.connect(entry.control)
        socket.send(msgpack.packb({"call": call, "arguments": arguments}))
        if not socket.poll(round(patience * 1000)):
            raise DeviceError(
                f"the node {entry.name} does not answer within {patience:g} s; is it still starting?"
            )
        answer = msgpack.unpackb(socket.recv())
    if "error" in answer:
        raise _ERRORS.get(answer.get("exit_code", 1), VegripError)(answer["error"])
    return answer["result"]
