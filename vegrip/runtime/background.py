"""Helper processes of a node, at the lowest priority of the machine."""

import os
import runpy
import shutil
import subprocess
import sys
from collections.abc import Sequence

from vegrip.host.realtime import take_usual_priority
from vegrip.runtime.launcher import end_with_parent

LOWEST, WAITED_FOR = "19", "10"  # nice


def run_behind(
    module: str,
    arguments: Sequence[str],
    patience: float | None = None,
    *,
    idle: bool = True,
    given: bytes = b"",
) -> subprocess.CompletedProcess[str]:
    """Run ``python -m module`` as a helper, and return it at its end; it is killed after ``patience`` [s].

    It finds ``given`` on its standard input: a file would stay behind where this process is killed.

    It has a low priority from its first instruction on, also when this process has a real-time one: what it
    imports alone takes a second, each slice of which could delay the loop on a core that they share. With
    ``idle`` it gives a core up at once to any other program, where a nice one keeps it for the rest of its
    slice, some milliseconds; but on a machine without idle time it does not come to an end. It ends when
    this process ends.

    A program in front of it sets the priority. Python code between fork and exec has no place in a process
    with threads, and a priority that is lowered before the exec would let this process, which waits for it
    with the interpreter's lock, stand behind everything else on the machine.
    """
    begun = [sys.executable, "-m", "vegrip.runtime.background", str(os.getpid())]
    command = [*_in_front(idle), *begun, module, *arguments]
    done = subprocess.run(command, input=given, capture_output=True, check=False, timeout=patience)
    output, complaint = (text.decode(errors="replace") for text in (done.stdout, done.stderr))
    return subprocess.CompletedProcess(command, done.returncode, output, complaint)


def _in_front(idle: bool) -> list[str]:
    chrt, nice = shutil.which("chrt"), shutil.which("nice")
    if idle and chrt is not None:
        return [chrt, "--idle", "0"]
    usual = [chrt, "--other", "0"] if chrt is not None else []
    return [*usual, nice, "-n", LOWEST if idle else WAITED_FOR] if nice is not None else usual


if __name__ == "__main__":  # arguments: the process to end with, a module, and those of the module
    # before the imports of the module, which take minutes on a busy machine: the node may end meanwhile
    parent, module = int(sys.argv[1]), sys.argv[2]
    end_with_parent(parent)
    take_usual_priority()  # where no program in front of it has done so
    sys.argv[:3] = [module]
    runpy.run_module(module, run_name="__main__", alter_sys=True)
