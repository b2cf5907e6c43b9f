"""Which nodes run on this machine: one file each in the user's runtime folder, locked while the node lives.

The lock distinguishes the living from the dead, whichever way they died; process numbers cannot.
"""

import contextlib
import fcntl
import hashlib
import json
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import msgpack
import zmq

from vegrip.errors import DeviceError, InputError, UsageError, VegripError, suggestion
from vegrip.host.folders import locked, remove_leftovers, runtime_folder, socket_path
from vegrip.whole_file import write_whole

SUFFIX = ".end"
KEPT_S = 600.0  # [s] an older report is of another run, and says nothing of now


@dataclass(frozen=True)
class ExitReport:
    """What is known of a node that is finalized."""

    name: str  # in full, with namespace
    program: str
    reason: str  # one sentence
    exit_code: int


def write_report(words: ExitReport) -> None:
    """Write ``words`` down; a folder that takes nothing keeps none."""
    with contextlib.suppress(OSError):
        write_whole(_file(words.name), json.dumps(asdict(words)))


def remove_report(name: str) -> None:
    with contextlib.suppress(OSError):
        _file(name).unlink(missing_ok=True)


def read_reports() -> dict[str, ExitReport]:
    found = [_read_report(path) for path in sorted(runtime_folder("nodes").glob(f"*{SUFFIX}"))]
    return {words.name: words for words in found if words is not None}


def _file(name: str, suffix: str = SUFFIX) -> Path:
    return runtime_folder("nodes") / f"{name.strip('/').replace('/', '.')}{suffix}"


def _read_report(path: Path) -> ExitReport | None:
    try:
        if time.time() - path.stat().st_mtime > KEPT_S:
            path.unlink()
            return None
        return ExitReport(**json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError, RecursionError):  # removed at this moment, or of another version
        return None


KILLED = "its process was killed, or crashed"


@dataclass(frozen=True)
class Entry:
    """One running node."""

    name: str  # in full, with namespace
    program: str
    namespace: str = ""
    remap: dict[str, str] = field(default_factory=dict)
    pid: int = 0
    fingers: list[str] = field(default_factory=list)  # in the order of the hand
    status_period: float = 1.0  # [s] of its NodeStatus

    @property
    def control(self) -> str:
        return self._socket("c")

    @property
    def telemetry(self) -> str:
        return self._socket("t")

    def _socket(self, kind: str) -> str:
        short = hashlib.sha256(self.name.encode()).hexdigest()[
            :12
        ]  # a full name may be too long for a socket
        return f"ipc://{socket_path('nodes', f'{short}.{kind}')}"


@contextmanager
def registered(entry: Entry) -> Iterator[None]:
    path = _file(entry.name, ".node")
    handle = locked(path)
    if handle is None:
        raise UsageError(f"a node named {entry.name} runs already; give another name or namespace")
    try:
        os.ftruncate(handle, 0)
        os.write(handle, json.dumps(asdict(entry)).encode())
        remove_report(entry.name)
        running_nodes()
        remove_leftovers()
        yield
    finally:
        for leftover in (path, _socket_file(entry.control), _socket_file(entry.telemetry)):
            leftover.unlink(missing_ok=True)
        os.close(handle)


def running_nodes() -> list[Entry]:
    """Return the nodes that run, by name; what dead ones have left is removed."""
    found = [_living(path) for path in sorted(runtime_folder("nodes").glob("*.node"))]
    return [entry for entry in found if entry is not None]


def find_node(name: str) -> Entry:
    """Return the running node ``name``: in full, or its last part when only one node has it."""
    nodes = running_nodes()
    matches = [entry for entry in nodes if entry.name in (name, f"/{name}")]
    matches = matches or [entry for entry in nodes if entry.name.endswith(f"/{name}")]
    if len(matches) == 1:
        return matches[0]
    if matches:
        raise UsageError(
            f"several nodes are called {name}: {', '.join(e.name for e in matches)}; give the full name"
        )
    if not nodes:
        raise UsageError(f"there is no node {name!r}; no node runs; try `vegrip launch demo`")
    running = suggestion(name, [entry.name for entry in nodes], "running:")
    raise UsageError(f"there is no node {name!r}; {running}")


def _socket_file(address: str) -> Path:
    return Path(address.removeprefix("ipc://"))


def _living(path: Path) -> Entry | None:
    try:
        handle = os.open(path, os.O_RDWR | os.O_CLOEXEC)
    except FileNotFoundError:
        return None
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return _read(handle)
    else:
        if os.fstat(handle).st_nlink:  # else its owner has removed it in this moment
            _tidy_up_after(_read(handle))
            path.unlink(missing_ok=True)
        return None
    finally:
        os.close(handle)


def _tidy_up_after(dead: Entry | None) -> None:
    if dead is None:
        return
    write_report(ExitReport(dead.name, dead.program, KILLED, 1))
    for address in (dead.control, dead.telemetry):
        _socket_file(address).unlink(missing_ok=True)


def _read(handle: int) -> Entry | None:
    try:
        return Entry(**json.loads(os.pread(handle, 65_536, 0)))
    except (ValueError, TypeError, RecursionError):  # being written at this moment, or by another version
        return None


ANSWER_TIMEOUT_S = 5.0  # [s]
CONFIGURING_MAY_TAKE = 120.0  # [s] it compiles
_ERRORS: dict[int, type[VegripError]] = {2: UsageError, 3: InputError, 4: DeviceError}


def ask(entry: Entry, call: str, patience: float = ANSWER_TIMEOUT_S, **arguments: Any) -> Any:
    """Return what the node answers to ``call`` within ``patience`` [s]; its errors are raised here."""
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


STARTS_WITHIN = 60.0  # [s] a node that is so young may still import and open its bus
PROC = Path("/proc")
_STOPPED = ("T", "t")  # by a signal, by a debugger; proc(5)


def silent_state(pid: int) -> str:
    """Return ``starting``, ``stopped``, ``stuck`` or ``ended``: what a process is that does not answer."""
    try:
        # the name in parentheses may hold anything; state is the first field behind it, starttime the 20th
        fields = (PROC / str(pid) / "stat").read_text(encoding="utf-8").rpartition(")")[2].split()
        state, start_ticks = fields[0], int(fields[19])
    except (OSError, IndexError, ValueError):
        return "ended"
    if state in _STOPPED:
        return "stopped"
    age = time.clock_gettime(time.CLOCK_BOOTTIME) - start_ticks / os.sysconf("SC_CLK_TCK")
    return "starting" if age < STARTS_WITHIN else "stuck"
