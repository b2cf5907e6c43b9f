"""Breaks files of every kind and reads them: ``python tests/attack/readers --cases 20`` or ``--seconds 600``.

Every case runs in a process of its own with bounds on processor time, memory and file size. It passes when
the file is read or refused (a VegripError; of a command a sentence and an exit code), and when nothing was
written but in the output folder. What fails is told with the command that repeats it, and kept in
``build/attack``.
"""

import argparse
import ctypes
import os
import random
import resource
import shutil
import sys
import tempfile
import time
import traceback
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mutation import mutated
from subjects import CANARIES, SUBJECTS, RefusedError, Subject, broken

from vegrip.errors import VegripError

SECONDS = 5  # [s] of processor time for one file; most take hundredths
MEMORY = 2**30  # [bytes] more than the process has before
LARGEST = 2**28  # [bytes] of a file that is written
KEPT = Path("build/attack")
READ, REFUSED, FAILED = 0, 3, 77
WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
CHANGES = frozenset(
    (
        "os.mkdir",
        "os.remove",
        "os.rename",
        "os.rmdir",
        "os.symlink",
        "os.link",
        "os.truncate",
        "os.chmod",
        "os.chown",
    )
)
FORBIDDEN = frozenset(("socket.connect", "subprocess.Popen", "os.system", "os.exec", "os.posix_spawn"))
_PR_SET_PDEATHSIG = 1


class EscapeError(BaseException):
    """Something outside of the output was touched; no reader may catch this."""


@dataclass
class Tally:
    """What came of the cases of a subject."""

    read: int = 0
    refused: int = 0
    seconds: float = 0.0  # [s] processor time of the slowest
    failures: int = 0


def main() -> int:
    """Attack, print a line for each subject, and return the exit code."""
    asked = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    asked.add_argument("--only", default="", help="part of a subject's name")
    asked.add_argument("--seed", type=int, default=0, help="of the first case")
    asked.add_argument("--cases", type=int, default=20, help="of each subject")
    asked.add_argument(
        "--seconds", type=float, default=0.0, help="go on for so long instead, with ever new seeds"
    )
    asked.add_argument("--canaries", action="store_true", help="attack readers that are broken on purpose")
    given = asked.parse_args()
    subjects = CANARIES if given.canaries else SUBJECTS
    chosen = {name: subject for name, subject in subjects.items() if given.only in name}
    tallies = {name: Tally() for name in chosen}
    with tempfile.TemporaryDirectory(prefix="vegrip-attack-") as folder:
        settle(Path(folder))
        for name, subject in chosen.items():
            prepare(subject, Path(folder, "whole", name))
        seed, deadline = given.seed, time.monotonic() + given.seconds
        while seed < given.seed + given.cases or time.monotonic() < deadline:
            for name, subject in chosen.items():
                attack(name, subject, Path(folder), seed, tallies[name])
            seed += 1
    for name, tally in tallies.items():
        print(
            f"{'FAILED' if tally.failures else 'ok':6} {name:12} {tally.read} read, {tally.refused} refused, "
            f"{tally.failures} failed, slowest {tally.seconds:.2f} s"
        )
    return 1 if any(tally.failures for tally in tallies.values()) else 0


def settle(folder: Path) -> None:
    """Let everything that looks for a place of its own find it below ``folder``."""
    for name in ("HOME", "TMPDIR", "XDG_CACHE_HOME", "VEGRIP_CACHE", "VEGRIP_RUNTIME_DIR"):
        place = folder / "home" / name.lower()
        place.mkdir(parents=True, mode=0o700)
        os.environ[name] = str(place)
    tempfile.tempdir = None


def prepare(subject: Subject, folder: Path) -> None:
    """Write the whole example, and see that it is read: what refuses everything would pass every attack."""
    folder.mkdir(parents=True)
    subject.make(folder)
    out = folder.with_name(f"{folder.name} out")
    out.mkdir()
    quietly(lambda: subject.read(folder, out))
    shutil.rmtree(out)


def attack(name: str, subject: Subject, folder: Path, seed: int, tally: Tally) -> None:
    """Break a copy of the example in the way of ``seed``, read it, and judge."""
    pick = random.Random(f"{name} {seed}")
    inside, outside = folder / "in", folder / "out"
    shutil.copytree(folder / "whole" / name, inside)
    outside.mkdir()
    target = pick.choice(sorted(path for path in inside.glob(subject.targets) if path.is_file()))
    broken(target, subject, lambda data: mutated(data, pick), inside=pick.random() < 0.7)
    before = seen(folder, outside)
    status, seconds, said = read_apart(subject, inside, outside)
    tally.seconds = max(tally.seconds, seconds)
    trouble = judged(status, said)
    if seen(folder, outside) != before:
        trouble = f"changed what is not the output: {sorted(seen(folder, outside) ^ before)}"
    if trouble:
        tally.failures += 1
        report(name, seed, target, trouble)
    elif status == READ:
        tally.read += 1
    else:
        tally.refused += 1
    shutil.rmtree(inside)
    shutil.rmtree(outside)


def read_apart(subject: Subject, inside: Path, outside: Path) -> tuple[int, float, str]:
    """Read in a process of its own; return how it ended, its processor time [s], and what it said."""
    said = outside.parent / "said"
    child = os.fork()
    if child == 0:
        status = FAILED
        try:
            bounded()
            with said.open("w") as stream:
                os.dup2(stream.fileno(), 1)
                os.dup2(stream.fileno(), 2)
            guard(inside.parent, outside)
            status = outcome(subject, inside, outside)
            sys.stdout.flush()
            sys.stderr.flush()
        finally:
            os._exit(status)
    _, status, used = os.wait4(child, 0)
    text = said.read_text(errors="replace") if said.exists() else ""
    said.unlink(missing_ok=True)
    return os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime, text


def outcome(subject: Subject, inside: Path, outside: Path) -> int:
    """Read, and return what came of it; whatever is not a refusal is printed."""
    os.chdir(outside)
    try:
        subject.read(inside, outside)
    except (VegripError, RefusedError):
        return REFUSED
    except BaseException:  # noqa: BLE001 (whatever it is, it is what is looked for)
        traceback.print_exc()
        return FAILED
    return READ


def bounded() -> None:
    """Bound this process, and let it end with its parent."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, 9)
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    for limit, value in (
        (resource.RLIMIT_CPU, SECONDS),
        (resource.RLIMIT_AS, pages * resource.getpagesize() + MEMORY),
        (resource.RLIMIT_FSIZE, LARGEST),
        (resource.RLIMIT_CORE, 0),
    ):
        resource.setrlimit(limit, (value, value))


def guard(folder: Path, outside: Path) -> None:
    """Raise when a file outside ``outside`` and the places of ``settle`` is opened for writing or changed."""
    allowed = tuple(os.path.realpath(place) for place in (outside, folder / "home", "/dev"))

    def watch(event: str, arguments: tuple[Any, ...]) -> None:
        if event in FORBIDDEN:
            raise EscapeError(f"{event} {arguments}")
        touched = event in CHANGES or (
            event == "open" and isinstance(arguments[2], int) and arguments[2] & WRITES
        )
        path = arguments[0]
        if touched and isinstance(path, str | bytes | os.PathLike):
            real = os.path.realpath(os.fsdecode(path))
            if not any(real == place or real.startswith(f"{place}/") for place in allowed):
                raise EscapeError(f"{event} {real}")

    sys.addaudithook(watch)


def seen(folder: Path, outside: Path) -> frozenset[tuple[str, int]]:
    """Return the files in ``folder`` with the sums of their content, but for the places that may change."""
    return frozenset(
        (str(path), zlib.crc32(path.read_bytes()) if path.is_file() else -1)
        for path in folder.rglob("*")
        if not path.is_relative_to(outside) and not path.is_relative_to(folder / "home")
        if not path.is_relative_to(folder / "whole")
    )


def judged(status: int, said: str) -> str:
    """Return what is wrong with the end of a case; empty when nothing is."""
    if status < 0:
        return f"ended by signal {-status}\n{said[-2000:]}"
    if status not in (READ, REFUSED) or "Traceback" in said:
        return f"not refused in a sentence (exit code {status})\n{said[-2000:]}"
    if any(not (letter.isprintable() or letter in "\n\t\r") for letter in said):
        return f"control characters of the file reach the terminal\n{said[-500:]!r}"
    return ""


def report(name: str, seed: int, target: Path, trouble: str) -> None:
    """Tell of a failure, and keep its file."""
    KEPT.mkdir(parents=True, exist_ok=True)
    kept = KEPT / f"{name.replace(' ', '-')}-{seed}-{target.name}"
    shutil.copy(target, kept)
    print(f"{name}: {trouble}")
    print(f"  again: python tests/attack/readers --only '{name}' --seed {seed} --cases 1; the file: {kept}\n")


def quietly(call: Any) -> None:
    """Call with standard output put aside."""
    with Path(os.devnull).open("w") as nothing:
        kept = os.dup(1)
        os.dup2(nothing.fileno(), 1)
        try:
            call()
        finally:
            sys.stdout.flush()
            os.dup2(kept, 1)
            os.close(kept)


if __name__ == "__main__":
    sys.exit(main())
