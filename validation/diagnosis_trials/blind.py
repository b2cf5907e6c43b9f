"""Blind recordings for others to diagnose, and the truth of them in a file apart.

What is hidden, and in which order, is drawn from the seed; who does not know that learns nothing from the
numbers of the recordings. The folder has the digest of the truth, which cannot be changed afterwards.
"""

import hashlib
import json
from collections.abc import Collection, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from validation.diagnosis_trials.cases import STYLES, Case, draw_cases, fingertip, make_recording
from validation.diagnosis_trials.faults import NO_FAULTS, Faults
from validation.diagnosis_trials.unmodelled import UNMODELLED
from validation.diagnosis_trials.visible import VISIBLE_NATS, remaining_evidence
from vegrip.effects import BUILT_IN, effect
from vegrip.identification.blind import Truth
from vegrip.identification.fit.solve import Report
from vegrip.identification.recording import write_recording
from vegrip.model import BASE
from vegrip.whole_file import write_whole

DRAWN_FROM = 10  # cases for each that is taken
VARIABLES = sorted({name for kind in UNMODELLED.values() for name in kind.shows})
README = """# Blind recordings

{count} recordings of simulated fingertips, each a folder with `recording.toml` and `recording.csv.gz` (SI;
the noise of each sensor is stated). In each, nothing, one or two of the effects below are hidden, or one that
is in no catalogue. An answer is one JSON object for all:

    {{"001": {{"verdict": "named", "named": ["adhesion"]}},
     "002": {{"verdict": "ambiguous", "named": [], "sets": [["sensor_lag", "fast_damping"]]}},
     "003": {{"verdict": "unexplained", "variable": "speed"}},
     "004": {{"verdict": "adequate"}}}}

Variables: {variables}.

SHA-256 of the truth: {digest}

{effects}
"""


def blind_cases(
    count: int,
    seed: int,
    style: str | None = None,
    faults: Faults = NO_FAULTS,
) -> list[Case]:
    """Return cases of all kinds in any order, each style in turn if none is given."""
    drawn = list(draw_cases(DRAWN_FROM * count, seed))
    taken = np.random.default_rng([seed, 29]).permutation(len(drawn))[:count]
    styles = (style,) if style else tuple(STYLES)
    return [replace(drawn[i], style=styles[n % len(styles)], faults=faults) for n, i in enumerate(taken)]


def truth_of(case: Case, visible: Collection[str]) -> Truth:
    """Return what is hidden in the recording of a case, of which so much is ``visible``."""
    shown = [UNMODELLED[one].shows for one in case.hidden if one in UNMODELLED]
    tip = fingertip(np.random.default_rng([case.seed, 7]))
    seen = tuple(name for name in case.hidden if name in visible)
    return Truth(
        case.hidden, seen, case.kind, tuple(sorted(frozenset().union(*shown))), case.style, tip.exponent
    )


def make_blind(
    folder: Path, truth: Path, drawn: Sequence[Case], seed: int, jobs: int, report: Report
) -> None:
    """Write the recordings of ``drawn`` to ``folder``, and what is hidden in them to the file ``truth``."""
    cases = {f"{number:03d}": case for number, case in enumerate(drawn, 1)}
    told: dict[str, Any] = {}
    with ProcessPoolExecutor(jobs, get_context("spawn")) as pool:
        for name, one in zip(
            cases, pool.map(_make, cases.values(), map(folder.joinpath, cases)), strict=True
        ):
            told[name] = asdict(one)
            report(f"{len(told)} of {len(cases)}")
    known = sorted({*BUILT_IN} - {*BASE})
    text = (
        json.dumps(
            {"seed": seed, "faults": str(drawn[0].faults), "effects": known, "recordings": told}, indent=1
        )
        + "\n"
    )
    write_whole(truth, text)
    about = README.format(
        count=len(cases),
        variables=", ".join(VARIABLES),
        digest=hashlib.sha256(text.encode()).hexdigest(),
        effects="\n".join(f"* {name}: {effect(name).summary}" for name in known),
    )
    write_whole(folder / "README.md", about)


def _make(case: Case, folder: Path) -> Truth:
    write_recording(replace(make_recording(case), name=folder.name), folder, compressed=True)
    left = remaining_evidence(case)
    return truth_of(case, [name for name in case.hidden if left[name] >= VISIBLE_NATS])
