"""The bus as a library of this machine, compiled once and in the background.

The bus process neither waits for the compiler nor imports the translator: until the library is there the same
text in Python carries the frames, and where there is no compiler it goes on to do so.
"""

import ctypes
import hashlib
import os
import platform
import subprocess
import sys
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Final

from vegrip.clock import NS
from vegrip.host import compiled_folder
from vegrip.host.compiled_folder import compiler
from vegrip.host.folders import locked
from vegrip.transport.canbus.bus_records import SLOTS, Bus

HERE: Final = Path(__file__).parent
TEXT: Final = ("frame_bits", "bus", "carry")
SOURCES: Final = (*TEXT, "bus_records", "compiled_bus")
"""Modules that say what is compiled."""
ENTRIES: Final = {
    "carry": (ctypes.c_int64, 1),
    "advance": (ctypes.c_bool, 1),
    "conclude": (ctypes.c_bool, 1),
    "next_event": (ctypes.c_int64, 0),
    "catch_up": (None, 0),
    "take_packet": (ctypes.c_bool, 3),
    "bring_events": (None, 1),
    "hand_out": (None, 1),
}
"""Functions that Python calls: what they give, and how many whole numbers they take beside the bus."""
LOOK_AGAIN: Final = NS  # [ns] between two looks for the library that is being compiled


def is_wanted() -> bool:
    return os.environ.get("VEGRIP_KERNEL", "") in ("", "c", "c-float")


@cache
def library_name() -> str:
    """Return the name of the library, which changes with all that it is made from."""
    files = [HERE / "outside.c", *(HERE / f"{name}.py" for name in SOURCES)]
    files += sorted((HERE.parents[1] / "c99").glob("*.py"))
    parts = [platform.machine(), *(path.read_text(encoding="utf-8") for path in files)]
    return "vegrip_bus_" + hashlib.sha256("\n".join(parts).encode()).hexdigest()[:24]


def text_in_c() -> str:
    """Return the bus in C, without the includes that any such text has."""
    from vegrip.c99 import BOOL, LONG, VOID, record, translate  # noqa: PLC0415 (takes time that the bus has not)

    bus = record(Bus)
    text = "\n".join((HERE / f"{name}.py").read_text(encoding="utf-8") for name in TEXT)
    entries = {name: (bus, *[LONG] * wholes) for name, (_, wholes) in ENTRIES.items()}
    outside = {"nearest": LONG, "copy_bytes": VOID, "store": VOID, "load": LONG, "clock": LONG}
    outside |= {"sleep_until": BOOL, "look": BOOL, "receive": LONG, "send": BOOL}
    by_hand = (HERE / "outside.c").read_text(encoding="utf-8")
    most = f"#define VG_MOST_WATCHED {SLOTS + 1}"
    return "\n".join([most, by_hand, translate(text, entries, outside=outside).text()])


def compile_library() -> Path:
    """Return the library, compiled where it is not there yet."""
    from vegrip.c99 import host  # noqa: PLC0415

    def make(library: Path) -> None:
        host.build(text_in_c(), library, (*host.FLAGS, "-D_GNU_SOURCE"))  # for ppoll and clock_nanosleep

    return compiled_folder.library(library_name(), make)


class CompiledBus:
    """The functions of the library, called as those in Python are."""

    def __init__(self, library: Path) -> None:
        loaded = ctypes.PyDLL(str(library))
        for name, (result, wholes) in ENTRIES.items():
            function = loaded[f"vg_{name}"]
            function.argtypes, function.restype = [ctypes.c_void_p, *[ctypes.c_int64] * wholes], result
            setattr(self, name, function)


def load(path: Path) -> CompiledBus | None:
    try:
        return CompiledBus(path)
    except (OSError, AttributeError):
        return None


class Search:
    """Looks for the library, and has it compiled where it is not there."""

    def __init__(self) -> None:
        self._found: CompiledBus | None = None
        self._next_look = 0 if is_wanted() else sys.maxsize  # [ns]
        self._compiling: subprocess.Popen[bytes] | None = None

    def found(self, now: int) -> CompiledBus | None:
        """Return the functions of the library; None: it is not there, at the time ``now`` [ns]."""
        if now < self._next_look:
            return self._found
        self._next_look = now + LOOK_AGAIN
        if self._compiling is not None and self._compiling.poll() is None:
            return None
        path = compiled_folder.found_library(library_name())
        if path is not None:
            self._next_look = sys.maxsize
            self._found = load(path)
        elif self._compiling is None and compiler() is not None:
            root, quiet = str(HERE.parents[2]), subprocess.DEVNULL
            text = f"import sys; sys.path.append({root!r}); from {__name__} import main; main()"
            self._compiling = subprocess.Popen(
                [sys.executable, "-c", text], stdin=quiet, stdout=quiet, stderr=quiet, start_new_session=True
            )
        elif self._compiling is None or self._compiling.returncode:
            self._next_look = sys.maxsize  # there is no compiler, or it has failed
        return self._found


def main() -> None:
    """Compile the library, unless another process does."""
    os.nice(10)
    where = compiled_folder.folder()
    with suppress(OSError):
        where.mkdir(mode=0o700, parents=True, exist_ok=True)
        if locked(where / f"{library_name()}.lock") is None:
            return
    compile_library()
