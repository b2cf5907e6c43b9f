"""``vegrip refine``: effect after effect, until the next one does not pay."""

import json
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vegrip.cli._options import EACH, HOLD_BACK, JSON, MODEL_OUT, RECORDING, START_MODEL, TOLERANCE
from vegrip.cli._outputs import FORCE, Outputs
from vegrip.cli._terminal import figures, print_json, printer, progress
from vegrip.whole_file import write_whole

if TYPE_CHECKING:
    from vegrip.identification.diagnosis.error_ladder import Rung

REPORT = Annotated[
    Path | None,
    typer.Option("--report", metavar="DIR", help="Write ladder.png and report.json, for `vegrip report`."),
]
MOST = Annotated[int, typer.Option(min=1, max=10, help="Add at most this many effects.")]


def refine(
    recording: RECORDING,
    model: START_MODEL = None,
    output: MODEL_OUT = None,
    force: FORCE = False,
    report: REPORT = None,
    most: MOST = 4,
    zeros_each_episode: EACH = False,
    tolerance: TOLERANCE = 0.0,
    hold_back: HOLD_BACK = "",
    as_json: JSON = False,
) -> None:
    """Add effect after effect, refitting each time, and show the ladder of errors down to the noise.

    It stops when the next effect does not pay, and says so. Held-out errors are those of each episode under
    a fit without it.

    Example: vegrip sample press && vegrip refine press -o press-refined.toml --report press-ladder
    """
    from vegrip.cli._fits import judged, opened
    from vegrip.identification.diagnosis import error_ladder
    from vegrip.identification.diagnosis.account import account
    from vegrip.identification.experiment.design import next_experiment
    from vegrip.model import write_model

    with Outputs(force=force) as outputs:
        outputs.file(output)
        outputs.pictures(report)
        measured, start = opened(recording, model, hold_back=hold_back)
        with progress("refine") as tell:
            same = judged(measured, tolerance, zeros_each_episode)
            refined = error_ladder.refine(measured, start, **same, most=most, report=tell)
        found, rungs = refined.diagnosis, refined.rungs
        outputs.write(output, partial(write_model, found.model))
        told = {"ladder": [asdict(rung) for rung in rungs], "verdict": found.verdict, "noise_floor": 1.0}
        if report is not None:
            again = f"vegrip refine {recording}" + (f" --model {model}" if model is not None else "")
            again += f" --hold-back {hold_back}" if hold_back else ""
            outputs.write(
                report,
                partial(_write_report, rungs, account(found, recording, [again], next_experiment(found))),
            )
        if as_json:
            print_json(told)
        else:
            _print(told)


def _write_report(rungs: "list[Rung]", told: dict[str, Any], folder: Path) -> None:
    from vegrip.identification.diagnosis.error_ladder import draw_ladder

    draw_ladder(rungs, folder / "ladder.png")
    write_whole(folder / "report.json", json.dumps(told, indent=2) + "\n")


def _print(told: dict[str, Any]) -> None:
    table = figures("model", "error / noise", "held out", left=("model",))
    for rung in told["ladder"]:
        name = "start" if rung["effect"] is None else f"+ {rung['effect']}"
        table.add_row(name, f"{rung['error']:.3f}", f"{rung['heldout_error']:.3f}")
    printer().print(table)
    printer().print(f"verdict: {told['verdict']}; the next effect does not pay")
