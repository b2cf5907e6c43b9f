"""Which branches of the safety path no test takes: watchdog, fail-safe, limits, renewal, decoding.

Usage: ``python -m tools.safety_branches``; exit code 1 where one is left, or a test fails. The control is
measured as plain Python runs it, the text that also becomes C: what a statement of the generated module did
is told of the same statement in the author's file. Only the tests of these modules run.
"""

import ast
import json
import os
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import coverage

ROOT = Path(__file__).parents[1]
KERNELS = (
    "bits", "frame_bytes", "receive", "stillness", "noise", "watchdog", "takeover", "fail_safe", "limits",
    "control", "finger_step", "finger_message",
)  # fmt: skip
"""Texts of ``vegrip/grip/kernels``."""
MODULES = (
    "transport/codec/frame.py", "transport/codec/signals.py", "transport/codec/protection.py",
    "transport/codec/sequence.py", "transport/codec/encoder.py", "transport/codec/frame_codec.py",
    "transport/codec/can_codec.py", "transport/codec/batch_codec.py", "transport/codec/msgpack_codec.py",
    "runtime/managed.py",
)  # fmt: skip
"""Modules of ``vegrip``."""
TESTS = ("grip/safety", "grip/kernels", "transport/codec", "runtime/test_managed.py")
SLOW = "not test_fuzz and not test_peer and not a_live_sensor_is_never_judged_stuck"
"""Tests that take no branch that the others leave are left out."""
GENERATED = "vegrip_plain_"

Branch = tuple[str, int, int]
"""File, and the lines from where to where; 0 = a function ends, or for a line that is not run at all."""


def main() -> int:
    os.environ["VEGRIP_KERNEL"] = "python"
    wanted = [f"*/{GENERATED}*.py", *(str(ROOT / "vegrip" / name) for name in MODULES)]
    measured = coverage.Coverage(data_file=None, branch=True, config_file=False, include=wanted)
    measured.start()  # before anything of ours is imported: its lines count, too
    import pytest  # noqa: PLC0415

    tests = ROOT / "tests"
    code = pytest.main(["-q", "-p", "no:cacheprovider", "-k", SLOW, *(str(tests / name) for name in TESTS)])
    measured.stop()
    if code != pytest.ExitCode.OK:
        return 1
    with tempfile.NamedTemporaryFile() as file:
        measured.json_report(outfile=file.name)
        taken, left = counted(json.load(file)["files"])
    for name, start, end in sorted(left):
        print(f"{name}:{start} {f'never goes on at {end}' if end else 'is not run, or never the last'}")
    print(f"{len(taken)} of {len(taken | left)} branches and lines of the safety path are taken")
    return 1 if left else 0


def counted(files: Mapping[str, Mapping[str, Any]]) -> tuple[set[Branch], set[Branch]]:
    """Return the branches that are taken, and those that are left, of what was measured by file."""
    taken: set[Branch] = set()
    known: set[Branch] = set()
    authors = dict(lines_of_authors())
    for name, found in files.items():
        lines = lines_behind(Path(name), authors)
        for done in ("executed", "missing"):
            arcs: list[list[int]] = [*found[f"{done}_branches"], *([n, 0] for n in found[f"{done}_lines"])]
            here = {
                (*lines[start], lines[end][1] if end in lines else 0) for start, end in arcs if start in lines
            }
            known |= here
            taken |= here if done == "executed" else set()
    return taken, known - taken


def lines_of_authors() -> Iterator[tuple[str, tuple[str, list[int]]]]:
    """Yield the functions of the kernels by name: file, and the lines of their statements."""
    for kernel in KERNELS:
        path = ROOT / "vegrip" / "grip" / "kernels" / f"{kernel}.py"
        for function, lines in functions_of(path):
            yield function, (str(path.relative_to(ROOT)), lines)


def lines_behind(path: Path, authors: Mapping[str, tuple[str, list[int]]]) -> dict[int, tuple[str, int]]:
    """Return what stands behind the lines of a file that was measured: a file and its line."""
    if not path.name.startswith(GENERATED):
        name = str(path.relative_to(ROOT)) if path.is_absolute() else str(path)
        count = len((ROOT / name).read_text(encoding="utf-8").splitlines())
        return {line: (name, line) for line in range(1, count + 1)}
    found: dict[int, tuple[str, int]] = {}
    for function, lines in functions_of(path):
        if function in authors:
            file, written = authors[function]
            found |= {line: (file, at) for line, at in zip(lines, written, strict=True)}
    return found


def functions_of(path: Path) -> Iterator[tuple[str, list[int]]]:
    from vegrip.c99.names import statements  # noqa: PLC0415 (after the beginning of the measurement)

    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef):
            yield node.name, [one.lineno for one in statements(node)]


if __name__ == "__main__":
    sys.exit(main())
