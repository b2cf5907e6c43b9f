"""The tables of ``docs/faults.md``, made from the cases themselves."""

from collections.abc import Iterable

from vegrip.validation.faults.rogue_programs import ACTS
from vegrip.validation.faults.table import CASES, Case

HEADER = "| fault | for | seen as | within | over after | what happens |\n|---|---|---|---|---|---|"

STRANGERS = "| what is done | counted as | over after | what happens |\n|---|---|---|---|"


def markdown(cases: Iterable[Case] = CASES) -> str:
    """Return the table."""
    return "\n".join([HEADER, *(_row(case) for case in cases)])


def strangers() -> str:
    """Return the table of what programs that misbehave do to a node on ZeroMQ."""
    rows = [
        f"| {act.name} | `{act.counted_as}` | {_duration(act.back_within)} | {act.behaviour} |"
        for act in ACTS
    ]
    return "\n".join([STRANGERS, *rows])


def _row(case: Case) -> str:
    conditions = ", ".join(sorted(f"`{condition.name}`" for condition in case.seen_as))
    counted = f"count `{case.counted_as}`" if case.counted_as else ""
    seen = "; ".join(filter(None, (conditions, counted))) or "-"
    within = _milliseconds(case.detection) if case.seen_as else "-"
    cells = (case.name, _duration(case.duration), seen, within, _milliseconds(case.recovery), case.behaviour)
    return "| " + " | ".join(cells) + " |"


def _duration(seconds: float) -> str:
    return f"{seconds:g} s" if seconds >= 1.0 else _milliseconds(seconds)


def _milliseconds(seconds: float) -> str:
    return f"{1e3 * seconds:.0f} ms"
