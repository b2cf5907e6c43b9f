"""``vegrip bench``: speed as ratios, both times of a ratio measured in the same run."""

import importlib
import json
import pkgutil
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import track
from rich.table import Table

from vegrip.errors import UsageError

Results = dict[str, dict[str, float]]


def bench(
    names: Annotated[
        list[str] | None, typer.Argument(help="Benchmarks to run; all when none is named.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the results as one JSON object.")] = False,
) -> None:
    """Measure how much faster this code is than the plain way, on this machine.

    Example: vegrip bench recursion creep_inverse
    """
    known = _benchmarks()
    chosen = names or list(known)
    for name in chosen:
        if name not in known:
            raise UsageError(f"there is no benchmark {name!r}; there are {', '.join(known)}")
    results: Results = {}
    for name in track(chosen, "measuring", console=Console(stderr=True), transient=True):
        results |= _run(known[name])
    if as_json:
        typer.echo(json.dumps(results))
    else:
        Console().print(_table(results))


def _benchmarks() -> dict[str, str]:
    """Module of every benchmark by its short name."""
    import vegrip.benchmarks as package

    found = pkgutil.iter_modules(package.__path__)
    return {info.name: f"{package.__name__}.{info.name}" for info in found if not info.name.startswith("_")}


def _run(module: str) -> Results:
    try:
        benchmark = importlib.import_module(module)
    except ModuleNotFoundError as error:
        raise UsageError(f"{module} compares with {error.name}: pip install 'vegrip[dev]'") from None
    results: Results = benchmark.run()
    return results


def _table(results: Results) -> Table:
    table = Table(title="times of one call; ratio = theirs / ours", title_justify="left")
    for column in ("benchmark", "ours [us]", "theirs [us]", "ratio"):
        table.add_column(column, justify="left" if column == "benchmark" else "right")
    for name, row in results.items():
        table.add_row(name, f"{row['ours_us']:.3g}", f"{row['theirs_us']:.3g}", f"{row['ratio']:.3g}")
    return table
