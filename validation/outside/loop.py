"""``python -m validation.outside.loop``: draft, experiment, draft, until the rig can tell no more.

A law that no catalogue has is hidden in a fingertip of the virtual bench, which presses it ten times. The
best draft and its rival (nothing, where no other law is as good) are hypotheses of an experiment; the bench
does it with the same fingertip, and both recordings are drafted together. The loop ends when no draft over
anything else is as good, or when no experiment on the menu separates those that are.
"""

import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from validation.outside.__main__ import errors_on
from validation.outside.laws import OUTSIDE_LAWS, record
from vegrip.cli import run
from vegrip.cli._terminal import printer, progress
from vegrip.errors import UsageError, suggestion
from vegrip.identification.draft import Draft, draft
from vegrip.identification.experiment import NO_EFFECT, Design, design, hypotheses_of
from vegrip.identification.experiment.design_space import RigLimits, complete_limits, limits_of
from vegrip.identification.recording import Recording
from vegrip.virtual.bench.protocol import Episode
from vegrip.whole_file import write_whole

LAWS = ("tanh_drag", "stretched_wear", "presses", "second_body", "leak")
MOST_ROUNDS = 4
LONGEST_S = 60.0  # of an experiment


@dataclass(frozen=True)
class Round:
    """What one turn of the loop found, and the motion that it asks for."""

    law: str  # in words; empty where no draft is written
    reason: str  # why none is
    rivals: tuple[str, ...]
    error: float  # over the noise, of the recording so far
    foretold: tuple[
        float, float
    ]  # rms error [N] of the paper's model and of the draft under a protocol not shown
    experiment: str
    nats: float


def turns(law: str, seed: int) -> Iterator[Round]:
    """Yield the rounds of the loop."""
    more: list[Episode] = []
    for _ in range(MOST_ROUNDS):
        recording = record(law, "presses", seed, more=more)
        found = draft(recording)
        errors = errors_on(found, record(law, "cycles", seed, is_quiet=True))
        plan = planned(found, recording) if found.taken else None
        best = plan.best if plan is not None and (found.rivals or not more) else None
        yield Round(
            found.taken.law.equation.partition(";")[0] + f" over {', '.join(found.taken.law.variables)}"
            if found.taken
            else "",
            found.reason,
            tuple(", ".join(one.law.variables) for one in found.rivals),
            found.taken.fitted.error if found.taken else found.base.error,
            (errors["paper"], errors["draft"]),
            best.item if best is not None else "",
            best.nats if best is not None else 0.0,
        )
        if best is None:
            return
        more += best.whole.episodes


def planned(found: Draft, recording: Recording) -> Design:
    """Return the experiment that tells the draft from its rival, or from nothing."""
    assert found.taken is not None  # noqa: S101
    with tempfile.TemporaryDirectory() as folder:
        names = []
        for name, one in zip(("first", "second"), [found.taken, *found.rivals[:1]], strict=False):
            names.append(str(Path(folder) / f"{name}.py"))
            write_whole(Path(names[-1]), found.text_of(one, name))
        contest = hypotheses_of(found.start, [*names, *[NO_EFFECT] * (len(names) < 2)])
        limits = complete_limits(RigLimits(duration=LONGEST_S), limits_of(recording))
        return design(contest, limits, is_thorough=False)


def loop(
    law: Annotated[list[str] | None, typer.Option("--law", help="Only this law; may be repeated.")] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Of fingertip, motions and noise.")] = 0,
) -> None:
    """Close the loop of draft and experiment on laws that no catalogue has.

    Example: python -m validation.outside.loop --law leak
    """
    for name in law or ():
        if name not in OUTSIDE_LAWS:
            raise UsageError(f"there is no law {name!r}; {suggestion(name, OUTSIDE_LAWS)}")
    table = Table(box=None, padding=(0, 2))
    for heading in ("law", "round", "draft", "as good", "error", "foretold [mN]", "next experiment"):
        table.add_column(heading)
    with progress("loop") as report:
        for name in law or LAWS:
            for number, one in enumerate(turns(name, seed), 1):
                report(f"{name}, round {number}: {one.law or one.reason}")
                foretold = f"{1e3 * one.foretold[0]:.1f} -> {1e3 * one.foretold[1]:.1f}"
                next_one = f"{one.experiment} ({one.nats:.0f} nats)" if one.experiment else "none: done"
                cells = (
                    one.law or f"none: {one.reason}",
                    "; ".join(one.rivals),
                    f"{one.error:.2f}",
                    foretold,
                )
                table.add_row(name, str(number), *cells, next_one)
    printer().print(table)


if __name__ == "__main__":
    sys.exit(run(loop, sys.argv[1:], "python -m validation.outside.loop"))
