"""Which nodes run on this machine: one file each in the user's runtime folder, locked while the node lives.

The lock tells the living from the dead, whichever way they died; process numbers cannot.
"""

import fcntl
import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path

from vegrip.errors import UsageError
from vegrip.host.folders import locked, remove_leftovers, runtime_folder, socket_path
from vegrip.runtime import exit_reports
from vegrip.spelling import suggestion

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
    """Make ``entry`` known for as long as the context lasts.

    Raises:
        UsageError: a node of this name runs already.

    """
    path = _file(entry.name)
    handle = locked(path)
    if handle is None:
        raise UsageError(f"a node named {entry.name} runs already; give another name or namespace")
    try:
        os.ftruncate(handle, 0)
        os.write(handle, json.dumps(asdict(entry)).encode())
        exit_reports.remove_report(entry.name)
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
    """Return the running node ``name``: in full, or its last part when only one node has it.

    Raises:
        UsageError: none or several are called so.

    """
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


def _file(name: str) -> Path:
    return runtime_folder("nodes") / f"{name.strip('/').replace('/', '.')}.node"


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
    exit_reports.write_report(exit_reports.ExitReport(dead.name, dead.program, KILLED, 1))
    for address in (dead.control, dead.telemetry):
        _socket_file(address).unlink(missing_ok=True)


def _read(handle: int) -> Entry | None:
    try:
        return Entry(**json.loads(os.pread(handle, 65_536, 0)))
    except (ValueError, TypeError, RecursionError):  # being written at this moment, or by another version
        return None
