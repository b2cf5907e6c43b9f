"""``vegrip compare``: a model against a recording."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vegrip.cli._fits import EACH, TOLERANCE

if TYPE_CHECKING:
    from vegrip.compare import Comparison

RECORDING = Annotated[Path, typer.Argument(help="Folder of a recording.")]
MODEL = Annotated[Path | None, typer.Option("--model", help="Model file; else the paper's model is fitted.")]
VERSUS = Annotated[
    Path | None, typer.Option("--versus", help="A second model (file) or recording (folder) beside it.")
]
OUT = Annotated[Path | None, typer.Option("-o", "--out", metavar="DIR", help="Draw pictures into DIR.")]
JSON = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]


def compare(
    recording: RECORDING,
    model: MODEL = None,
    versus: VERSUS = None,
    out: OUT = None,
    zeros_each_episode: EACH = False,
    tolerance: TOLERANCE = 0.0,
    as_json: JSON = False,
) -> None:
    """Say how large the error of every channel is against its noise, and where the model fails.

    With --versus a second model, or a second recording under the same model, is shown beside.

    Example: vegrip compare press --model press.toml --versus press-adhesion.toml -o pictures
    """
    from vegrip.cli._fits import doubted, print_json, progress

    pairs = [(recording, model)]
    if versus is not None:
        pairs.append((versus, model) if versus.is_dir() else (recording, versus))
    with progress("compare") as report:
        found = [_compared(folder, file, zeros_each_episode, tolerance, report) for folder, file in pairs]
    told = [one.as_dict() | {"doubts": doubted(one.problem)} for one in found]
    if out is not None:
        _drawn(found, out)
    if as_json:
        print_json(told[0] | ({"versus": told[1]} if len(told) > 1 else {}))
    else:
        for one, values in zip(found, told, strict=True):
            _print(one, values)


def _compared(folder: Path, file: Path | None, each: bool, tolerance: float, report: object) -> "Comparison":
    from vegrip.cli._fits import noise_for, opened
    from vegrip.compare import compare as compare_model

    measured, model = opened(folder, file)
    return compare_model(
        measured,
        model,
        noise=noise_for(measured, tolerance),
        zeros="episode" if each else "recording",
        report=report,  # type: ignore[arg-type]
    )


def _drawn(found: "list[Comparison]", out: Path) -> None:
    from rich.console import Console

    from vegrip.compare.plot import draw

    for i, one in enumerate(found):
        files = draw(one, out if i == 0 else out / "versus")
        Console(stderr=True, highlight=False).print(
            f"{len(files)} pictures in {files[0].parent}", soft_wrap=True
        )


def _print(found: "Comparison", told: dict[str, Any]) -> None:
    from vegrip.cli._fits import channel_table, print_sentences
    from vegrip.cli._tables import printer

    console = printer()
    origin = "the paper's model, fitted" if found.fitted else "the model as it is"
    console.print(f"[bold]{told['recording']}[/bold]: {origin}, {told['error']:.3f} times the noise")
    console.print(channel_table(told["channels"]))
    print_sentences(regime["note"] for regime in told["where"])
    if not told["where"]:
        console.print("nothing stands out of the noise")
    print_sentences(told["doubts"])
