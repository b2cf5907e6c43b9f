"""``python -m validation.diagnosis_trials``: how often a diagnosis is right, where the truth is known."""

import json
import sys
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from validation.diagnosis_trials import Case, Outcome, draw_cases, run_case, tally_outcomes
from validation.diagnosis_trials.amounts import CATALOGUE_AMOUNTS, UNMODELLED_AMOUNTS
from validation.diagnosis_trials.cases import STYLES
from validation.diagnosis_trials.faults import Faults
from vegrip.cli import run
from vegrip.cli._options import JSON
from vegrip.cli._outputs import FORCE, Outputs
from vegrip.cli._terminal import print_json, printer, progress
from vegrip.cli.trial import GAPS, IN_CONTACT, JITTER, NOISE_STATED, RADIUS_STATED, STYLE, ZERO_SHIFT
from vegrip.errors import RecordingError, UsageError, suggestion
from vegrip.identification.blind import KINDS

KEPT = "trials that are done stay in the file of -o, and the same command goes on with the others"
TRIALS = Annotated[int, typer.Option("--trials", "-n", min=1, help="How many recordings.")]
SEED = Annotated[int, typer.Option("--seed", min=0, help="Of fingertips, noise, protocols.")]
KIND = Annotated[
    list[str] | None,
    typer.Option("--kind", help="none, one, pair or outside; may be repeated. All when not given."),
]
EFFECT = Annotated[
    list[str] | None, typer.Option("--effect", help="Only with this effect hidden; may be repeated.")
]
PLACES = Annotated[int, typer.Option("--places", min=1, help="That each recording presses, in turn.")]
JOBS = Annotated[int, typer.Option("--jobs", "-j", min=1, help="Recordings at a time.")]
OUT = Annotated[
    Path | None,
    typer.Option("-o", "--output", help="File of results, one per line; trials in it are not repeated."),
]


def trial(
    trials: TRIALS = 20,
    seed: SEED = 0,
    kind: KIND = None,
    effect: EFFECT = None,
    places: PLACES = 1,
    style: STYLE = None,
    noise_stated: NOISE_STATED = 1.0,
    radius_stated: RADIUS_STATED = 1.0,
    jitter: JITTER = False,
    gaps: GAPS = False,
    in_contact: IN_CONTACT = False,
    zero_shift: ZERO_SHIFT = False,
    jobs: JOBS = 1,
    output: OUT = None,
    force: FORCE = False,
    as_json: JSON = False,
) -> None:
    """Hide effects in simulated recordings, diagnose each, and count what was named.

    The recordings are those of the virtual bench, which shares no physics code with the model: random
    fingertips, noise and protocols with nothing hidden, one effect, two, or one that is in no catalogue.

    Example: python -m validation.diagnosis_trials -n 2 --kind none -o trials.jsonl

    Two hundred of all kinds, -n 200 --jobs 2, take about an hour.
    """
    for name in kind or ():
        if name not in KINDS:
            raise UsageError(f"there is no kind {name!r}; {suggestion(name, KINDS)}")
    style = style or "laboratory"
    if style not in STYLES:
        raise UsageError(f"there is no style {style!r}; {suggestion(style, STYLES)}")
    faults = Faults(noise_stated, radius_stated, jitter, gaps, in_contact, zero_shift)
    wanted = list(draw_cases(trials, seed, kind or KINDS, _known(effect or []), places, style, faults))
    with Outputs(force=force) as outputs:
        outputs.log(output)
        done = _read(output) if output is not None else {}
        outcomes = [done[case.key] for case in wanted if case.key in done]
        with progress("trials") as report:
            for one in _run([case for case in wanted if case.key not in done], jobs):
                outcomes.append(one)
                outputs.write(output, partial(_append, one))
                right = sum(each.right for each in outcomes)
                report(f"{len(outcomes)} of {len(wanted)}, {right} right; {one.case.key}: {one.answer}")
        told = tally_outcomes(outcomes)
        if as_json:
            print_json(told)
        else:
            _print(told)


def _known(effects: list[str]) -> list[str]:
    for name in effects:
        if name not in CATALOGUE_AMOUNTS and name not in UNMODELLED_AMOUNTS:
            known = [*CATALOGUE_AMOUNTS, *UNMODELLED_AMOUNTS]
            raise UsageError(f"the bench cannot hide {name!r}; {suggestion(name, known, 'it can hide')}")
    return effects


def _read(path: Path) -> dict[str, Outcome]:
    """Return the outcomes of a file by their keys."""
    out: dict[str, Outcome] = {}
    if path.exists():
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            try:
                one = Outcome.of(json.loads(line))
            except (ValueError, TypeError, KeyError, RecursionError) as error:
                raise RecordingError(f"{path}, line {number} is no outcome of a trial") from error
            out[one.case.key] = one
    return out


def _append(one: Outcome, path: Path) -> None:
    with path.open("a", encoding="utf-8") as stream:
        stream.write(json.dumps(one.as_dict()) + "\n")


def _run(cases: list[Case], jobs: int) -> Any:
    """Yield outcomes as they come."""
    if jobs == 1:
        for case in cases:
            yield run_case(case)
        return
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        for done in as_completed([pool.submit(run_case, case) for case in cases]):
            yield done.result()


def _print(told: dict[str, Any]) -> None:
    console = printer()
    table = Table(box=None, padding=(0, 2))
    for heading in ("hidden", "trials", "right", "share", "answers"):
        table.add_column(heading, justify="left" if heading in ("hidden", "answers") else "right")
    rows = {**told["kinds"], **{f"one, {size}": some for size, some in told["sizes"].items()}}
    for name, some in {**rows, **told["effects"]}.items():
        answers = ", ".join(f"{answer} {count}" for answer, count in some["answers"].items())
        table.add_row(name, str(some["trials"]), str(some["right"]), f"{some['share']:.0%}", answers)
    console.print(table)
    floor = told["at_the_floor"]
    console.print(
        f"error within 5 % of the noise after adding what was named: {floor['right']} of {floor['of']}"
    )
    for title, confusion in (
        ("hidden -> said, where it was not the same:", told["confusion"]),
        ("not counted, because the recording does not show what is hidden in it:", told["out_of_sight"]),
    ):
        if confusion:
            console.print(title)
        for hidden, counts in confusion.items():
            others = {text: n for text, n in counts.items() if text != hidden}
            if others:
                console.print(f"  {hidden} -> " + ", ".join(f"{text} ({n})" for text, n in others.items()))


if __name__ == "__main__":
    sys.exit(run(trial, sys.argv[1:], "python -m validation.diagnosis_trials", KEPT))
