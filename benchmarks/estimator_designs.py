"""Designs of the online estimator on the same recordings, and the best possible beside them.

``python -m benchmarks.estimator_designs FOLDER`` reads every recording with its truth in FOLDER and
prints the table of docs/estimator.md; without a folder, three short recordings that it draws.

* ``former``: extended Kalman filter with a motion model, a gate and zeros that walk (``_designs_former.py``)
* ``driven``: extended Kalman filter driven by the measured displacement (``_designs_driven.py``)
* ``regression``: the same by iterated statistical linear regression, memory as a force
* ``product``: :class:`vegrip.estimator.ContactEstimator`
* ``particles``: reference, Rao-Blackwellised particle filter with the same prior (``_designs_particles.py``),
  only with ``--particles``: minutes for each recording
* ``prior``: reference, batch fit of all data up to each look with the same prior (``_designs_reference.py``)
* ``truth``: reference, everything known but the error of the present displacement (``_designs_reference.py``)

All see displacement and normal force, and are told radius, noise and prior. Looks are every tenth sample with
more than 0.3 N. Coverage is of the 95 % intervals; the ratio is the median error over that of ``prior``,
both at those looks at which ``prior`` is fitted. The cost of a reference is that of one look.
"""

import argparse
import math
import sys
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from benchmarks._designs_contact import BIAS, DELTA, LN_K, SPEED, STATES, ZERO
from benchmarks._designs_driven import follow_regression, follow_tangent
from benchmarks._designs_former import follow
from benchmarks._designs_particles import particle_filtered
from benchmarks._designs_recordings import Truthful, drawn, loaded
from benchmarks._designs_reference import with_the_prior, with_the_truth
from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise
from vegrip.messages import NAN, FingertipState
from vegrip.model import ContactModel, paper_model
from vegrip.types import Floats

Rows = NDArray[np.intp]

FELT = 0.3  # [N] of a look
EVERY = 10  # samples from look to look
FITTED = 40  # looks at which the reference with the prior is fitted
INSIDE = 1.959964  # standard deviations of a 95 % interval
FILTERS = {"former": follow, "driven": follow_tangent, "regression": follow_regression}
DESIGNS = (*FILTERS, "product", "prior", "truth")
HEADER = ("recording", "design", "N in 95 %", "x in 95 %", "error of N in std: median, worst",
          "error of x in std: median, worst",
          "N: error ratio", "x: error ratio", "not valid", "us per step")  # fmt: skip


@dataclass(frozen=True)
class Said:
    """What one design said of a recording: N, std, x, std at each of the looks ``at``; NaN is not valid."""

    at: Rows  # indices into the recording
    values: Floats  # (looks, 4)
    step_us: float


def told(recording: Truthful) -> tuple[ContactModel, Floats, Floats]:
    """Return the model with its prior, and means and variances of the state."""
    model, settings = paper_model(recording.tip_radius), EstimatorSettings()
    mean, std = np.zeros(STATES + 1), np.zeros(STATES + 1)
    for j, symbol in enumerate(("K", "p", "c1", "nu1"), start=LN_K):
        known = model.values[symbol]
        mean[j] = math.log(known.value) if symbol in {"K", "nu1"} else known.value
        std[j] = known.std
    std[ZERO], std[BIAS] = settings.offset * model.tip_radius, settings.force_bias * recording.noise[1]
    std[DELTA], std[SPEED] = 0.3 * model.tip_radius, settings.agility * model.tip_radius
    return model, mean, std**2


def filtered(name: str, recording: Truthful, at: Rows) -> Said:
    """Run one of FILTERS over the recording."""
    model, mean, prior = told(recording)
    n = STATES + (name == "former")
    out = np.zeros((recording.t.size, 4))

    def run_over(rows: slice) -> None:
        r = recording
        FILTERS[name](r.t[rows], r.displacement[rows], r.normal_force[rows], model.reference_depth, r.noise,
                      mean[:n].copy(), prior[:n].copy(), out[rows])  # fmt: skip

    run_over(slice(0, 2))  # compiles
    began = perf_counter()
    run_over(slice(None))
    return Said(at, out[at], (perf_counter() - began) / recording.t.size * 1e6)


def estimated(recording: Truthful, at: Rows) -> Said:
    """Run the product over the recording."""
    model, r = told(recording)[0], recording
    noise = SensorNoise(normal_force=float(r.noise[1]), displacement=float(r.noise[0]))
    estimator = ContactEstimator(model, noise)
    samples = zip(r.t.tolist(), r.displacement.tolist(), r.normal_force.tolist(), strict=True)
    states = [
        FingertipState(round(t * 1e9) + 1, "tip", i, F, NAN, NAN, NAN, d, NAN, NAN)
        for i, (t, d, F) in enumerate(samples)
    ]
    looks, rows = set(at.tolist()), []
    began = perf_counter()
    for state in states:
        said = estimator.update(state)
        if state.seq in looks:
            both = (said.normal_force, said.indentation)
            rows.append([v for e in both for v in ((e.value, e.std) if e.valid else (NAN, NAN))])
    return Said(at, np.array(rows), (perf_counter() - began) / len(states) * 1e6)


def fitted(name: str, recording: Truthful, at: Rows, fits: Rows) -> Said:
    """Run one of the references."""
    model, mean, prior = told(recording)
    r, depth = recording, model.reference_depth
    began = perf_counter()
    if name == "particles":
        rows = particle_filtered(
            r.t, r.displacement, r.normal_force, depth, r.noise, mean[:STATES], prior[:STATES]
        )
        return Said(at, rows[at], (perf_counter() - began) / r.t.size * 1e6)
    if name == "truth":
        rows = with_the_truth(
            r.t, r.displacement, r.normal_force, depth, r.noise, r.parameters, r.indentation
        )
        return Said(at, rows[at], (perf_counter() - began) / r.t.size * 1e6)
    rows = with_the_prior(
        r.t, r.displacement, r.normal_force, depth, r.noise, mean[:STATES], prior[:STATES], fits.tolist()
    )
    return Said(fits, rows, (perf_counter() - began) / fits.size * 1e6)


def judge(recording: Truthful, particles: bool = False) -> dict[str, dict[str, float]]:
    """Return the figures of every design on one recording, of the particle filter if it is asked for."""
    felt = recording.true_force > FELT
    at = np.flatnonzero(felt & (np.arange(felt.size) % EVERY == 0))
    fits = at[np.unique(np.linspace(0, at.size - 1, min(FITTED, at.size)).round().astype(int))]
    said = {name: filtered(name, recording, at) for name in FILTERS}
    said["product"] = estimated(recording, at)
    references = ("particles", "prior", "truth") if particles else ("prior", "truth")
    said |= {name: fitted(name, recording, at, fits) for name in references}
    best = median_errors(recording, said["prior"], fits)
    return {name: figures(recording, one, fits, best) for name, one in said.items()}


def errors(recording: Truthful, said: Said) -> Floats:
    """Return the absolute errors of N and x, (looks, 2)."""
    true = np.stack([recording.true_force[said.at], recording.indentation[said.at]], axis=1)
    off: Floats = np.abs(said.values[:, ::2] - true)
    return off


def median_errors(recording: Truthful, said: Said, fits: Rows) -> Floats:
    """Return the median errors of N and x at the looks ``fits``."""
    found: Floats = np.nanmedian(errors(recording, said)[np.isin(said.at, fits)], axis=0)
    return found


def figures(recording: Truthful, said: Said, fits: Rows, best: Floats) -> dict[str, float]:
    """Return one row of the table."""
    valid = np.isfinite(said.values).all(axis=1)
    with np.errstate(divide="ignore"):  # a design may say that it knows exactly
        off = errors(recording, said)[valid] / said.values[valid, 1::2]
    ratio = median_errors(recording, said, fits) / best
    row = {"not_valid": 100.0 * float(np.mean(~valid)), "step_us": said.step_us}
    for j, name in enumerate(("N", "x")):
        row |= {
            f"{name}_inside": 100.0 * float(np.mean(off[:, j] < INSIDE)),
            f"{name}_median": float(np.median(off[:, j])),
            f"{name}_worst": float(np.max(off[:, j])),
            f"{name}_ratio": float(ratio[j]),
        }
    return row


RECORDINGS = 2
SMALLEST = {"RECORDINGS": 1}


def run(recordings: int = 0) -> dict[str, dict[str, float]]:
    """Return the step of every design over the product's, and its figures, on short drawn recordings."""
    judged = [judge(drawn(seed, presses=3)) for seed in range(recordings or RECORDINGS)]
    rows = {}
    for name in DESIGNS:
        mean = {key: float(np.mean([one[name][key] for one in judged])) for key in judged[0][name]}
        ours = float(np.mean([one["product"]["step_us"] for one in judged]))
        times = {"ours_us": ours, "theirs_us": mean["step_us"], "ratio": mean["step_us"] / ours}
        rows[f"estimator_vs_{name}"] = times | mean
    del rows["estimator_vs_product"]
    rows["estimator_designs"] = {"ours_us": ours, "theirs_us": ours, "ratio": 1.0}
    return rows


def line(recording: str, design: str, row: dict[str, float]) -> str:
    """Return one line of the table."""
    cells = [recording, design, f"{row['N_inside']:.0f} %", f"{row['x_inside']:.0f} %"]
    cells += [f"{row[f'{name}_median']:.2f}, {row[f'{name}_worst']:.1f}" for name in ("N", "x")]
    cells += [f"{row[f'{name}_ratio']:.2f}" for name in ("N", "x")]
    cells += [f"{row['not_valid']:.1f} %", f"{row['step_us']:.3g}"]
    return f"| {' | '.join(cells)} |"


def summary(rows: list[dict[str, float]]) -> dict[str, float]:
    """Return the mean of several rows, of the worst errors the worst, of the ratios the geometric mean."""
    found = {}
    for key in rows[0]:
        values = np.array([row[key] for row in rows])
        if key.endswith("_worst"):
            found[key] = float(values.max())
        elif key.endswith("_ratio"):
            found[key] = float(np.exp(np.mean(np.log(values))))
        else:
            found[key] = float(values.mean())
    return found


def main() -> int:
    """Judge all recordings, print the table, then the mean of each style."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("folder", type=Path, nargs="?", help="of recordings with their truth")
    parser.add_argument("--particles", action="store_true", help="with the particle filter, for minutes")
    given = parser.parse_args()
    folder: Path | None = given.folder
    if folder is None:
        recordings = [drawn(seed) for seed in range(3)]
    else:
        recordings = [loaded(path.parent) for path in sorted(folder.glob("*/truth.csv.gz"))]
    if not recordings:
        print(
            f"{folder} has no */truth.csv.gz; name a folder of recordings with their truth", file=sys.stderr
        )
        return 3
    print(f"| {' | '.join(HEADER)} |\n|{'---|' * len(HEADER)}")
    judged: dict[str, list[dict[str, dict[str, float]]]] = {}
    for recording in recordings:
        one = judge(recording, given.particles)
        judged.setdefault(recording.name.partition("-")[0], []).append(one)
        for design in one:
            print(line(recording.name, design, one[design]), flush=True)
    for style, found in [*judged.items(), ("all", [one for many in judged.values() for one in many])]:
        for design in found[0]:
            print(line(f"**{style}**", design, summary([one[design] for one in found])))
    return 0


if __name__ == "__main__":
    sys.exit(main())
