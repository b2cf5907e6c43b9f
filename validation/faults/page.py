"""The tables of ``docs/faults.md``, made from the cases themselves."""

import re
from collections.abc import Iterable
from itertools import groupby

from validation.faults.rogue_programs import ACTS
from validation.faults.table import CASES, RECOVERY_S, Case

HEADER = "| fault | seen as | what happens |\n|---|---|---|"

STRANGERS = "| what is done | counted as | what happens |\n|---|---|---|"


LAST_AMOUNT = re.compile(r"^(.*?)([\d.]+ (?:ms|s|N))(\D*)$")


def markdown(cases: Iterable[Case] = CASES) -> str:
    """Return the table; successive cases that differ only in the last amount of their name share a row."""
    return "\n".join([HEADER, *(_row(list(alike)) for _, alike in groupby(cases, _shared))])


def rogue_programs_table() -> str:
    """Return the table of what programs that misbehave do to a node on ZeroMQ."""
    rows = [f"| {act.name} | `{act.counted_as}` | {act.behaviour} |" for act in ACTS]
    return "\n".join([STRANGERS, *rows])


def _row(alike: list[Case]) -> str:
    name = _common_name(alike)
    durations = ", ".join(dict.fromkeys(_duration(case.duration) for case in alike))
    whole = name if " for " in name or durations in name else f"{name}, for {durations}"
    return "| " + " | ".join([whole, *_outcome(alike[0])]) + " |"


def _shared(case: Case) -> tuple[str, ...]:
    return (LAST_AMOUNT.sub(r"\1#\3", case.name), *_outcome(case))


def _common_name(alike: list[Case]) -> str:
    found = [LAST_AMOUNT.match(case.name) for case in alike]
    amounts = ", ".join(match[2] for match in found if match)
    return LAST_AMOUNT.sub(lambda match: match[1] + amounts + match[3], alike[0].name)


def _outcome(case: Case) -> tuple[str, ...]:
    seen = ", ".join(sorted(f"`{condition.name}`" for condition in case.seen_as))
    if seen:
        seen += f" {_milliseconds(case.detection)}"
    counted = f"`{case.counted_as}`" if case.counted_as else ""
    over = "" if case.recovery == RECOVERY_S else f"; over after {_milliseconds(case.recovery)}"
    return ("; ".join(filter(None, (seen, counted))), case.behaviour + over)


def _duration(seconds: float) -> str:
    return f"{seconds:g} s" if seconds >= 1.0 else _milliseconds(seconds)


def _milliseconds(seconds: float) -> str:
    return f"{1e3 * seconds:.0f} ms"
