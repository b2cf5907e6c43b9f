"""Find the benchmarks and run them, for ``vegrip bench``: one that fails costs no other its result."""

import importlib
import importlib.util
import json
import pkgutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from types import ModuleType

import typer

import benchmarks
from benchmarks import _timing
from vegrip.cli._terminal import complain, printer
from vegrip.errors import UsageError, suggestion

Results = dict[str, dict[str, float]]
BESIDE = ("cpu_s", "peak_memory_mb", "right")  # what is printed beside times


def known() -> dict[str, str]:
    """Return the module of every benchmark that can be run, by its short name."""
    names = [info.name for info in pkgutil.iter_modules(benchmarks.__path__) if info.name[0] != "_"]
    modules = {name: f"{benchmarks.__name__}.{name}" for name in names}
    return {name: module for name, module in modules.items() if _has_run(module)}


def run_all(names: Sequence[str], *, as_json: bool, quick: bool) -> int:
    """Run and print the benchmarks of these names, all where there is none; return how many failed.

    Raises:
        UsageError: there is no such benchmark.

    """
    modules = known()
    for name in names:
        if name not in modules:
            raise UsageError(f"there is no benchmark {name!r}; {suggestion(name, modules)}")
    if not as_json:
        typer.echo("times of one call; ratio = theirs / ours")
        typer.echo(f"{'benchmark':44} {'ours [us]':>12} {'theirs [us]':>12} {'ratio':>8}")
    failed = 0
    results: Results = {}
    console = printer(stderr=True)
    for name in names or modules:
        with console.status(f"measuring {name}") if console.is_terminal else nullcontext():
            rows, complaint = _run(modules[name], quick=quick)
        results |= rows
        if not as_json:
            for row in rows.items():
                typer.echo(line(*row))
        if complaint:
            complain(f"{name}: {complaint}")
            failed += 1
    if as_json:
        typer.echo(json.dumps(results))
    return failed


def line(name: str, row: dict[str, float]) -> str:
    if "cores" in row:
        parts = ", ".join(f"{part} {value:.3g}" for part, value in row.items() if part != "cores")
        return f"{name:44} {row['cores']:.3g} cores ({parts})"
    unit = " bytes" if "ours_bytes" in row else ""
    more = ", ".join(f"{part} {value:.4g}" for part, value in row.items() if part in BESIDE)
    told = f"{name:44} {row['ours_us']:12.3g} {row['theirs_us']:12.3g} {row['ratio']:8.3g}{unit}"
    return f"{told} ({more})" if more else told


def _has_run(module: str) -> bool:
    """Look for ``run`` in the source: to import all benchmarks takes seconds."""
    spec = importlib.util.find_spec(module)
    return spec is not None and "\ndef run(" in Path(str(spec.origin)).read_text(encoding="utf-8")


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
    places = [(m, name) for m in (_timing, benchmark) for name in getattr(m, "SMALLEST", {})]
    before = [getattr(module, name) for module, name in places]
    for module, name in places:
        setattr(module, name, module.SMALLEST[name])
    try:
        yield
    finally:
        for (module, name), value in zip(places, before, strict=True):
            setattr(module, name, value)
