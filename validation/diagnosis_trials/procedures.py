"""What other procedures answer to blind recordings, beside the diagnosis.

``python -m validation.diagnosis_trials.procedures blind -o answers`` writes a file of answers of each, which
``vegrip trial --score`` compares with the truth. All begin with the paper's model fitted
to every row; those that name effects have the same catalogue, the same screen and the same refits.

* **BIC**: forward selection; the effect with the least ``2 cost + p ln n`` is added while that falls.
* **LISDD** (arXiv 2606.23215): the model is fitted in its clean range alone and held there; what explains
  most of held-out rows is taken, one effect, if an F-test on rows that chose nothing passes 1 %.
* **SINDy**: a sparse sum of products of the inputs, fitted to what is left; it names no effect. Something is
  seen where it takes a twentieth of the squares that are left of held-out episodes.
* **GP**: the same with a Gaussian process.
* **nothing** and **everything**: what it is worth to name no effect, or all of them.
"""

import json
import math
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from numpy.typing import NDArray
from scipy.stats import f as f_distribution

from validation.diagnosis_trials.amounts import CATALOGUE_AMOUNTS
from validation.outside.baselines import BASELINES, inputs
from vegrip.cli import run
from vegrip.cli._terminal import json_text, progress
from vegrip.errors import UsageError, suggestion
from vegrip.identification.blind import Answer
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
from vegrip.identification.diagnosis.score_tests import Hint, candidates, screen_candidates
from vegrip.identification.diagnosis.search import shortlist
from vegrip.identification.fit import Fit, fit
from vegrip.identification.fit.problem import AT
from vegrip.identification.recording import read_recording
from vegrip.jsonable import jsonable
from vegrip.types import Floats
from vegrip.whole_file import write_whole

KEPT = "what is done stays in the files of -o, and the same command goes on with the others"
Found = tuple[tuple[str, ...], CandidateFit]
MOST = 4  # effects that are added
F_SIZE = 0.01  # of the F-test
SEEN_SHARE = 0.05  # of the squares of held-out episodes


def of_diagnosis(start: Fit) -> Answer:
    found = diagnose(start.problem.measured.recording, threads=1)
    left = found.unexplained
    sets = tuple(tuple(one) for one in found.indistinguishable) if found.verdict == "ambiguous" else ()
    exponent = found.model.values["p"].value
    return Answer(found.verdict, tuple(found.named), sets, left.variable if left else "", exponent)


def _named(names: tuple[str, ...], exponent: float) -> Answer:
    return Answer("named" if names else "adequate", names, exponent=exponent)


def of_bic(start: Fit) -> Answer:
    names, last = forward_selection(start)
    return _named(names, last.value("p"))


def forward_selection(start: Fit) -> Found:
    """Return what BIC adds to a model, and the model with it."""
    groups = held_out_groups(start.problem)
    last = evaluate_candidate(start.problem, start.optimum, groups)
    names: tuple[str, ...] = ()
    while len(names) < MOST:
        tried = []
        for hint in _hints(last, names):
            new = evaluate_candidate(*extended(last, hint), groups)
            tried.append((_bic(new), new, hint.candidate.name))
        best = min(tried, key=lambda one: one[0], default=None)
        if best is None or best[0] >= _bic(last):
            break
        last, names = best[1], (*names, best[2])
    return names, last


def _hints(base: CandidateFit, names: tuple[str, ...] = ()) -> list[Hint]:
    possible, _ = candidates(base.problem.model, base.problem.measured)
    possible = [one for one in possible if one.name not in names]
    return shortlist(screen_candidates(base.problem, base.optimum, possible, 1))


def _bic(one: CandidateFit) -> float:
    rows = int(np.count_nonzero(one.problem.counted))
    squares = float(np.sum(one.optimum.residual[one.problem.counted] ** 2))
    return squares + one.optimum.u.size * math.log(rows)


def of_lisdd(start: Fit) -> Answer:
    names, held = clean_selection(start)
    if held is None:
        return Answer("unexplained", exponent=start.model.values["p"].value)
    return _named(names, held.value("p"))


def clean_selection(start: Fit) -> tuple[tuple[str, ...], CandidateFit | None]:
    """Return what LISDD adds to the model of the clean range, and the model with it; None without a range."""
    base = evaluate_candidate(start.problem, start.optimum, held_out_groups(start.problem))
    clean = find_clean(base)
    if clean is None:
        return (), None
    k = base.problem.unknowns
    told = [clean.parameters[name] for name in k.names]
    held = _held_at(base, np.array([math.log(x) if log else x for x, log in zip(told, k.log, strict=True)]))
    left, counted = held.optimum.residual, np.flatnonzero(base.problem.counted)
    part = (np.arange(counted.size) * 30 // counted.size) % 3  # blocks in turn: to fit, to choose, to certify
    fitting, choosing, testing = (counted[part == which] for which in range(3))

    def amount(s: Floats) -> float:
        """Return that of the rows that are fitted."""
        power = float(s[fitting] @ s[fitting])
        return float(s[fitting] @ left[fitting]) / power if power > 0.0 else 0.0

    def squares(s: Floats, rows: NDArray[np.int64]) -> tuple[float, float]:
        """Of ``rows``, before and after ``s``."""
        return float(np.sum(left[rows] ** 2)), float(np.sum((left - amount(s) * s)[rows] ** 2))

    best: tuple[float, Floats, Hint] | None = None
    for hint in _hints(base):
        problem = candidate_problem(held, hint.candidate)
        s = left - problem.residual(candidate_start(problem, held, hint, 1.0))
        before, after = squares(s, choosing)
        if after < before and (best is None or after < best[0]):
            best = after, s, hint
    if best is None:
        return (), held
    before, after = squares(best[1], testing)
    ratio = (before - after) / (after / (testing.size - 1))
    if float(f_distribution.sf(ratio, 1, testing.size - 1)) >= F_SIZE:
        return (), held
    hint = best[2]
    problem = candidate_problem(held, hint.candidate)
    added = replace(held, problem=problem)
    return (hint.candidate.name,), _held_at(added, candidate_start(problem, held, hint, amount(best[1])))


def _held_at(base: CandidateFit, u: Floats) -> CandidateFit:
    residual = base.problem.residual(u)
    optimum = replace(base.optimum, u=u, residual=residual, jacobian=base.problem.jacobian(u, residual))
    return replace(base, optimum=optimum)


def of_regression(name: str, start: Fit) -> Answer:
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
    return Answer("unexplained" if is_seen else "adequate", exponent=start.model.values["p"].value)


PROCEDURES: dict[str, Callable[[Fit], Answer]] = {
    "vegrip": of_diagnosis,
    "BIC": of_bic,
    "LISDD": of_lisdd,
    "SINDy": partial(of_regression, "sparse"),
    "GP": partial(of_regression, "gp"),
    "nothing": lambda _: Answer("adequate"),
    "everything": lambda _: Answer("named", tuple(sorted(CATALOGUE_AMOUNTS))),
}


def answers(folder: Path, names: Sequence[str] = tuple(PROCEDURES)) -> dict[str, dict[str, Any]]:
    """Return by procedure what it says of a recording."""
    start = fit(read_recording(folder, announce=False))
    out: dict[str, dict[str, Any]] = {}
    for name in names:
        began = time.process_time()
        said = asdict(PROCEDURES[name](start)) | {"seconds": time.process_time() - began}
        out[name] = {key: value for key, value in jsonable(said).items() if value is not None}
    return out


def procedures(
    blind: Annotated[Path, typer.Argument(help="Folder of blind recordings, of vegrip trial.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder of answers, one file for each.")],
    only: Annotated[
        list[str] | None, typer.Option("--only", help="This one; may be repeated. All when not given.")
    ] = None,
    jobs: Annotated[int, typer.Option("--jobs", "-j", min=1, help="Recordings at a time.")] = 1,
) -> None:
    """Let other procedures judge blind recordings beside the diagnosis.

    Example: python -m validation.diagnosis_trials.procedures blind -o answers

    Sixty take half an hour.
    """
    names = only or list(PROCEDURES)
    for name in names:
        if name not in PROCEDURES:
            raise UsageError(f"there is no procedure {name!r}; {suggestion(name, PROCEDURES)}")
    output.mkdir(parents=True, exist_ok=True)
    files = {name: output / f"{name}.json" for name in names}
    said = {n: json.loads(path.read_text("utf-8")) if path.exists() else {} for n, path in files.items()}
    folders = sorted(path.parent for path in blind.glob("*/recording.toml"))
    left = [path for path in folders if any(path.name not in told for told in said.values())]
    with progress("procedures") as report, ProcessPoolExecutor(jobs, get_context("spawn")) as pool:
        for path, one in zip(left, pool.map(partial(answers, names=names), left), strict=True):
            for name, told in one.items():
                said[name][path.name] = told
                write_whole(files[name], json_text(said[name]) + "\n")
            verdicts = [f"{name} {told['verdict']}" for name, told in one.items()]
            report(f"{path.name}: {', '.join(verdicts)}")


if __name__ == "__main__":
    sys.exit(run(procedures, sys.argv[1:], "python -m validation.diagnosis_trials.procedures", KEPT))
