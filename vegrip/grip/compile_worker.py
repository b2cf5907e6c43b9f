"""Compile the estimator of a model file, and the step of a finger with it, into the cache.

Usage: ``python -m vegrip.grip.compile_worker MODEL``.

A running node has this done by another process before it takes a new model over; compiling beside the loop
would hold the interpreter's lock too long.
"""

import sys
from pathlib import Path

from vegrip.errors import VegripError
from vegrip.grip.controller import GripController
from vegrip.model import read_model


def main(path: Path) -> int:
    """Compile, and say in one sentence why not."""
    try:
        GripController(("finger",), read_model(path))
    except VegripError as error:
        print(error, file=sys.stderr)  # noqa: T201
        return error.exit_code
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
