"""``vegrip diagnose``: which effect a model lacks."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vegrip.cli import _terminal
from vegrip.cli._options import EACH, EACH_LAW, HOLD_BACK, JSON, RECORDING, REFITTED_MODEL, TOLERANCE
from vegrip.cli._outputs import FORCE, Outputs
from vegrip.whole_file import write_whole

if TYPE_CHECKING:
    from vegrip.identification.diagnosis import Diagnosis

OUT = Annotated[
    Path | None,
    typer.Option(
        "-o",
        "--output",
        help="Folder for pictures, diagnosis.json and model.toml; or the model file alone, FILE.toml.",
    ),
]
DRAWS = Annotated[
    int, typer.Option("--draws", min=0, help="Bootstrap draws that say how sure the verdict is, such as 20.")
]


def diagnose(
    recording: RECORDING,
    model: REFITTED_MODEL = None,
    output: OUT = None,
    force: FORCE = False,
    zeros_each_episode: EACH = False,
    laws_each_episode: EACH_LAW = False,
    tolerance: TOLERANCE = 0.0,
    hold_back: HOLD_BACK = "",
    draws: DRAWS = 0,
    as_json: JSON = False,
) -> None:
    """Say which physical effects would explain what the model leaves of a recording.

    The verdict is one of four: adequate (nothing is missing that the recording can show), named, ambiguous
    (one of these, and which experiment decides), unexplained (none of the catalogue, and where it shows).

    Example: vegrip sample press && vegrip diagnose press -o found
    """
    from vegrip.cli import INTERRUPTED
    from vegrip.cli.fit import error_options, judged, opened
    from vegrip.display.diagnosis import as_json as json_of
    from vegrip.identification.diagnosis import diagnose as diagnose_model
    from vegrip.model import write_model

    with Outputs(force=force) as outputs:
        is_alone = output is not None and output.suffix.lower() == ".toml"
        (outputs.file if is_alone else outputs.pictures)(output)
        measured, start = opened(recording, model, hold_back=hold_back)
        with _terminal.progress("diagnose") as report:
            same = judged(measured, tolerance, zeros_each_episode, laws_each_episode)
            found = diagnose_model(measured, start, **same, report=report, can_stop=True)
        if is_alone:
            outputs.write(output, partial(write_model, found.model))
        else:
            outputs.write(
                output, partial(_write_folder, found, model.stem if model else "the paper's model", draws)
            )
        if as_json:
            _terminal.print_json(json_of(found, draws))
        else:
            _print(found, draws)
            if words := _next(found, recording, model):
                options = (
                    error_options(found.start.problem.zeros == "episode", tolerance)
                    if words[0] in ("add", "fit", "refine", "draft")
                    else []
                )
                _terminal.print_next("vegrip", *words, *options)
        if found.is_unfinished:
            raise typer.Exit(INTERRUPTED)


def _next(found: "Diagnosis", recording: Path, model: Path | None) -> list[object]:
    """Return the command that goes on from the verdict.

    None where the recording itself is doubted or shows one motion alone, or episodes have laws of their own,
    which no other knows.
    """
    if (
        found.start.laws
        or found.unproven
        or found.is_unfinished
        or any(doubt.is_grave for doubt in found.doubts)
    ):
        return []
    name = recording.resolve().name
    base = ["--model", model] if model is not None else []
    if found.verdict == "named":
        first, *more = found.named
        if more:
            return ["refine", recording, *base, "-o", f"{name}-refined.toml"]
        return ["add", first, recording, *base, "-o", f"{name}-{first}.toml"]
    if found.verdict == "ambiguous":
        return ["experiment", recording, *base, "-o", f"{name}-next.toml"]
    if found.verdict == "adequate":
        return ["fit", recording, *base, "-o", f"{name}-fit.toml"]
    return ["draft", recording, *base, "-o", "law.py"]


def _write_folder(found: "Diagnosis", start: str, draws: int, folder: Path) -> None:
    from vegrip.display.diagnosis import as_json as json_of
    from vegrip.identification.diagnosis.account import draw_diagnosis
    from vegrip.model import write_model

    draw_diagnosis(found, folder, start)
    write_whole(folder / "diagnosis.json", _terminal.json_text(json_of(found, draws)) + "\n")
    write_model(found.model, folder / "model.toml")


def _print(found: "Diagnosis", draws: int) -> None:
    from vegrip.display.diagnosis import as_json as json_of
    from vegrip.display.diagnosis import parts

    console = _terminal.printer()
    result = json_of(found, draws)
    for part in parts(found):
        console.print(part)
    if note := result["certainty"]["note"]:
        console.print(note, soft_wrap=True)
    if result["experiment"]:
        for name, text in result["experiment"]["suggestions"].items():
            console.print(f"to distinguish {name}: {text}")
    for channel, source in result["noise"].items():
        console.print(f"noise of {channel}: {source}", soft_wrap=True)
    unseen: dict[str, list[str]] = {}
    for name, reason in result["out_of_sight"].items():
        unseen.setdefault(reason, []).append(name)
    for reason, names in unseen.items():
        console.print(f"could not be tested, {reason}: {', '.join(names)}")
    _print_failures(result, ", ".join(one.candidate.name for one in found.search.accepted))
    grave = [doubt.text for doubt in found.doubts if doubt.is_grave]
    _terminal.print_sentences(text for text in [*result["doubts"], *result["warnings"]] if text not in grave)


def _print_failures(result: dict[str, Any], added: str) -> None:
    models = [("the start model", result["error"]["before"], result["where"])]
    if added:
        models.append((f"the model with {added}", result["error"]["after"], result["where_after"]))
    for name, error, regimes in models:
        _terminal.printer().print(
            f"{name} leaves {error:.3f} times the noise" + (", and fails here:" if regimes else "")
        )
        _terminal.print_sentences(regime["note"] for regime in regimes)
