"""How the command line shows what a node made of a recording."""

from collections.abc import Mapping
from typing import Any

from rich.table import Table

from vegrip.cli._tables import printer
from vegrip.identification.recording import LoadReport
from vegrip.runtime.replay.run import Outcome

ROWS = (
    ("samples", "samples", ""),
    ("in contact", "contact_time", " s"),
    ("force, estimate against measured, rms", "force_rms", " N"),
    ("mean normalised innovation squared", "nis", ""),
    ("consistent, of the health reports with a verdict", "consistent", ""),
    ("measurements refused as outliers", "rejected", ""),
    ("lowest margin bound", "lowest_margin_bound", ""),
    ("commands", "commands", ""),
    ("highest command", "highest_command", " N"),
)


def print_outcome(outcome: Outcome, reports: Mapping[str, LoadReport]) -> None:
    """Print one column per finger, then what was refused on the way."""
    console = printer()
    told = outcome.as_dict()["fingers"]
    table = Table(box=None, padding=(0, 2))
    table.add_column("")
    for finger in told:
        table.add_column(finger, justify="right")
    for title, key, unit in ROWS:
        table.add_row(title, *(_number(each[key], unit) for each in told.values()))
    for title, key in (("input", "conditions"), ("fails", "failing"), ("suspect", "suspects")):
        if key == "suspects" and not any(each[key].keys() - {"none"} for each in told.values()):
            continue  # none was looked for
        table.add_row(title, *(_first(each[key]) for each in told.values()))
    for title, key in (("pressure exponent", "pressure_exponent"), ("friction", "friction_coefficient")):
        table.add_row(f"{title}, last", *(_estimate(each[key]) for each in told.values()))
    console.print(table)
    for finger, report in reports.items():
        if not report.is_clean:
            console.print(f"recording of {finger}: {report.summary()}")
    for name, count in outcome.rejected.items():
        console.print(f"refused on the bus or in the node: {name} ({count} x)")


def _number(value: float | None, unit: str) -> str:
    return "-" if value is None else f"{value:.4g}{unit}"


def _first(counts: Mapping[str, int]) -> str:
    total = sum(counts.values())
    return ", ".join(f"{name} {count / total:.0%}" for name, count in list(counts.items())[:2]) or "-"


def _estimate(estimate: Mapping[str, Any]) -> str:
    if estimate["value"] is None:
        return "-"
    doubt = "" if estimate["valid"] else " (not valid)"
    return f"{estimate['value']:.3g} +- {_number(estimate['std'], '')}{doubt}"
