"""Compiling and running what was exported, for the tests of every entry."""

import subprocess
from pathlib import Path

from vegrip.export import Exported

Firmware = tuple[Path, Exported]


def run(*command: str | Path, where: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(list(map(str, command)), cwd=where, capture_output=True, text=True, check=False)


def sources(entry: str) -> tuple[str, ...]:
    """Return the library, and what its self-test is made of beside it."""
    return f"lh_{entry}.c", "lh_vectors.c", "lh_selftest.c"
