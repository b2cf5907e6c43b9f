"""``vegrip add``: one effect into a model."""

from functools import partial
from typing import Annotated, Literal

import typer

from vegrip.cli._fits import EACH, HOLD_BACK, TOLERANCE
from vegrip.cli._options import JSON, MODEL_OUT, RECORDING, START_MODEL
from vegrip.cli._outputs import FORCE, Outputs

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
    from vegrip.cli._fits import noise_for, opened, print_fit, print_json
    from vegrip.cli._progress import progress
    from vegrip.cli._tables import printer
    from vegrip.effects import effect as known_effect
    from vegrip.identification.diagnosis.error_ladder import add_effect
    from vegrip.identification.fit import fit
    from vegrip.model import write_model

    with Outputs(force=force) as outputs:
        outputs.file(output)
        known_effect(effect)  # an unknown one is refused before the fit
        measured, start = opened(recording, model, hold_back=hold_back)
        with progress("add") as report:
            zeros: Literal["recording", "episode"] = "episode" if zeros_each_episode else "recording"
            noise = noise_for(measured, tolerance)
            before = fit(measured, start, noise=noise, zeros=zeros, report=report)
            after, base = add_effect(effect, before)
        outputs.write(output, partial(write_model, after.model))
        error = {"before": base.error, "after": after.error, "noise_floor": 1.0}
        if as_json:
            told = after.as_dict()
            print_json(
                {
                    "effect": effect,
                    "error": error,
                    "parameters": told["parameters"],
                    "warnings": told["warnings"],
                }
            )
        else:
            print_fit(after)
            text = f"error in units of the noise: {error['before']:.3f} -> {error['after']:.3f} (floor 1)"
            printer().print(text)
