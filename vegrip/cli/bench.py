"""``vegrip bench``: speed as ratios, both times of a ratio measured in the same run."""

import importlib
import importlib.util
import json
import pkgutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from types import ModuleType
from typing import Annotated

import typer

from vegrip.cli._terminal import complain, printer
from vegrip.errors import UsageError, suggestion

Results = dict[str, dict[str, float]]
SOURCE = Path(__file__).parents[2]  # where the package lies in a checkout
EXIT_LOST = 4  # exit code when a benchmark failed; the others are printed


def bench(
    names: Annotated[
        list[str] | None, typer.Argument(help="Benchmarks to run; all when none is named.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the results as one JSON object.")] = False,
    quick: Annotated[
        bool,
        typer.Option("--quick", help="Smallest sizes: check that all of them run; the times mean nothing."),
    ] = False,
) -> None:
    """Measure how much faster this code is than the plain way, on this machine.

    Example: vegrip bench recursion creep_inverse

    The benchmarks are part of the source, not of what is installed.
    """
    known = benchmarks()
    chosen = names or list(known)
    for name in chosen:
        if name not in known:
            raise UsageError(f"there is no benchmark {name!r}; {suggestion(name, known)}")
    failed = 0
    results: Results = {}
    if not as_json:
        typer.echo("times of one call; ratio = theirs / ours")
        typer.echo(f"{'benchmark':44} {'ours [us]':>12} {'theirs [us]':>12} {'ratio':>8}")
    for name in chosen:
        with _measuring(name):
            rows, complaint = _run(known[name], quick=quick)
        results |= rows
        if not as_json:
            for row in rows.items():
                typer.echo(_line(*row))
        if complaint:
            complain(f"{name}: {complaint}")
            failed += 1
    if as_json:
        typer.echo(json.dumps(results))
    if failed:
        raise typer.Exit(EXIT_LOST)


def benchmarks() -> dict[str, str]:
    """Return the module of every benchmark that can be run, by its short name.

    Raises:
        UsageError: this is not the source tree.

    """
    if not (SOURCE / "benchmarks" / "_timing.py").is_file():
        raise UsageError(
            "the benchmarks are part of the source, which is not here; in a checkout `make bench` runs them"
        )
    if str(SOURCE) not in sys.path:
        sys.path.insert(0, str(SOURCE))
    package = importlib.import_module("benchmarks")
    found = pkgutil.iter_modules(package.__path__)
    modules = {
        info.name: f"{package.__name__}.{info.name}" for info in found if not info.name.startswith("_")
    }
    return {name: module for name, module in modules.items() if _has_run(module)}


def _has_run(module: str) -> bool:
    """Look for ``run`` in the source: to import all benchmarks takes seconds."""
    spec = importlib.util.find_spec(module)
    source = Path(spec.origin).read_text(encoding="utf-8") if spec is not None and spec.origin else ""
    return "\ndef run(" in source


def _run(module: str, *, quick: bool) -> tuple[Results, str]:
    try:
        benchmark = importlib.import_module(module)
        with _small(benchmark) if quick else nullcontext():
            results: Results = benchmark.run()
    except ModuleNotFoundError as error:
        return {}, f"compares with {error.name}: pip install 'vegrip[dev]'"
    except Exception as error:  # noqa: BLE001 - one benchmark that fails costs no other its result
        return {}, f"failed ({type(error).__name__}: {error})"
    return results, ""


@contextmanager
def _small(benchmark: ModuleType) -> Iterator[None]:
    timing = importlib.import_module("benchmarks._timing")
    places = [(m, name) for m in (timing, benchmark) for name in getattr(m, "SMALLEST", {})]
    before = [getattr(module, name) for module, name in places]
    for module, name in places:
        setattr(module, name, module.SMALLEST[name])
    try:
        yield
    finally:
        for (module, name), value in zip(places, before, strict=True):
            setattr(module, name, value)


@contextmanager
def _measuring(name: str) -> Iterator[None]:
    console = printer(stderr=True)
    with console.status(f"measuring {name}") if console.is_terminal else nullcontext():
        yield


def _line(name: str, row: dict[str, float]) -> str:
    if "cores" in row:
        parts = ", ".join(f"{part} {value:.3g}" for part, value in row.items() if part != "cores")
        return f"{name:44} {row['cores']:.3g} cores ({parts})"
    unit = " bytes" if "ours_bytes" in row else ""
    return f"{name:44} {row['ours_us']:12.3g} {row['theirs_us']:12.3g} {row['ratio']:8.3g}{unit}"
