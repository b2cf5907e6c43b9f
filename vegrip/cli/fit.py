"""``vegrip fit``: the model's parameters from a recording."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from vegrip.cli._fits import EACH, HOLD_BACK, TOLERANCE
from vegrip.cli._options import JSON, MODEL_OUT, RECORDING, START_MODEL
from vegrip.cli._outputs import FORCE, Outputs

if TYPE_CHECKING:
    from vegrip.identification.fit import Fit


def fit(
    recording: RECORDING,
    model: START_MODEL = None,
    output: MODEL_OUT = None,
    force: FORCE = False,
    zeros_each_episode: EACH = False,
    tolerance: TOLERANCE = 0.0,
    hold_back: HOLD_BACK = "",
    as_json: JSON = False,
) -> None:
    """Fit a contact model to a recording: all channels at once, noise of force and displacement alike.

    Prints every value with its standard error, what is left of each channel against its noise, and what to
    be wary of: values that the recording does not determine, or that sit on a bound.

    Example: vegrip sample press && vegrip fit press -o press-fit.toml
    """
    from vegrip.cli._fits import asked, doubted, noise_for, opened, print_fit, print_json, print_sentences
    from vegrip.cli._progress import progress
    from vegrip.cli._tables import print_next
    from vegrip.identification.fit import fit as fit_model
    from vegrip.model import write_model

    with Outputs(force=force) as outputs:
        outputs.file(output)
        measured, start = opened(recording, model, hold_back=hold_back)
        with progress("fit") as report:
            found = fit_model(
                measured,
                start,
                noise=noise_for(measured, tolerance),
                zeros="episode" if zeros_each_episode else "recording",
                report=report,
            )
        doubts = doubted(found.problem)
        kept = outputs.write(output, partial(write_model, found.model))
        if as_json:
            print_json(found.as_dict() | {"doubts": [doubt.text for doubt in doubts]})
        else:
            print_sentences(doubt.text for doubt in doubts)  # before the figures that they put in question
            print_fit(found)
            if not any(doubt.is_grave for doubt in doubts):
                print_next(
                    *_next(recording, found, output if kept else None), *asked(zeros_each_episode, tolerance)
                )


def _next(recording: Path, found: "Fit", model: Path | None) -> list[object]:
    from vegrip.identification.fit.result import MISFIT

    with_model = ["--model", model] if model is not None else []
    if found.error > MISFIT:
        return ["vegrip", "diagnose", recording, *with_model]
    if model is not None:
        return ["vegrip", "compare", recording, *with_model]
    return ["vegrip", "fit", recording, "-o", f"{recording.resolve().name}-fit.toml"]
