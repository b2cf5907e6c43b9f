"""Translated text compiled for this machine and called from Python."""

import ctypes
import subprocess
from pathlib import Path

from vegrip.host.compiled_folder import compiler

__all__ = ["CompilerError", "build", "compiler", "load"]

HOST_INCLUDES = "#include <math.h>\n#include <stdbool.h>\n#include <stdint.h>\n\n"
EXACT = ("-std=c99", "-ffp-contract=off")
"""Every operation rounds once, as in numba: no fused multiplication and addition."""
FLAGS = (*EXACT, "-O2", "-fno-math-errno", "-shared", "-fPIC", "-w")
MAX_COMPILE_S = 120.0  # [s] that a compiler may take


class CompilerError(Exception):
    """There is no C compiler, or it has failed; says which and why."""


def build(text: str, library: Path, flags: tuple[str, ...] = FLAGS) -> None:
    """Compile ``text`` into the shared ``library``."""
    found = compiler()
    if found is None:
        raise CompilerError("there is no C compiler (cc, gcc or clang)")
    command = [found, *flags, "-x", "c", "-", "-o", str(library), "-lm"]
    try:
        done = subprocess.run(
            command,
            input=HOST_INCLUDES + text,
            text=True,
            capture_output=True,
            timeout=MAX_COMPILE_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise CompilerError(f"{found}: {error}") from None
    if done.returncode:
        lines = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
        raise CompilerError(f"{found}: {lines[0]}")


def load(library: Path) -> ctypes.CDLL:
    """Load a shared library; calls keep the interpreter's lock, since a step is shorter than a switch."""
    return ctypes.PyDLL(str(library))
