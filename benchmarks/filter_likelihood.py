"""Is the likelihood of the node's own filter a better judge of effects than the whitened residual?

The node's filter carries displacement and speed as noisy states, so its likelihood needs no smoothing of the
motion. Recordings of the virtual bench with one hidden effect of four, or with none, are judged by

* filter: the filter's likelihood, base and candidate each at its own best (MAP), the price of a parameter as
  in the whitened fit,
* whitened: the evidence of the whitened residual (vegrip.identification.fit), the same four candidates, no
  gates,
* diagnose: the whole of ``vegrip diagnose``, all of the catalogue.

``python -m benchmarks.filter_likelihood --seeds 10 --processes 2`` prints one line for each recording and
then how often each is right.
"""

import argparse
import dataclasses
import json
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from scipy.optimize import minimize

from validation.diagnosis_trials import Case, make_recording
from vegrip.contact import limit_surface
from vegrip.effects.contract import Effect
from vegrip.estimator import EstimatorSettings, SensorNoise
from vegrip.estimator.compiled import KERNELS
from vegrip.estimator.initial_state import initial_memory
from vegrip.estimator.layout import Layout, layout_of
from vegrip.identification.diagnosis import diagnose
from vegrip.identification.diagnosis.candidate_fit import (
    CandidateFit,
    evaluate_candidate,
    extend_problem,
    held_out_groups,
)
from vegrip.identification.diagnosis.catalogue import candidates
from vegrip.identification.diagnosis.score_tests import screen_candidates
from vegrip.identification.fit.fitting import base_model
from vegrip.identification.fit.noise import noise_of
from vegrip.identification.fit.preprocess import preprocess
from vegrip.identification.fit.problem import Problem
from vegrip.identification.fit.solve import fit_problem
from vegrip.identification.recording import Recording
from vegrip.model import ContactModel, cache, writer
from vegrip.model.composer import compose
from vegrip.parameters import changed, coordinate
from vegrip.types import Floats

TRIED = ("displacement_backlash", "sensor_lag", "adhesion", "second_relaxation")
PAYS = 5.0  # [nats]
OUTSIDE_THE_FORCE = {"k0", "mu"}


def pressed_only(recording: Recording) -> Recording:
    """Return the episodes in which nothing slides: friction does not show in force and displacement."""
    slips = recording.columns.get("slip", np.zeros(len(recording))) == 1.0
    sliding = np.unique(recording.episode[slips])
    rows = ~np.isin(recording.episode, sliding)
    kept = {name: recording.columns[name] for name in ("displacement", "normal_force")}
    return dataclasses.replace(recording, columns=kept).select(rows)


@lru_cache(maxsize=16)
def compiled(effects: tuple[Effect, ...], layout: Layout) -> ModuleType:
    """Return the filter of these effects with its likelihood, compiled."""
    here = Path(__file__).with_name("filter_likelihood_kernel.py")
    folder = Path(sys.modules[EstimatorSettings.__module__].__file__ or "").parent / "kernels"
    surface = Path(limit_surface.__file__).with_name("fast.py").read_text(encoding="utf-8")
    parts = [layout.constants(), surface]
    parts += [folder.joinpath(f"{name}.py").read_text(encoding="utf-8") for name in KERNELS]
    parts.append(here.read_text(encoding="utf-8"))
    text = writer.write(compose(effects), [e.name for e in effects], parts, ["likelihood"])
    return cache.load(text)


class FilterLikelihood:
    """Cost of a model under its own filter: minus log-likelihood, and the priors of the whitened fit."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        recording, noise = problem.measured.recording, problem.measured.noise
        self.noise = SensorNoise(noise.normal_force, noise.displacement)
        self.first = problem.measured.first
        self.t = recording.t
        self.y = np.stack([recording.columns["displacement"], recording.columns["normal_force"]], axis=1)
        known = {s: changed(v, std=v.std if s in OUTSIDE_THE_FORCE else 0.0)
                 for s, v in problem.model.values.items()}  # fmt: skip
        self.model: ContactModel = dataclasses.replace(problem.model, values=known)
        self.layout = layout_of(self.model)
        self.module = compiled(self.model.effects, self.layout)
        self.blank = initial_memory(self.model, self.layout, self.noise, EstimatorSettings())
        self.place = slice(*self.layout.places()["VALUES"])
        self.calls = 0

    def __call__(self, u: Floats) -> float:
        """Return the cost [nats] at the coordinates ``u``."""
        self.calls += 1
        vector, (zero, bias) = self.problem.parts(u)
        start = self.blank.copy()
        start[self.place] = vector
        out = np.zeros(2)
        y = self.y - np.stack([zero, bias], axis=1)
        self.module.likelihood(start.copy(), start, self.t, self.first, y, out)
        k = self.problem.unknowns
        return -float(out.sum()) + 0.5 * float(np.sum(((u - k.prior) / k.std) ** 2))

    def best(self, fitted: CandidateFit, beside: Floats | None = None) -> tuple[float, Floats]:
        """Return the least cost and where, searched in units of the standard errors of the whitened fit.

        Begins at the whitened optimum, or at the coordinates ``beside`` if they are better.
        """
        k, J = self.problem.unknowns, fitted.optimum.jacobian
        root = np.linalg.inv(np.linalg.cholesky(J.T @ J + np.diag(k.std**-2.0))).T
        starts = [fitted.optimum.u, *([] if beside is None else [beside])]
        u = min(starts, key=self)

        def at(x: Floats) -> Floats:
            return np.asarray(np.clip(u + root @ x, k.low, k.high))

        def cost(x: Floats) -> float:
            return self(at(x))

        nowhere = np.zeros(u.size)
        options: Any = {"maxiter": 15, "maxfun": 30 * (u.size + 1), "eps": 0.02}
        found = minimize(cost, nowhere, method="L-BFGS-B", options=options)
        return min(((cost(x), at(x)) for x in (nowhere, found.x)), key=lambda pair: pair[0])


def without_effect(problem: Problem, base: Problem, u: Floats) -> Floats:
    """Return the coordinates ``u`` of ``base`` as those of ``problem``, whose effect does nothing there."""
    k, known = problem.unknowns, dict(zip(base.unknowns.names, u, strict=True))
    declared = problem.model.parameters
    out = k.start.copy()
    for j, name in enumerate(k.names):
        if name in known:
            out[j] = known[name]
        else:
            _, parameter = declared[name]
            if parameter.null is not None:
                out[j] = coordinate(parameter, parameter.null)
    return np.clip(out, k.low, k.high)


def price(fitted: CandidateFit) -> float:
    """Return what the parameters cost [nats]: prior widths over posterior ones."""
    s, J = fitted.problem.unknowns.std, fitted.optimum.jacobian
    A = J.T @ J + np.diag(s**-2.0)
    return float(np.sum(np.log(s))) + 0.5 * float(np.linalg.slogdet(A)[1])


def judge(case: Case) -> dict[str, Any]:
    """Judge one recording in the three ways."""
    recording = pressed_only(make_recording(case))
    measured = preprocess(recording, noise_of(recording))
    problem = Problem(base_model(recording), measured)
    groups = held_out_groups(problem)
    base = evaluate_candidate(problem, fit_problem(problem), groups)
    began = time.process_time()
    judge_base = FilterLikelihood(base.problem)
    cost_base, u_base = judge_base.best(base)
    by_filter, by_white, calls = {}, {}, judge_base.calls
    wanted = [c for c in candidates(problem.model, measured)[0] if c.name in TRIED]
    for hint in screen_candidates(problem, base.optimum, wanted, threads=1):
        new = extend_problem(base, hint, groups)
        by_white[hint.candidate.name] = new.evidence - base.evidence
        filtered = FilterLikelihood(new.problem)
        cost, _ = filtered.best(new, without_effect(new.problem, problem, u_base))
        gain = cost_base - cost - price(new) + price(base)
        by_filter[hint.candidate.name] = gain
        calls += filtered.calls
    spent = time.process_time() - began
    began = time.process_time()
    found = diagnose(recording, threads=1)
    told = "+".join(found.named) or "|".join(n for g in found.indistinguishable for n in g) or found.verdict
    return {
        "hidden": "+".join(case.hidden) or "nothing", "size": case.size, "seed": case.seed,
        "rows": len(recording),
        "filter": name_of(by_filter), "whitened": name_of(by_white), "diagnose": told,
        "by_filter": by_filter, "by_white": by_white, "calls": calls,
        "seconds": spent, "seconds_diagnose": time.process_time() - began,
    }  # fmt: skip


def name_of(gains: dict[str, float]) -> str:
    """Return the candidate with the most evidence; none if that does not pay."""
    best = max(gains, key=lambda name: gains[name], default="nothing")
    return best if gains and gains[best] > PAYS else "nothing"


def main() -> int:
    """Judge all recordings, print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else None)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--processes", type=int, default=1)
    given = parser.parse_args()
    cases = [Case((), "strong", seed) for seed in range(given.seeds)]
    cases += [Case((TRIED[i % 4],), "weak" if i % 8 > 3 else "strong", i) for i in range(given.seeds)]
    rows = []
    with ProcessPoolExecutor(given.processes) as pool:
        for row in pool.map(judge, cases):
            rows.append(row)
            print(json.dumps(row), flush=True)
    print(f"\n| judged by | false alarms of {given.seeds} | right names of {given.seeds} |\n|---|---|---|")
    for judged_by in ("filter", "whitened", "diagnose"):
        alarms = sum(r[judged_by] not in ("nothing", "adequate") for r in rows if r["hidden"] == "nothing")
        right = sum(r["hidden"] in r[judged_by].split("|") for r in rows if r["hidden"] != "nothing")
        print(f"| {judged_by} | {alarms} | {right} |")
    print(f"\nCPU time: filter and whitened {sum(r['seconds'] for r in rows):.0f} s, "
          f"diagnose {sum(r['seconds_diagnose'] for r in rows):.0f} s")  # fmt: skip
    return 0


if __name__ == "__main__":
    sys.exit(main())
