"""``vegrip bench``: speed as ratios, both times of a ratio measured in the same run."""

import importlib
import sys
from pathlib import Path
from types import ModuleType
from typing import Annotated

import typer

from vegrip.cli._options import JSON
from vegrip.errors import UsageError

SOURCE = Path(__file__).parents[2]  # where the package lies in a checkout
EXIT_LOST = 4  # exit code when a benchmark failed; the others are printed


def bench(
    names: Annotated[
        list[str] | None, typer.Argument(help="Benchmarks to run; all when none is named.")
    ] = None,
    as_json: JSON = False,
    quick: Annotated[
        bool,
        typer.Option("--quick", help="Smallest sizes: check that all of them run; the times mean nothing."),
    ] = False,
) -> None:
    """Measure how much faster this code is than the plain way, on this machine.

    Example: vegrip bench recursion creep_inverse

    The benchmarks are part of the source, not of what is installed.
    """
    runner = from_source("benchmarks._run", "the benchmarks are", "in a checkout `make bench` runs them")
    if runner.run_all(names or [], as_json=as_json, quick=quick):
        raise typer.Exit(EXIT_LOST)


def from_source(module: str, what: str, remedy: str) -> ModuleType:
    """Return a module that is part of the source and not installed.

    Raises:
        UsageError: the source is not here.

    """
    if not (SOURCE / Path(*module.split("."))).with_suffix(".py").is_file():
        raise UsageError(f"{what} part of the source, which is not here; {remedy}")
    if str(SOURCE) not in sys.path:
        sys.path.insert(0, str(SOURCE))
    return importlib.import_module(module)
