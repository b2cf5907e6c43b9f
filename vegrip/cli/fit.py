"""``vegrip fit`` and ``vegrip add``: a model's parameters from a recording, and one effect more."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vegrip.cli._options import EACH, HOLD_BACK, JSON, MODEL_OUT, RECORDING, START_MODEL, TOLERANCE
from vegrip.cli._outputs import FORCE, Outputs
from vegrip.cli._terminal import print_json, print_next, print_sentences, printer, progress

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
    from vegrip.cli._fits import doubted, error_options, judged, opened, print_fit
    from vegrip.identification.fit import fit as fit_model
    from vegrip.model import write_model

    with Outputs(force=force) as outputs:
        outputs.file(output)
        measured, start = opened(recording, model, hold_back=hold_back)
        with progress("fit") as report:
            same = judged(measured, tolerance, zeros_each_episode)
            found = fit_model(measured, start, **same, report=report)
        doubts = doubted(found.problem)
        kept = outputs.write(output, partial(write_model, found.model))
        if as_json:
            print_json(found.as_dict() | {"doubts": [doubt.text for doubt in doubts]})
        else:
            print_sentences(doubt.text for doubt in doubts)  # before the figures that they put in question
            print_fit(found)
            if not any(doubt.is_grave for doubt in doubts):
                print_next(
                    *_next(recording, found, output if kept else None),
                    *error_options(zeros_each_episode, tolerance),
                )


def _next(recording: Path, found: "Fit", model: Path | None) -> list[object]:
    from vegrip.identification.fit.result import MISFIT

    with_model = ["--model", model] if model is not None else []
    if found.error > MISFIT:
        return ["vegrip", "diagnose", recording, *with_model]
    if model is not None:
        return ["vegrip", "compare", recording, *with_model]
    return ["vegrip", "fit", recording, "-o", f"{recording.resolve().name}-fit.toml"]


EFFECT = Annotated[str, typer.Argument(help="Name of an effect, built in or of your own package.")]


def add(
    effect: EFFECT,
    recording: RECORDING,
    model: START_MODEL = None,
    output: MODEL_OUT = None,
    force: FORCE = False,
    zeros_each_episode: EACH = False,
    tolerance: TOLERANCE = 0.0,
    hold_back: HOLD_BACK = "",
    as_json: JSON = False,
) -> None:
    """Put an effect into the model, fit again, and say how far the error fell.

    The file that is written runs in the node as it is.

    Example: vegrip sample press && vegrip add adhesion press -o press-adhesion.toml
    """
    from vegrip.cli._fits import judged, opened, print_fit
    from vegrip.effects import effect as known_effect
    from vegrip.identification.diagnosis.error_ladder import add_effect
    from vegrip.identification.fit import fit as fit_model
    from vegrip.model import write_model

    with Outputs(force=force) as outputs:
        outputs.file(output)
        known_effect(effect)  # an unknown one is refused before the fit
        measured, start = opened(recording, model, hold_back=hold_back)
        with progress("add") as report:
            same = judged(measured, tolerance, zeros_each_episode)
            before = fit_model(measured, start, **same, report=report)
            after, base = add_effect(effect, before)
        outputs.write(output, partial(write_model, after.model))
        error = {"before": base.error, "after": after.error, "noise_floor": 1.0}
        if as_json:
            told = after.as_dict()
            kept = {name: told[name] for name in ("parameters", "warnings")}
            print_json({"effect": effect, "error": error} | kept)
        else:
            print_fit(after)
            text = f"error in units of the noise: {error['before']:.3f} -> {error['after']:.3f} (floor 1)"
            printer().print(text)
