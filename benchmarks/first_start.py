"""How long a node of five fingers takes until it is active, with an empty cache and again.

``python -m benchmarks.first_start`` compiles by C and by numba, each in a process and a cache folder
of its own, and prints seconds of processor time and of the clock, imports included.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time

from vegrip.grip.node import GraspForce
from vegrip.grip.parameters import GraspParameters, estimator_factory
from vegrip.transport.codec import CanCodec

MODES = ("c", "numba")


def configure() -> str:
    """Bring a node to active as a program does, and return how it answers states."""
    names, parameters = ("thumb", "index", "middle", "ring", "little"), GraspParameters()
    node = GraspForce("grasp", names, estimator_factory(parameters, names, "grasp"), parameters)
    node.configure()
    codec = CanCodec(names, fd=True)
    node.run_compiled({name: line for name in names if (line := codec.line(name)) is not None})
    node.activate()
    return node.path_taken


def main() -> None:
    """Measure in children, or be one of them."""
    if sys.argv[1:] == ["--child"]:
        path = configure()
        used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        processor = sum(one.ru_utime + one.ru_stime for one in used)
        sys.stdout.write(f"{processor:5.1f} s of processor; {path}; ")
        return
    for mode in MODES:
        with tempfile.TemporaryDirectory() as cache:
            for when in ("empty cache", "again"):
                sys.stdout.write(f"{mode:6} {when:12} ")
                sys.stdout.flush()
                command = [sys.executable, "-m", "benchmarks.first_start", "--child"]
                environment = os.environ | {"VEGRIP_CACHE": cache, "VEGRIP_KERNEL": mode}
                start = time.monotonic()
                subprocess.run(command, env=environment, check=True)
                sys.stdout.write(f"{time.monotonic() - start:.1f} s by the clock\n")


if __name__ == "__main__":
    main()
