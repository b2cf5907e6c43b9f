"""What an export costs and whether it agrees: measured with the compilers of this machine, never guessed."""

import re
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from shutil import which

from vegrip.c99 import host
from vegrip.export.precision import PRECISIONS, Precision

STRICT = ("-Wall", "-Wextra", "-Wconversion", "-pedantic", "-Werror")
OPTIMISED = (*host.EXACT, "-O2", "-fno-math-errno")
LONGEST = 300.0  # [s] that a compiler or a self-test may take
AGREEMENT = re.compile(r"(\d+) of (\d+) numbers equal to the bit, largest [a-z ]+ (\S+)")
PASSED = re.compile(r"^PASS (\d+) frames$", re.MULTILINE)
INSTRUCTIONS = re.compile(r"^(\w+): (\d+) instructions on average, (\d+) at most$", re.MULTILINE)
TRIED = re.compile(r"^(\d+) inputs tried$", re.MULTILINE)
STACK = re.compile(r":([A-Za-z_]\w*)[\w.]*\t(\d+)\t(\S+)")
CALLS = {
    "estimator": {"update": "assimilate", "slip_margin": "margin_of", "least_force": "least_force"},
    "finger": {"frame": "finger_receive", "tick": "finger_tick"},
}
"""By what is exported: function of the header -> the kernel it calls."""


@dataclass(frozen=True)
class Size:
    """Of the estimator alone, without the mathematical library [bytes]."""

    compiler: str
    flash: int  # code and tables
    ram: int  # of all fingers together beside their memories: nothing is kept
    stack: dict[str, int]  # by function of the header, the deepest way down


@dataclass(frozen=True)
class Run:
    """A self-test that was run."""

    machine: str
    passed: bool
    frames: int
    equal: int
    numbers: int
    largest: float
    instructions: Mapping[str, tuple[int, int]]
    """Function of the header -> instructions of a call, on average and at most; where they were counted."""


@dataclass(frozen=True)
class Search:
    """A search for the inputs that take most instructions."""

    inputs: int
    most: Mapping[str, int]
    """Function of the header -> instructions of the worst call that was found."""


@dataclass(frozen=True)
class Measured:
    """What could be measured here; None for what could not."""

    host: Size | None
    cortex: Size | None  # the emulated processor
    host_run: Run | None
    cortex_run: Run | None
    search: Search | None  # on the emulated processor
    missing: tuple[str, ...]  # what was not there, in words


def measure(
    folder: Path,
    prefix: str,
    calls: Mapping[str, frozenset[str]],
    entry: str = "estimator",
    precision: Precision = PRECISIONS["double"],
) -> Measured:
    """Compile the export in ``folder``, run its self-test, and read off sizes."""
    folder = folder.resolve()  # compilers run elsewhere
    missing, processor = [], precision.processor
    compiler, arm, qemu = host.compiler(), which("arm-none-eabi-gcc"), which("qemu-system-arm")
    with tempfile.TemporaryDirectory() as scratch:
        here = Path(scratch)
        host_size, host_run, cortex = None, None, None
        if compiler:
            host_size = _size(folder, (prefix, entry), calls, compiler, (), here)
            host_run = _run([str(_host_test(folder, (prefix, entry), compiler, here))], "this machine")
        if arm:
            cortex = _size(folder, (prefix, entry), calls, arm, tuple(processor["cpu"].split()), here)
        arm_run, search = None, None
        if arm and qemu:
            tested = _emulated(folder, qemu, processor, here, processor["core"])
            arm_run = _run(tested, f"{processor['Core']} in qemu")
            search = _search(_emulated(folder, qemu, processor, here, "worst"))
    missing += [] if compiler else ["a C compiler for this machine (cc, gcc or clang)"]
    missing += [] if arm else ["a compiler for Cortex-M (arm-none-eabi-gcc)"]
    missing += [] if qemu else ["an emulator (qemu-system-arm)"]
    return Measured(host_size, cortex, host_run, arm_run, search, tuple(missing))


def _size(
    folder: Path,
    names: tuple[str, str],
    calls: Mapping[str, frozenset[str]],
    tool: str,
    flags: tuple[str, ...],
    here: Path,
) -> Size | None:
    p, entry = names
    object_file = here / f"{entry}.o"
    source = folder / f"{p}_{entry}.c"
    command = [tool, *OPTIMISED, *flags, *STRICT, "-c", str(source), "-o", str(object_file)]
    if _done([*command, "-fstack-usage"], here).returncode and _done(command, here).returncode:
        return None
    usage = object_file.with_suffix(".su")
    frames = stack_frames(usage.read_text("utf-8")) if usage.exists() else {}
    text, data, bss = _sections(tool, object_file)
    depth = {
        name: frames.get(f"{p}_{name}", 0) + deepest(f"{p}_k_{kernel}", calls, frames)
        for name, kernel in CALLS[entry].items()
    }
    return Size(_version(tool), text + data, data + bss, depth if frames else {})


def stack_frames(usage: str) -> dict[str, int]:
    """Read what -fstack-usage wrote: function -> its own bytes; of copies the largest."""
    frames: dict[str, int] = {}
    for name, size, _ in STACK.findall(usage):
        frames[name] = max(frames.get(name, 0), int(size))
    return frames


def deepest(name: str, calls: Mapping[str, frozenset[str]], frames: Mapping[str, int]) -> int:
    """Return the bytes on the way down that needs most; what was inlined counts with its caller."""
    below = max((deepest(callee, calls, frames) for callee in calls.get(name, ())), default=0)
    return frames.get(name, 0) + below


def _sections(tool: str, object_file: Path) -> tuple[int, int, int]:
    size = which(Path(tool).name.replace("gcc", "size")) if "arm-none-eabi" in tool else which("size")
    if size is None:
        return 0, 0, 0
    row = _done([size, str(object_file)], object_file.parent).stdout.splitlines()[1].split()
    return int(row[0]), int(row[1]), int(row[2])


def _host_test(folder: Path, names: tuple[str, str], compiler: str, here: Path) -> Path:
    p, entry = names
    compiled = here / f"{entry}.o"  # where its size was measured; to compile it takes a second
    library = compiled if compiled.exists() else folder / f"{p}_{entry}.c"
    program = here / "selftest"
    sources = [str(library), *(str(folder / f"{p}_{name}.c") for name in ("vectors", "selftest"))]
    _done([compiler, *OPTIMISED, *sources, "-o", str(program), "-lm"], here)
    return program


def _emulated(folder: Path, qemu: str, processor: Mapping[str, str], here: Path, name: str) -> list[str]:
    """Build ``name`` for the emulated board as the Makefile of the export does, and return how to run it."""
    program = here / f"{name}.elf"
    made = _done(["make", "-C", str(folder), f"BUILD={here}", str(program)], here)
    board = [qemu, "-M", processor["board"], "-nographic", "-icount", "shift=0"]
    if made.returncode:
        return ["false"]
    return [*board, "-semihosting-config", "enable=on,target=native", "-kernel", str(program)]


def _run(command: list[str], machine: str) -> Run | None:
    try:
        done = _done(command, Path())
    except OSError:
        return None
    agreement, passed = AGREEMENT.search(done.stdout), PASSED.search(done.stdout)
    if agreement is None:
        return None
    frames = int(passed[1]) if passed else 0
    return Run(
        machine,
        passed is not None and done.returncode == 0,
        frames,
        int(agreement[1]),
        int(agreement[2]),
        float(agreement[3]),
        {name: (int(usual), int(most)) for name, usual, most in INSTRUCTIONS.findall(done.stdout)},
    )


def _search(command: list[str]) -> Search | None:
    done = _done(command, Path())
    tried = TRIED.search(done.stdout)
    if tried is None:
        return None
    return Search(int(tried[1]), {name: int(most) for name, _, most in INSTRUCTIONS.findall(done.stdout)})


def _version(tool: str) -> str:
    return _done([tool, "--version"], Path()).stdout.splitlines()[0]


def _done(command: list[str], where: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command,
        cwd=where,
        capture_output=True,
        text=True,
        timeout=LONGEST,
        check=False,
        stdin=subprocess.DEVNULL,
    )
