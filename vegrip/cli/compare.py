"""``vegrip compare``: a model against a recording."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vegrip.cli._options import EACH, HOLD_BACK, JSON, ONLY, RECORDING, TOLERANCE
from vegrip.cli._outputs import FORCE, Outputs
from vegrip.cli._terminal import print_json, print_sentences, printer, progress

if TYPE_CHECKING:
    from vegrip.identification.compare import Comparison

MODEL = Annotated[Path | None, typer.Option("--model", help="Model file; else the paper's model is fitted.")]
VERSUS = Annotated[
    Path | None, typer.Option("--versus", help="A second model (file) or recording (folder) beside it.")
]
OUT = Annotated[Path | None, typer.Option("-o", "--output", metavar="DIR", help="Draw pictures into DIR.")]
FITTED = "the paper's model, fitted"
CURVES = Annotated[
    bool,
    typer.Option("--curves", help="In the JSON: curves over time, residuals by regime and over variables."),
]


def compare(
    recording: RECORDING,
    model: MODEL = None,
    versus: VERSUS = None,
    output: OUT = None,
    force: FORCE = False,
    zeros_each_episode: EACH = False,
    tolerance: TOLERANCE = 0.0,
    hold_back: HOLD_BACK = "",
    only: ONLY = "",
    as_json: JSON = False,
    with_curves: CURVES = False,
) -> None:
    """Say how large the error of every channel is against its noise, and where the model fails.

    With --versus a second model, or a second recording under the same model, is shown beside.
    --episodes looks at some of the episodes alone, e.g. at those that a fit held back.

    Example: vegrip sample press && vegrip fit press -o base.toml
    && vegrip compare press --model base.toml -o pictures
    """
    from vegrip.cli._fits import doubted, judged, opened
    from vegrip.identification.compare import compare as compare_model
    from vegrip.identification.compare.plot import curves

    with Outputs(force=force) as outputs:
        outputs.pictures(output)
        pairs = [(recording, model)]
        if versus is not None:
            pairs.append((versus, model) if versus.is_dir() else (recording, versus))
        names = [file.stem if file is not None else FITTED for _, file in pairs]
        read = [opened(folder, file, hold_back=hold_back, only=only) for folder, file in pairs]
        with progress("compare") as report:
            found = [
                compare_model(
                    measured, start, **judged(measured, tolerance, zeros_each_episode), report=report
                )
                for measured, start in read
            ]
        told = [one.as_dict() | {"doubts": [doubt.text for doubt in doubted(one.problem)]} for one in found]
        if with_curves:
            told = [values | {"curves": curves(one)} for one, values in zip(found, told, strict=True)]
        outputs.write(output, partial(_drawn, found, names))
        if as_json:
            print_json(told[0] | ({"versus": told[1]} if len(told) > 1 else {}))
        else:
            for one, values, name in zip(found, told, names, strict=True):
                _print(one, values, name)


def _drawn(found: "list[Comparison]", names: list[str], out: Path) -> None:
    from vegrip.identification.compare.plot import draw_comparison

    for i, (one, name) in enumerate(zip(found, names, strict=True)):
        files = draw_comparison(one, out if i == 0 else out / "versus", name)
        printer(stderr=True).print(f"{len(files)} pictures in {files[0].parent}", soft_wrap=True)


def _print(found: "Comparison", told: dict[str, Any], name: str) -> None:
    from rich.text import Text

    from vegrip.cli._fits import channel_table

    console = printer()
    origin = name if found.fitted else f"{name} as it is"
    head = Text(told["recording"], style="bold")
    console.print(head + Text(f": {origin}, {told['error']:.3f} times the noise", style="not bold"))
    console.print(channel_table(told["channels"]))
    print_sentences(regime["note"] for regime in told["where"])
    if not told["where"]:
        console.print("nothing stands out of the noise")
    print_sentences(told["doubts"])
