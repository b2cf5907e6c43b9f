"""``vegrip experiment``: what to do next."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vegrip.cli._options import JSON, RECORDING, REFITTED_MODEL
from vegrip.cli._outputs import FORCE, Outputs
from vegrip.cli._terminal import answer, printer, progress
from vegrip.config import build
from vegrip.config import replace as changed
from vegrip.display.text import figures
from vegrip.errors import UsageError

if TYPE_CHECKING:
    from vegrip.identification.experiment import Design, Hypotheses, RigLimits
    from vegrip.identification.recording import Recording

CANDIDATE = Annotated[
    list[str] | None,
    typer.Option("--candidates", metavar="NAME", help="Effects to separate (repeat for each), or 'nothing'."),
]
OUT = Annotated[Path | None, typer.Option("-o", "--output", metavar="TOML", help="Protocol file to write.")]
LIMITS = Annotated[
    Path | None,
    typer.Option("--limits", metavar="TOML", help="depth, force, speed, tangential_force, ... in SI."),
]
DEPTH = Annotated[float | None, typer.Option("--depth", help="Greatest indentation [m].")]
MOST_FORCE = Annotated[float | None, typer.Option("--normal-force", help="Greatest normal force [N].")]
SPEED = Annotated[float | None, typer.Option("--speed", help="Fastest motion along the normal [m/s].")]
PULL = Annotated[float | None, typer.Option("--tangential-force", help="Greatest pull [N]; 0: cannot pull.")]
LASTS = Annotated[float | None, typer.Option("--duration", help="Longest experiment [s], pauses included.")]
PLOT = Annotated[
    Path | None, typer.Option("--plot", metavar="PNG", help="Draw it, with the prediction of each candidate.")
]
OPTIONS = {"force": "--normal-force"}  # where the key of a limit is not the option's name


def experiment(
    recording: RECORDING,
    model: REFITTED_MODEL = None,
    candidates: CANDIDATE = None,
    output: OUT = None,
    force: FORCE = False,
    limits: LIMITS = None,
    depth: DEPTH = None,
    normal_force: MOST_FORCE = None,
    speed: SPEED = None,
    tangential_force: PULL = None,
    duration: LASTS = None,
    plot: PLOT = None,
    as_json: JSON = False,
) -> None:
    """Find the next experiment that separates candidates, and write it as a protocol that a rig can do.

    The candidates are those that a diagnosis of the recording cannot distinguish, or those given. Each is
    fitted to the recording; experiments of a menu, their amplitudes chosen within the limits of the rig (as
    in the recording, where nothing else is said), are judged by how far apart they put the fitted models
    after every refit, in nats: 20 decide, below 5 decide nothing.

    Example: vegrip sample press && vegrip experiment press --candidates adhesion,guide_friction --duration 30
    -o next.toml
    """
    from vegrip.cli.fit import opened
    from vegrip.effects import effect
    from vegrip.identification.experiment import NO_EFFECT, design
    from vegrip.identification.experiment.design_space import complete_limits, limits_of
    from vegrip.identification.simulate import write_protocol
    from vegrip.identification.simulate.run import draw_simulation

    with Outputs(force=force) as outputs:
        outputs.file(output)
        outputs.picture(plot)
        for name in set(_names(candidates or [])) - {NO_EFFECT}:
            effect(name)  # an unknown one is refused before the fits
        measured, start = opened(recording, model)
        own = {"depth": depth, "force": normal_force, "speed": speed, "tangential_force": tangential_force}
        allowed = complete_limits(
            rig_limits(limits, {**own, "duration": duration}), limits_of(_usable(measured))
        )
        with progress("experiment") as report:
            contest = _contest(measured, start, _names(candidates or []), report)
            if isinstance(contest, dict):
                return _nothing_to_do(contest, as_json)
            found = design(contest, allowed, report=report)
        best = found.best
        written = False
        if best is not None:
            written = outputs.write(output, lambda path: write_protocol(best.whole, path, found.advice))
            outputs.write(plot, partial(draw_simulation, best.whole, dict(contest.models)))
        target = output if written else None
        result = found.as_dict() | {"needed": True, "protocol": str(target) if target else None}
        answer(result, lambda: _print(found, target), as_json=as_json)
        if best is None and plot is not None:
            raise UsageError(f"there is no motion to draw: {found.advice}")
        return None


def _names(given: list[str]) -> list[str]:
    return [name.strip() for text in given for name in text.split(",") if name.strip()]


def _usable(recording: "Recording") -> "Recording":
    from vegrip.identification.fit.noise import noise_of
    from vegrip.identification.fit.preprocess import preprocess

    preprocess(recording, noise_of(recording))  # says in one sentence what a fit would miss
    return recording


def rig_limits(path: Path | None, given: dict[str, float | None]) -> "RigLimits":
    """Return the limits of a file with those that options give; NaN where neither says any."""
    from vegrip.identification.experiment.design_space import RigLimits, read_limits

    limits = read_limits(path) if path is not None else build(RigLimits, {}, "limits")
    for name, value in given.items():
        if value is not None:
            limits = changed(limits, name, value, OPTIONS.get(name, f"--{name.replace('_', '-')}"))
    return limits


def _contest(
    recording: "Recording", model: Any, names: list[str], report: Any
) -> "Hypotheses | dict[str, Any]":
    from vegrip.identification.diagnosis import diagnose
    from vegrip.identification.experiment import hypotheses_of
    from vegrip.identification.experiment.design import hypotheses_after
    from vegrip.identification.fit import fit

    if names:
        return hypotheses_of(fit(recording, model, report=report), names, report)
    found = diagnose(recording, model, report=report)
    contest = hypotheses_after(found) if found.verdict == "ambiguous" else None
    return {"verdict": found.verdict, "named": found.named} if contest is None else contest


def _nothing_to_do(result: dict[str, Any], as_json: bool) -> None:
    reasons = {
        "adequate": "nothing is missing that this recording shows",
        "named": "the recording already shows: " + ", ".join(result["named"]),
        "ambiguous": "record air before and after every trial, which distinguishes a drift from a jump",
        "unexplained": "no effect of the catalogue explains it, so there are no candidates to separate",
    }
    sentence = f"{reasons[result['verdict']]}; give --candidates to plan an experiment anyway"
    said = {"needed": False, "advice": sentence, **result}
    answer(said, lambda: typer.echo(f"no experiment is needed: {sentence}"), as_json=as_json)


def _print(found: "Design", output: Path | None) -> None:
    console = printer()
    head = ("experiment", "expected [nats]", "duration [s]", "times", "amplitudes", "")
    table = figures(*head, left=("experiment", "amplitudes", ""))
    for one in found.tried[:10]:
        sizes = ", ".join(f"{name} {value:.3g}" for name, value in one.amplitudes.items())
        cells = (f"{one.nats:.1f}", f"{one.whole.duration:.0f}", str(one.times), sizes)
        table.add_row(one.item, *cells, "" if one.refitted else "without refits")
    console.print(table)
    for name in found.contest.assumed:
        console.print(f"- the recording does not show {name}; it is taken at its declared size")
    for (truth, rival), nats in found.achieved.items():
        console.print(f"simulated with {truth}: it beats {rival} by {nats:.1f} nats")
    console.print(found.advice, style="bold")
    if found.best is not None and output is not None:
        console.print(f"written to {output}", soft_wrap=True)
