"""Compiling and running what was exported, for the tests of every entry."""

import subprocess
from pathlib import Path

from vegrip.export import Exported, Request
from vegrip.model import paper_model

Firmware = tuple[Path, Exported]
SANITIZED = ("-fsanitize=undefined,address,float-cast-overflow", "-fno-sanitize-recover=all", "-g", "-O1")
FRAMES = {"estimator": 200, "finger": 260}


def request_of(entry: str, precision: str, frames: int = 0) -> Request:
    frames = frames or FRAMES[entry]
    return Request(paper_model(8e-3), prefix="lh", frames=frames, entry=entry, precision=precision)


def run(*command: str | Path, where: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(list(map(str, command)), cwd=where, capture_output=True, text=True, check=False)


def sources(entry: str) -> tuple[str, ...]:
    """Return the library, and what its self-test is made of beside it."""
    return f"lh_{entry}.c", "lh_vectors.c", "lh_selftest.c"
