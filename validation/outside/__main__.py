"""``python -m validation.outside``: how far drafts foretell another protocol, where no catalogue has the law.

Each law is hidden in two recordings, one of each protocol. A draft of the one foretells the other, as do the
paper's model and three regressions of what it leaves, all fitted to the same recording. The error is that
against the force without noise. Beside them: how often a draft is written where nothing is hidden.
"""

import json
import sys
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.table import Table

from validation.outside.baselines import BASELINES, regressions
from validation.outside.laws import OUTSIDE_LAWS, OUTSIDE_PROTOCOLS, SECOND_LAWS, record
from vegrip.cli import run
from vegrip.cli._options import JSON
from vegrip.cli._terminal import print_json, printer, progress
from vegrip.errors import UsageError, suggestion
from vegrip.identification.diagnosis.candidate_fit import CandidateFit
from vegrip.identification.draft import Draft, draft
from vegrip.identification.fit.noise import noise_of
from vegrip.identification.fit.preprocess import preprocess
from vegrip.identification.fit.problem import AT, Problem
from vegrip.identification.recording import Recording
from vegrip.types import Floats

HALVED = 0.5
KEPT = "recordings that are done stay in the file of -o, and the same command goes on with the others"


@dataclass(frozen=True)
class Foretold:
    """Errors [N] on the other protocol; that of ``draft`` is the paper's where none is written."""

    law: str
    protocol: str
    seed: int
    errors: Mapping[str, float]
    equation: str
    reason: str
    seconds: float

    @property
    def key(self) -> str:
        return f"{self.law} {self.protocol} {self.seed}"

    def halves(self, name: str) -> bool:
        return self.errors[name] <= HALVED * self.errors["paper"]


def foretell(law: str, protocol: str, seed: int) -> Foretold:
    """Draft from one protocol and foretell the other; where nothing is hidden, no more than draft."""
    began = time.process_time()
    found = draft(record(law, protocol, seed))
    seconds = time.process_time() - began
    equation = found.taken.law.in_words if found.taken else ""
    errors: dict[str, float] = {}
    if law:
        other = next(name for name in OUTSIDE_PROTOCOLS if name != protocol)
        errors = errors_on(found, record(law, other, seed, is_quiet=True))
    return Foretold(law, protocol, seed, errors, equation, found.reason, seconds)


def errors_on(found: Draft, other: Recording) -> dict[str, float]:
    """Return the rms error [N] in contact of each way to foretell ``other``."""
    base = found.base
    problem, table = transferred(base, other)
    truth = other.columns["normal_force"]
    rows = table[:, AT["elastic_force"]] > 0.0

    def error(force: Floats) -> float:
        return float(np.sqrt(np.mean((force - truth)[rows] ** 2)))

    paper = table[:, AT["normal_force"]]
    told = {"paper": error(paper)}
    told["draft"] = (
        error(transferred(found.taken.fitted, other)[1][:, AT["normal_force"]])
        if found.taken
        else told["paper"]
    )
    for name, more in regressions(base.problem, base.problem.table(base.optimum.u)).items():
        told[name] = error(paper + more(problem, table))
    return told


def transferred(fitted: CandidateFit, other: Recording) -> tuple[Problem, Floats]:
    """Return the problem of ``other`` and what a fitted model, with its zeros, foretells (n, quantities)."""
    problem = fitted.problem
    there = Problem(problem.model, preprocess(other, noise_of(other)), symbols=problem.symbols)
    u = fitted.optimum.u.copy()
    is_force = np.array([name.startswith("zero_force") for name in problem.unknowns.names])
    u[is_force] *= problem.load / there.load
    return there, there.table(u)


def trial(
    law: Annotated[
        list[str] | None,
        typer.Option("--law", help="Only this law, of either set; may be repeated. The set when not given."),
    ] = None,
    second: Annotated[bool, typer.Option("--second", help="The second set, six laws.")] = False,
    seeds: Annotated[int, typer.Option("--seeds", min=0, help="How many fingertips for each law.")] = 1,
    nothing: Annotated[
        int, typer.Option("--nothing", min=0, help="How many fingertips with nothing hidden.")
    ] = 12,
    first: Annotated[int, typer.Option("--first", min=0, help="The first seed.")] = 0,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="File of results, one per line; not repeated.")
    ] = None,
    as_json: JSON = False,
) -> None:
    """Hide laws that no grammar holds, draft from one protocol, and foretell another.

    Example: python -m validation.outside --law relay --nothing 0

    All laws and 12 fingertips with nothing hidden take about ten minutes.
    """
    known = [*OUTSIDE_LAWS, *SECOND_LAWS]
    for name in law or ():
        if name not in known:
            raise UsageError(f"there is no law {name!r}; {suggestion(name, known)}")
    numbers, chosen = range(first, first + seeds), law or (SECOND_LAWS if second else OUTSIDE_LAWS)
    wanted = [(one, p, seed) for one in chosen for p in OUTSIDE_PROTOCOLS for seed in numbers]
    wanted += [("", p, seed) for seed in range(first, first + nothing) for p in OUTSIDE_PROTOCOLS]
    done = _read(output)
    outcomes: list[Foretold] = []
    with progress("trials") as report:
        for case in wanted:
            key = "{} {} {}".format(*case)
            one = done[key] if key in done else foretell(*case)
            outcomes.append(one)
            if output is not None and key not in done:
                with output.open("a", encoding="utf-8") as stream:
                    stream.write(json.dumps(asdict(one)) + "\n")
            report(f"{len(outcomes)} of {len(wanted)}: {key}: {one.equation or one.reason}")
    told = tally(outcomes)
    if as_json:
        print_json(told)
    else:
        _print(told, outcomes)


def _read(path: Path | None) -> dict[str, Foretold]:
    if path is None or not path.exists():
        return {}
    done = [Foretold(**json.loads(line)) for line in path.read_text(encoding="utf-8").splitlines()]
    return {one.key: one for one in done}


def tally(outcomes: list[Foretold]) -> dict[str, Any]:
    """Return shares that halve the error, the worst and middle time, and drafts where nothing is hidden."""
    hidden = [one for one in outcomes if one.law]
    empty = [one for one in outcomes if not one.law]
    names = ("draft", *BASELINES)
    return {
        "recordings": len(hidden),
        "written": sum(bool(one.equation) for one in hidden),
        "halved": {name: sum(one.halves(name) for one in hidden) for name in names},
        "draft_is_best": sum(
            one.errors["draft"] <= min(one.errors[name] for name in BASELINES) for one in hidden
        ),
        "nothing_hidden": len(empty),
        "false_drafts": sum(bool(one.equation) for one in empty),
        "seconds": {
            "middle": float(np.median([one.seconds for one in outcomes])),
            "most": max(one.seconds for one in outcomes),
        },
    }


def _print(told: Mapping[str, Any], outcomes: list[Foretold]) -> None:
    console = printer()
    table = Table(box=None, padding=(0, 2))
    names = ("draft", *BASELINES)
    for heading in ("law", "drafted from", "error [mN]", *names, "draft"):
        table.add_column(
            heading,
            justify="left" if heading in ("law", "drafted from") else "right",
            no_wrap=heading in names,
        )
    for one in outcomes:
        if one.law:
            paper = one.errors["paper"]
            parts = [f"{one.errors[name] / paper:.2f}" for name in names]
            table.add_row(
                one.law, one.protocol, f"{1e3 * paper:.1f}", *parts, one.equation or f"none: {one.reason}"
            )
    console.print(table)
    n = told["recordings"]
    console.print(
        f"error of the paper's model at least halved under the other protocol, of {n}: "
        + ", ".join(f"{name} {told['halved'][name]}" for name in names)
    )
    console.print(
        f"drafts written: {told['written']} of {n}; where nothing is hidden: "
        f"{told['false_drafts']} of {told['nothing_hidden']}"
    )
    console.print("processor time of a draft: {middle:.0f} s, at most {most:.0f} s".format(**told["seconds"]))


if __name__ == "__main__":
    sys.exit(run(trial, sys.argv[1:], "python -m validation.outside", KEPT))
