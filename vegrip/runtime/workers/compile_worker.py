"""Compile the estimator of a model file into the cache.

Usage: ``python -m vegrip.runtime.workers.compile_worker MODEL``.

A running node has this done by another process before it takes a new model over; compiling beside the loop
would hold the interpreter's lock too long.
"""

import sys
from pathlib import Path

from vegrip.errors import VegripError
from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.model import read_model
from vegrip.runtime.launcher import end_with_parent


def main(path: Path) -> int:
    """Compile, and say in one sentence why not."""
    try:
        ContactEstimator(read_model(path), SensorNoise())
    except VegripError as error:
        print(error, file=sys.stderr)  # noqa: T201
        return error.exit_code
    return 0


if __name__ == "__main__":
    end_with_parent()  # nobody waits for what a node that has ended would have used
    sys.exit(main(Path(sys.argv[1])))
