"""The kernels of the bus and their loop as a library of this machine, compiled once and in the background.

The bus process neither waits for the compiler nor imports the translator: until the library is there the
model in Python carries the frames, and where there is no compiler it goes on to do so.
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

HERE: Final = Path(__file__).parent
KERNELS: Final = ("frame_bits", "requests", "deliveries", "carry")
SOURCES: Final = ("leaving", "loop_text", "compiled_bus")
"""Modules beside the kernels that say what is compiled."""
LOOK_AGAIN: Final = NS  # [ns] between two looks for the library that is being compiled
POINTER, WHOLE = ctypes.c_void_p, ctypes.c_int64


def is_wanted() -> bool:
    """Whether ``VEGRIP_KERNEL`` leaves the bus to C."""
    return os.environ.get("VEGRIP_KERNEL", "") in ("", "c", "c-float")


@cache
def library_name() -> str:
    """Return the name of the library, which changes with all that it is made from."""
    files = [*(HERE / "kernels").glob("*.py"), *(HERE / f"{name}.py" for name in SOURCES)]
    files += (HERE.parents[1] / "c99").glob("*.py")
    parts = [platform.machine(), *(path.read_text(encoding="utf-8") for path in sorted(files))]
    return "vegrip_bus_" + hashlib.sha256("\n".join(parts).encode()).hexdigest()[:24]


def compile_library() -> Path:
    """Return the library, compiled where it is not there yet.

    Raises:
        CompilerError: there is no compiler, or it failed.

    """
    from vegrip.c99 import BYTES, LONG, LONGS, host, translate  # noqa: PLC0415 (takes time that the bus has not)
    from vegrip.transport.canbus import loop_text  # noqa: PLC0415

    def make(library: Path) -> None:
        text = "\n".join((HERE / "kernels" / f"{name}.py").read_text(encoding="utf-8") for name in KERNELS)
        both, queue = (LONGS, BYTES), (LONGS, BYTES, LONG)
        entries = {
            "take_packet": (*queue, LONG, LONG),
            "next_event": (LONGS,),
            "advance": (*both, LONG, LONG),
            "conclude": queue,
            "hand_out": queue,
        }
        c = translate(text, entries).text()
        host.build(f"{c}\n{loop_text.LOOP}", library, (*host.FLAGS, *loop_text.LOOP_FLAGS))

    return compiled_folder.library(library_name(), make)


class CompiledBus:
    """The functions of the library.

    Args:
        library: as :func:`compile_library` returns it.

    Raises:
        OSError: it cannot be loaded.

    """

    def __init__(self, library: Path) -> None:
        loaded = ctypes.PyDLL(str(library))
        self.loop = loaded.vg_loop
        self.loop.argtypes, self.loop.restype = [POINTER, POINTER, WHOLE], WHOLE
        self.take_packet = loaded.vg_take_packet
        self.take_packet.argtypes, self.take_packet.restype = [POINTER, POINTER, *[WHOLE] * 3], ctypes.c_int
        self.next_event = loaded.vg_next_event
        self.next_event.argtypes, self.next_event.restype = [POINTER], WHOLE
        self.advance = loaded.vg_advance
        self.advance.argtypes, self.advance.restype = [POINTER, POINTER, WHOLE, WHOLE], ctypes.c_int
        for name in ("conclude", "hand_out"):
            function = loaded[f"vg_{name}"]
            function.argtypes, function.restype = [POINTER, POINTER, WHOLE], None
            setattr(self, name, function)


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
            self._found = _loaded(path)
        elif self._compiling is None and compiler() is not None:
            self._compiling = _started()
        elif self._compiling is None or self._compiling.returncode:
            self._next_look = sys.maxsize  # there is no compiler, or it has failed
        return self._found


def _loaded(path: Path) -> CompiledBus | None:
    try:
        return CompiledBus(path)
    except (OSError, AttributeError):
        return None


def _started() -> subprocess.Popen[bytes]:
    root, quiet = str(HERE.parents[2]), subprocess.DEVNULL
    text = f"import sys; sys.path.append({root!r}); from {__name__} import main; main()"
    return subprocess.Popen(
        [sys.executable, "-c", text], stdin=quiet, stdout=quiet, stderr=quiet, start_new_session=True
    )


def main() -> None:
    """Compile the library, unless another process does."""
    os.nice(10)
    where = compiled_folder.folder()
    with suppress(OSError):
        where.mkdir(mode=0o700, parents=True, exist_ok=True)
        if locked(where / f"{library_name()}.lock") is None:
            return
    compile_library()
