"""What other procedures say of the recordings of the trials, beside the diagnosis.

``python -m validation.diagnosis_trials.procedures -n 20 --seed 31``. All begin with the paper's model fitted
to every row; those that name effects have the same catalogue, the same screen and the same refits.

* **BIC**: forward selection; the effect with the least ``2 cost + p ln n`` is added while that falls.
* **LISDD** (arXiv 2606.23215): the model is fitted in its clean range alone and held there; what explains
  most of held-out rows is taken, one effect, if an F-test on rows that chose nothing passes 1 %.
* **SINDy**: a sparse sum of products of the inputs, fitted to what is left; it names no effect. Something is
  seen where it takes a twentieth of the squares that are left of held-out episodes.
* **GP**: the same with a Gaussian process.
"""

import json
import math
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from numpy.typing import NDArray
from rich.table import Table
from scipy.stats import f as f_distribution

from validation.diagnosis_trials.cases import Case, draw_cases, fingertip, make_recording
from validation.outside.baselines import BASELINES, inputs
from vegrip.cli import run
from vegrip.cli._options import JSON
from vegrip.cli._terminal import print_json, printer, progress
from vegrip.identification.diagnosis import diagnose
from vegrip.identification.diagnosis.candidate_fit import (
    CandidateFit,
    evaluate_candidate,
    extended,
    held_out_groups,
)
from vegrip.identification.diagnosis.candidate_fit import _problem as candidate_problem
from vegrip.identification.diagnosis.candidate_fit import _start as candidate_start
from vegrip.identification.diagnosis.clean import find_clean
from vegrip.identification.diagnosis.score_tests import candidates, screen_candidates
from vegrip.identification.diagnosis.search import shortlist
from vegrip.identification.fit import Fit, fit
from vegrip.identification.fit.problem import AT
from vegrip.types import Floats

KEPT = "what is done stays in the file of -o, and the same command goes on with the others"
MOST = 4  # effects that are added
F_SIZE = 0.01  # of the F-test
SEEN_SHARE = 0.05  # of the squares of held-out episodes


@dataclass(frozen=True)
class Said:
    """What a procedure says of a recording."""

    sees: bool  # anything
    names: tuple[str, ...]
    exponent: float  # of the elastic law of the model that it ends with
    seconds: float = 0.0


def of_diagnosis(_case: Case, start: Fit) -> Said:
    found = diagnose(start.problem.measured.recording, threads=1)
    return Said(found.verdict != "adequate", tuple(found.named), found.model.values["p"].value)


def of_bic(_case: Case, start: Fit) -> Said:
    groups = held_out_groups(start.problem)
    last = evaluate_candidate(start.problem, start.optimum, groups)
    names: list[str] = []
    while len(names) < MOST:
        best: tuple[float, CandidateFit, str] | None = None
        for hint in _hints(last, names):
            problem, optimum = extended(last, hint)
            new = evaluate_candidate(problem, optimum, groups)
            if best is None or _bic(new) < best[0]:
                best = (_bic(new), new, hint.candidate.name)
        if best is None or best[0] >= _bic(last):
            break
        last = best[1]
        names.append(best[2])
    return Said(bool(names), tuple(names), last.value("p"))


def _hints(base: CandidateFit, names: list[str]) -> list[Any]:
    possible, _ = candidates(base.problem.model, base.problem.measured)
    possible = [one for one in possible if one.name not in names]
    return shortlist(screen_candidates(base.problem, base.optimum, possible, 1))


def _bic(one: CandidateFit) -> float:
    rows = int(np.count_nonzero(one.problem.counted))
    squares = float(np.sum(one.optimum.residual[one.problem.counted] ** 2))
    return squares + one.optimum.u.size * math.log(rows)


def of_lisdd(_case: Case, start: Fit) -> Said:
    base = evaluate_candidate(start.problem, start.optimum, held_out_groups(start.problem))
    clean = find_clean(base)
    if clean is None:
        return Said(True, (), base.value("p"))
    k = base.problem.unknowns
    told = [clean.parameters[name] for name in k.names]
    held = _held_at(base, np.array([math.log(x) if log else x for x, log in zip(told, k.log, strict=True)]))
    left, counted = held.optimum.residual, np.flatnonzero(base.problem.counted)
    part = (np.arange(counted.size) * 30 // counted.size) % 3  # blocks in turn: to fit, to choose, to certify
    fitting, choosing, testing = (counted[part == which] for which in range(3))

    def squares(s: Floats, rows: NDArray[np.int64]) -> tuple[float, float]:
        """Of ``rows``, before and after ``s``, whose amount is that of the rows that are fitted."""
        power = float(s[fitting] @ s[fitting])
        amount = float(s[fitting] @ left[fitting]) / power if power > 0.0 else 0.0
        return float(np.sum(left[rows] ** 2)), float(np.sum((left - amount * s)[rows] ** 2))

    best: tuple[float, Floats, str] | None = None
    for hint in _hints(base, []):
        problem = candidate_problem(held, hint.candidate)
        s = left - problem.residual(candidate_start(problem, held, hint, 1.0))
        before, after = squares(s, choosing)
        if after < before and (best is None or after < best[0]):
            best = after, s, hint.candidate.name
    if best is None:
        return Said(False, (), clean.parameters["p"])
    before, after = squares(best[1], testing)
    ratio = (before - after) / (after / (testing.size - 1))
    is_certain = float(f_distribution.sf(ratio, 1, testing.size - 1)) < F_SIZE
    return Said(is_certain, (best[2],) * is_certain, clean.parameters["p"])


def _held_at(base: CandidateFit, u: Floats) -> CandidateFit:
    optimum = replace(base.optimum, u=u, residual=base.problem.residual(u))
    return replace(base, optimum=optimum)


def of_regression(name: str, _case: Case, start: Fit) -> Said:
    problem, table = start.problem, start.problem.table(start.optimum.u)
    touching = (table[:, AT["elastic_force"]] > 0.0) & problem.used & np.isfinite(problem.measured.force)
    left = (problem.measured.force - table[:, AT["normal_force"]])[touching]
    known, episodes = inputs(problem, table)[touching], problem.episodes[touching]
    after = 0.0
    for fold in range(2):
        out = episodes % 2 == fold
        more = BASELINES[name](known[~out], left[~out], episodes[~out].astype(np.float64))
        after += float(np.sum((left[out] - more(known[out])) ** 2))
    is_seen = after < (1.0 - SEEN_SHARE) * float(left @ left)
    return Said(is_seen, (), start.model.values["p"].value)


PROCEDURES: dict[str, Callable[[Case, Fit], Said]] = {
    "vegrip": of_diagnosis,
    "BIC": of_bic,
    "LISDD": of_lisdd,
    "SINDy": partial(of_regression, "sparse"),
    "GP": partial(of_regression, "gp"),
}
NAMELESS = ("SINDy", "GP")  # procedures


def judge(case: Case) -> dict[str, dict[str, Any]]:
    """Return by procedure what it said of a case, and whether that is right."""
    recording, true = make_recording(case), fingertip(np.random.default_rng([case.seed, 7])).exponent
    start = fit(recording)
    out: dict[str, dict[str, Any]] = {}
    for name, procedure in PROCEDURES.items():
        began = time.process_time()
        said = procedure(case, start)
        hidden = case.hidden if case.kind in ("one", "pair") else ()
        is_right = said.sees == bool(case.hidden)
        if name not in NAMELESS:
            is_right = is_right and set(said.names) == set(hidden)
        out[name] = {
            "hidden": list(case.hidden), "kind": case.kind, "names": list(said.names), "sees": said.sees,
            "right": is_right, "false": sorted(set(said.names) - set(hidden)),
            "bias": abs(said.exponent - true), "seconds": time.process_time() - began,
        }  # fmt: skip
    return out


def tally(done: list[dict[str, dict[str, Any]]]) -> dict[str, dict[str, Any]]:
    """Return by procedure how often it was right, and how wrong it was."""
    told = {}
    for name in PROCEDURES:
        some = [one[name] for one in done]
        kinds = {
            kind: [one for one in some if one["kind"] == kind] for kind in ("none", "one", "pair", "outside")
        }
        told[name] = {
            **{kind: f"{sum(one['right'] for one in each)} of {len(each)}" for kind, each in kinds.items()},
            "false": sum(bool(one["false"]) for one in some),
            "bias": float(np.mean([one["bias"] for one in some])),
            "seconds": float(np.mean([one["seconds"] for one in some])),
        }
    return told


def procedures(
    trials: Annotated[int, typer.Option("--trials", "-n", min=1, help="How many recordings.")] = 20,
    seed: Annotated[int, typer.Option(min=0, help="Of fingertips, noise, protocols.")] = 31,
    jobs: Annotated[int, typer.Option("--jobs", "-j", min=1, help="Recordings at a time.")] = 1,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="File of results, one per line.")
    ] = None,
    as_json: JSON = False,
) -> None:
    """Let other procedures judge the recordings of the trials beside the diagnosis.

    Example: python -m validation.diagnosis_trials.procedures -n 2

    Twenty take half an hour.
    """
    lines = output.read_text(encoding="utf-8").splitlines() if output is not None and output.exists() else []
    known = {one.pop("case"): one for one in map(json.loads, lines)}
    cases = list(draw_cases(trials, seed))
    left = [case for case in cases if case.key not in known]
    with progress("procedures") as report, ProcessPoolExecutor(jobs, get_context("spawn")) as pool:
        for case, one in zip(left, pool.map(judge, left), strict=True):
            known[case.key] = one
            right = [name for name, said in one.items() if said["right"]]
            report(f"{len(known)} of {trials}; {case.key}: right are {', '.join(right) or 'none'}")
            if output is not None:
                with output.open("a", encoding="utf-8") as stream:
                    stream.write(json.dumps({"case": case.key, **one}) + "\n")
    done = [known[case.key] for case in cases]
    told = tally(done)
    if as_json:
        print_json(told)
        return
    table = Table(box=None, padding=(0, 2))
    for heading in ("procedure", "none", "one", "pair", "outside", "false names", "bias of p", "seconds"):
        table.add_column(heading)
    for name, row in told.items():
        figures = (f"{row['false']}", f"{row['bias']:.3f}", f"{row['seconds']:.1f}")
        table.add_row(name, *(row[kind] for kind in ("none", "one", "pair", "outside")), *figures)
    printer().print(table)


if __name__ == "__main__":
    sys.exit(run(procedures, sys.argv[1:], "python -m validation.diagnosis_trials.procedures", KEPT))
