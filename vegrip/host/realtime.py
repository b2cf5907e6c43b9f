"""Real-time priority and locked memory for the loops of a hand, where this user may have them.

As ros2_control does: SCHED_FIFO for the thread of the loop, and memory that is not paged out. The bus stands
above the node, and the node above the hand, since each waits for the one before.
Also the processor time of any process, as the kernel counts it.
"""

import _thread
import ctypes
import math
import os
import resource
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

HUB_PRIORITY: Final = 11
NODE_PRIORITY: Final = 10
HAND_PRIORITY: Final = 9
SIDE_THREAD_PRIORITY: Final = 1
"""Of threads beside a loop: one with the interpreter's lock must not stand behind other programs."""

SWITCH: Final = "VEGRIP_REALTIME"
"""Environment variable; ``0`` switches real-time priority off for a process and those that it starts."""

LIMITS_FILE: Final = "/etc/security/limits.d/vegrip.conf"
WANTED_RTPRIO: Final = 50

_LOCK_PRESENT_AND_COMING, _ON_FAULT = 3, 4  # sys/mman.h: MCL_CURRENT | MCL_FUTURE, MCL_ONFAULT
_THREADS: Final = Path("/proc/self/task")
_loops: "set[LoopPriority]" = set()  # of this process, that have their priority now


@dataclass(frozen=True)
class Permission:
    """What this user may ask the system for."""

    highest: int  # greatest real-time priority, 0: none
    may_lock: bool  # as much memory as the process will ever have


@dataclass(frozen=True)
class Scheduling:
    """How a loop is to run."""

    priority: int = 0  # of SCHED_FIFO, 0: that of any other program
    lock_memory: bool = False
    sentence: str = ""  # what is not permitted, and the remedy


def permission() -> Permission:
    if sys.platform != "linux":
        return Permission(0, may_lock=False)
    highest, memory = (
        resource.getrlimit(kind)[0] for kind in (resource.RLIMIT_RTPRIO, resource.RLIMIT_MEMLOCK)
    )
    root = os.geteuid() == 0
    unlimited = resource.RLIM_INFINITY
    return Permission(99 if root or highest == unlimited else highest, root or memory == unlimited)


def is_switched_on() -> bool:
    return os.environ.get(SWITCH, "1").strip().lower() not in ("0", "off", "false", "no")


def choose_scheduling(wanted: int, allowed: Permission, *, on: bool) -> Scheduling:
    """Return how a loop that wants a ``wanted`` priority is to run; all of it or nothing.

    Memory is locked only where there is no limit: under a limit every later allocation could fail.
    """
    if not on or wanted <= 0:
        return Scheduling()
    if allowed.highest < wanted:
        return Scheduling(sentence=_advice("real-time priority is"))
    if not allowed.may_lock:
        return Scheduling(wanted, sentence=_advice("locked memory is"))
    return Scheduling(wanted, lock_memory=True)


def remedy() -> str:
    """Return the command that permits both."""
    user = os.environ.get("USER", "") or str(os.getuid())
    lines = f"{user} - rtprio {WANTED_RTPRIO}\\n{user} - memlock unlimited\\n"
    return f"printf '{lines}' | sudo tee {LIMITS_FILE}, and log in again"


def _advice(what: str) -> str:
    return (
        f"{what} not permitted to this user, so commands may be late when other programs are busy; "
        f"to permit it: {remedy()} (realtime = false does without)"
    )


class LoopPriority:
    """The priority of the loop in this process, which comes with activation and goes with its end.

    What is compiled before must not stand before everything else on the machine. Processes and threads that
    are started later are given the usual priority by the system (SCHED_RESET_ON_FORK).
    """

    def __init__(self, scheduling: Scheduling) -> None:
        self._scheduling = scheduling
        self._locked = False
        self._before: dict[int, tuple[int, os.sched_param]] = {}  # by thread

    def take(self) -> str:
        """Give the calling thread its priority, and the threads beside it theirs.

        Returns:
            A sentence about what is not permitted, or none.

        """
        wanted = self._scheduling
        if not wanted.priority:
            return wanted.sentence
        own = _thread_id()
        for thread in _threads():
            asked = wanted.priority if thread == own else SIDE_THREAD_PRIORITY
            if not self._schedule(thread, asked) and thread == own:
                return _advice("real-time priority is")
        _loops.add(self)
        if wanted.lock_memory:
            # what is touched from now on stays; what was reserved and is never used takes no memory
            self._locked = ctypes.CDLL(None).mlockall(_LOCK_PRESENT_AND_COMING | _ON_FAULT) == 0
            return "" if self._locked else _advice("locked memory is")
        return wanted.sentence

    def give_back(self) -> None:
        """Return to the priorities of before."""
        _loops.discard(self)
        for thread, (policy, parameter) in self._before.items():
            _set(thread, policy | os.SCHED_RESET_ON_FORK, parameter)
        self._before.clear()
        if self._locked:
            self._locked = False
            ctypes.CDLL(None).munlockall()

    def _schedule(self, thread: int, priority: int) -> bool:
        try:
            before = os.sched_getscheduler(thread) & ~os.SCHED_RESET_ON_FORK, os.sched_getparam(thread)
        except OSError:  # it has ended
            return False
        done = _set(thread, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(priority))
        if done:
            self._before.setdefault(thread, before)
        return done


class SideTask:
    """What a loop has done beside itself, in a thread with the priority of the others beside a loop.

    The system gives a new thread the usual priority, behind other programs. So the loop does not wait until
    it has begun, as ``threading.Thread.start`` does, and the thread raises its priority first: it will have
    the interpreter's lock. A program that it starts begins with its priority, since the thread holds the lock
    until that runs; :func:`vegrip.runtime.background.run_behind` lowers it.
    """

    def __init__(self, work: Callable[..., object], *arguments: object) -> None:
        self._work, self._arguments = work, arguments
        self._over = threading.Event()

    def start(self) -> None:
        _thread.start_new_thread(self._run, ())

    def is_alive(self) -> bool:
        return not self._over.is_set()

    def join(self, timeout: float | None = None) -> None:
        self._over.wait(timeout)

    def _run(self) -> None:
        if _loops:
            _set(_thread_id(), os.SCHED_FIFO, os.sched_param(SIDE_THREAD_PRIORITY))
        try:
            self._work(*self._arguments)
        finally:
            self._over.set()


def take_usual_priority() -> None:
    if sys.platform == "linux" and os.sched_getscheduler(0) == os.SCHED_FIFO:
        _set(0, os.SCHED_OTHER, os.sched_param(0))


@contextmanager
def switched(*, on: bool) -> Iterator[None]:
    """Switch real-time priority off for this process and those that it starts, unless ``on``."""
    before = os.environ.get(SWITCH)
    if not on:
        os.environ[SWITCH] = "0"
    try:
        yield
    finally:
        if before is not None:
            os.environ[SWITCH] = before
        elif not on:
            del os.environ[SWITCH]


def priority_of(wanted: int) -> LoopPriority:
    return LoopPriority(choose_scheduling(wanted, permission(), on=is_switched_on()))


def _threads() -> list[int]:
    try:
        return [int(entry.name) for entry in _THREADS.iterdir()]
    except OSError:
        return [_thread_id()]


def _thread_id() -> int:
    return threading.get_native_id()


def _set(thread: int, policy: int, parameter: os.sched_param) -> bool:
    try:
        os.sched_setscheduler(thread, policy, parameter)
    except OSError:
        return False
    return True


FIELDS_BEFORE_TIMES = 11
"""Of the line behind the name of the program; user and system time follow."""


def processor_time(process: int) -> float:
    """Return the time [s] that all threads of a process took so far, NaN where it is not known."""
    try:
        line = Path(f"/proc/{process}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return math.nan
    user, system = line.rpartition(")")[2].split()[FIELDS_BEFORE_TIMES : FIELDS_BEFORE_TIMES + 2]
    return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")
