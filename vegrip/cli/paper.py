"""``vegrip paper``: the paper's tables and figures, computed anew."""

import json
from pathlib import Path
from typing import Annotated

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from vegrip.cli._outputs import FORCE, Outputs
from vegrip.cli._terminal import printer


def paper(
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="DIR", help="Draw every figure as PNG into DIR.")
    ] = None,
    force: FORCE = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the numbers as one JSON object.")] = False,
) -> None:
    """Print the tables of Tiezzi and Kao (2007), computed twice, and draw their figures.

    Example: vegrip paper -o figures
    """
    from vegrip.contact.paper.tables import numbers

    with Outputs(force=force) as outputs:
        outputs.pictures(output)
        if as_json:
            # 1e999 is valid JSON and reads as infinity; what json.dumps writes, Infinity, is not JSON
            typer.echo(json.dumps(numbers()).replace("Infinity", "1e999"))
        else:
            console = Console(markup=False)
            for table in (_table_1(), _table_2(), _creep(), _limit_surface(), _fits()):
                console.print(table)
        if outputs.write(output, _draw):
            printer(stderr=True).print(f"figures in {output}")


def _draw(folder: Path) -> None:
    from vegrip.contact.paper.figures import save_all

    save_all(folder)


def _table_1() -> Table:
    from vegrip.contact.paper import tables

    table = _new(
        "Table I: coefficient of the profile", "k", "C_k, eq. (4)", "quadrature of (24)", "difference"
    )
    for name, C in tables.table_1().items():
        check = tables.coefficient_by_quadrature(float(name))
        table.add_row(name, f"{C:.9f}", f"{check:.9f}", f"{C - check:.0e}")
    return table


def _table_2() -> Table:
    from vegrip.contact.paper import tables

    fit = tables.fit_radius()
    table = _new(
        "Table II: contact radius, eq. (25)",
        "k",
        "C_k",
        "a/a0",
        "a/a0 from (24)",
        "a/a0, fit (65)",
        "fit error",
    )
    for name, (C, ratio) in tables.table_2().items():
        check = (tables.coefficient_by_quadrature(2.0) / tables.coefficient_by_quadrature(float(name))) ** 0.5
        fitted = float(fit.radius_ratio(float(name)))
        cells = (f"{C:.6f}", f"{ratio:.6f}", f"{check:.6f}", f"{fitted:.4f}", f"{fitted / ratio - 1:+.2%}")
        table.add_row(name, *cells)
    return table


def _creep() -> Table:
    from vegrip.contact.paper import tables
    from vegrip.contact.prony import creep_of

    title = "Figs. 4, 7, 8: displacement held (g), load held (h and on); j is the exact conjugate of g"
    table = _new(title, "t [s]", "g", "h", "a/a0", "C_k", "k", "p_max/p0", "j")
    j = creep_of(tables.RELAXATION)
    for (t, g), row in zip(tables.relaxation(), tables.creep(), strict=True):
        table.add_row(f"{t:g}", f"{g:.6f}", *(f"{x:.6f}" for x in row[1:]), f"{float(j(t)):.6f}")
    return table


def _limit_surface() -> Table:
    from vegrip.contact.paper import tables

    columns = [f"{name}, k={k}" for k in tables.LIMIT_SURFACE_K for name in ("f", "m")]
    table = _new("Limit surface, eqs. (49), (50): f/(mu N) and m/(mu N a)", "d/a", *columns)
    surfaces = [tables.limit_surface(k) for k in tables.LIMIT_SURFACE_K]
    for rows in zip(*surfaces, strict=True):
        table.add_row(f"{rows[0][0]:g}", *(f"{x:.8f}" for row in rows for x in row[1:]))
    return table


def _fits() -> Table:
    from vegrip.contact.paper.tables import fit_power, fit_radius

    radius, power = fit_radius(), fit_power()
    table = _new("Fits at k = 2, 2.1 .. 4", "equation", "first", "second")
    table.add_row("(65) a/a0 = sqrt(1.5)(1 - A exp(-B k))", f"A = {radius.A:.6f}", f"B = {radius.B:.6f}")
    table.add_row("(38) C_k = 1 + A k^B", f"A = {power.A:.6f}", f"B = {power.B:.6f}")
    last = ("(40) k = alpha (1.5/h - 1)^beta", f"alpha = {power.alpha:.6f}", f"beta = {power.beta:.6f}")
    table.add_row(*last)
    return table


def _new(title: str, *columns: str) -> Table:
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, padding=(0, 1, 0, 0))  # fits 80 columns
    for i, column in enumerate(columns):
        table.add_column(column, justify="right" if i else "left", no_wrap=True)
    return table
