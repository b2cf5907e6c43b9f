"""``python -m validation.measured``: what is said of measured recordings, and what that foretells of others.

Each case is diagnosed, and the model that it ends with foretells recordings that no fit has seen: another
speed, force, place or day. Only the zeros of the sensors, and the stiffness of another place, are fitted
there. Beside it the paper's model, what BIC and LISDD make of it, and regressions of what it leaves of the
recordings that were fitted.
"""

import json
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, Final

import numpy as np
import typer

from validation.diagnosis_trials.procedures import clean_selection, forward_selection
from validation.measured.cases import CASES, FURTHER, MAPS, Case, data_folder, tables
from validation.measured.worked import filled
from validation.outside.baselines import BASELINES, regressions
from vegrip.cli import run
from vegrip.cli._terminal import progress
from vegrip.errors import InputError, UsageError, suggestion
from vegrip.identification.diagnosis import diagnose
from vegrip.identification.fit.fitting import solve
from vegrip.identification.fit.noise import Noise, noise_of
from vegrip.identification.fit.problem import AT, Problem, Zeros
from vegrip.identification.fit.result import fit_of
from vegrip.identification.recording import Recording
from vegrip.identification.recording.column_map import read_column_map
from vegrip.identification.recording.data import join_recordings, select_episodes
from vegrip.identification.recording.import_csv import import_csv
from vegrip.identification.recording.units import parse_length
from vegrip.model import ContactModel
from vegrip.types import Floats

KEPT = "cases that are done stay in the file of -o, and the same command goes on with the others"
SELECTIONS: Final = {"BIC": forward_selection, "LISDD": clean_selection}
WAYS = ("paper", "found", *SELECTIONS, *BASELINES)


@dataclass(frozen=True)
class Verdict:
    """What is said of a case, and the errors of what it foretells [share of the peak force]."""

    case: str
    verdict: str
    named: list[str]
    sets: list[list[str]]
    accepted: list[str]
    suggested: list[str]  # what explains the recording, and is proven by nothing in it
    doubts: list[str]
    before: float  # error over what was asked, of the recording that was fitted
    after: float
    heldout: Mapping[str, float]
    others: Mapping[str, list[str]]  # what other procedures name
    left: str  # what the rest depends on; empty where nothing is left


def judge(case: Case, data: Path) -> Verdict:
    """Diagnose a case and foretell what was held out of it."""
    options = iter(case.options)
    given = {name: next(options) if name == "--tolerance" else "" for name in options}
    zeros: Zeros = "episode" if "--zeros-each-episode" in given else "recording"
    laws: Zeros = "episode" if case.scaled else "recording"
    tolerance = float(given.get("--tolerance", 0.0))
    train = read(case, data, 0)
    found = diagnose(train, noise=noise_of(train).tolerant(tolerance), zeros=zeros, laws=laws)
    start = found.start
    selected = {name: select(start) for name, select in SELECTIONS.items()}
    heldout: dict[str, float] = {}
    if case.heldout:
        other = read(case, data, 1)
        noise = noise_of(other).tolerant(tolerance)
        models = {"paper": start.model, "found": found.model} | {
            name: fit_of(last.problem, last.optimum).model for name, (_, last) in selected.items() if last
        }
        told = {
            name: foretold(other, model, noise, zeros, is_scaled=case.scaled)
            for name, model in models.items()
        }
        heldout = {
            name: error(problem, table[:, AT["normal_force"]]) for name, (problem, table) in told.items()
        }
        problem, table = told["paper"]
        for name, more in regressions(start.problem, start.problem.table(start.optimum.u)).items():
            heldout[name] = error(problem, table[:, AT["normal_force"]] + more(problem, table))
    errors = found.error
    accepted = [one.candidate.name for one in found.search.accepted]
    return Verdict(
        case.name,
        found.verdict,
        found.named,
        found.indistinguishable,
        accepted,
        accepted if found.unproven else found.suggested,
        [doubt.text for doubt in found.doubts],
        errors["before"],
        errors["after"],
        heldout,
        {name: list(names) for name, (names, last) in selected.items() if last},
        found.unexplained.variable if found.unexplained else "",
    )


def read(case: Case, data: Path, which: int) -> Recording:
    """Return the recording that is fitted, 0, or held out, 1."""
    chart = read_column_map(MAPS / f"{case.column_map}.toml") if case.column_map else None
    radius = parse_length(case.radius, "radius") if case.radius else float("nan")
    with tempfile.TemporaryDirectory() as scratch:
        paths = tables(case, data, Path(scratch) / "rows", which)
        parts = [import_csv(path, chart, radius=radius, is_step=chart is None) for path in paths]
    whole = parts[0] if len(parts) == 1 else join_recordings(parts, case.name)
    return select_episodes(whole, only=case.episodes[which])


def foretold(
    other: Recording, model: ContactModel, noise: Noise, zeros: Zeros, *, is_scaled: bool
) -> tuple[Problem, Floats]:
    """Return the problem of ``other`` and what a model foretells of it (n, quantities)."""
    firm = replace(model, values={**model.values, "K": replace(model.values["K"], std=float(is_scaled))})
    problem, best = solve(
        other,
        firm,
        noise=noise,
        zeros=zeros,
        report=lambda _: None,
        laws="episode" if is_scaled else "recording",
        symbols=("K",) if is_scaled else (),
    )
    return problem, problem.table(best.u)


def error(problem: Problem, force: Floats) -> float:
    """Return the rms error of the force in contact, as a share of the peak."""
    seen = problem.measured.force
    rows = problem.used & (problem.stiffness > 0.0)
    return float(np.sqrt(np.mean((force - seen)[rows] ** 2)) / np.nanmax(np.abs(seen)))


def measured(
    data: Annotated[str, typer.Argument(help="Folder of the measured recordings; VEGRIP_DATA.")] = "",
    only: Annotated[
        list[str] | None, typer.Option("--case", help="Only this one; may be repeated. All when not given.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="File of results, one per line; not repeated.")
    ] = None,
    page: Annotated[Path | None, typer.Option(help="Page whose table to replace.")] = None,
) -> None:
    """Diagnose measured recordings, foretell those held out, and print all that is said of them.

    Example: python -m validation.measured --case muscle

    All cases take a quarter of an hour; the recordings are no part of the project.
    """
    known = {case.name: case for case in (*CASES, *FURTHER)}
    for name in only or ():
        if name not in known:
            raise UsageError(f"there is no case {name!r}; {suggestion(name, known)}")
    folder = data_folder(data)
    if not folder.is_dir():
        raise InputError(f"there are no measured recordings in {folder}; set VEGRIP_DATA")
    for case in (known[name] for name in only or known):
        for path in (folder / file for file in (*case.train, *case.heldout)):
            if not path.exists():
                raise InputError(f"{case.name}: there is no file {path}, of {case.source}")
    lines = output.read_text(encoding="utf-8").splitlines() if output is not None and output.exists() else []
    done = {one.case: one for one in (Verdict(**json.loads(line)) for line in lines)}
    with progress("measured") as report:
        for name in only or known:
            if name in done:
                continue
            done[name] = one = judge(known[name], folder)
            report(f"{name}: {one.verdict}")
            if output is not None:
                with output.open("a", encoding="utf-8") as stream:
                    stream.write(json.dumps(asdict(one)) + "\n")
    table = "\n".join([*HEAD, *(row(known[name], done[name]) for name in only or known)])
    if page is not None:
        page.write_text(filled(page.read_text(encoding="utf-8"), {"measured": table}), encoding="utf-8")
    sys.stdout.write(f"{table}\n")


COLUMNS = (
    "case", "known", "verdict", "fitted", "held out: paper's model", "what was found", *SELECTIONS, "curve",
    "sparse", "GP",
)  # fmt: skip
HEAD = (f"| {' | '.join(COLUMNS)} |", "|---" * len(COLUMNS) + "|")


def row(case: Case, one: Verdict) -> str:
    """Return a case as a row of Markdown."""
    is_unexplained = one.verdict == "unexplained"
    parts = [*one.named, *([] if is_unexplained else [" or ".join(names) for names in one.sets])]
    if one.suggested:
        parts.append(f"suggested: {', '.join(one.suggested)}")
    elif is_unexplained and one.accepted:
        parts.append(f"tried: {', '.join(one.accepted)}")
    said = ", ".join(parts)
    over = f" over {one.left.replace('_', ' ')}" if is_unexplained and one.left else ""
    errors = [f"{100.0 * one.heldout[way]:.1f} %" if way in one.heldout else "" for way in WAYS]
    errors = [
        f"{said} {', '.join(one.others.get(way, ()))}".strip() for way, said in zip(WAYS, errors, strict=True)
    ]
    cells = (
        f"{case.title}; {case.source}, {case.licence}", case.known, f"**{one.verdict}**{over} {said}".strip(),
        f"{one.before:.2f} -> {one.after:.2f}", *errors,
    )  # fmt: skip
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    sys.exit(run(measured, sys.argv[1:], "python -m validation.measured", KEPT))
