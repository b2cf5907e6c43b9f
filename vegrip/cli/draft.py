"""``vegrip draft``: a law for what no effect of the catalogue explains."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from vegrip.cli._options import EACH, HOLD_BACK, JSON, RECORDING, REFITTED_MODEL, TOLERANCE
from vegrip.cli._outputs import FORCE, Outputs
from vegrip.cli._terminal import print_json, print_next, printer, progress
from vegrip.whole_file import write_whole

OUT = Annotated[
    Path, typer.Option("-o", "--output", help="Effect to write, such as wear.py; its name is the effect's.")
]
RIVAL = Annotated[
    Path | None,
    typer.Option("--rival", help="Write the best law over something else too, where one is as good."),
]
CURVE = Annotated[
    bool,
    typer.Option("--curves", help="In the JSON: what was left and what the law adds, over its variable."),
]
PICTURE = Annotated[
    Path | None,
    typer.Option("--picture", help="Draw what the model leaves and what the law adds, over its variable."),
]


CURVE_ROWS = 500  # in the JSON


def draft(
    recording: RECORDING,
    output: OUT,
    model: REFITTED_MODEL = None,
    rival: RIVAL = None,
    picture: PICTURE = None,
    force: FORCE = False,
    zeros_each_episode: EACH = False,
    tolerance: TOLERANCE = 0.0,
    hold_back: HOLD_BACK = "",
    with_curves: CURVE = False,
    as_json: JSON = False,
) -> None:
    """Draft a law for what a model leaves of a recording, where no effect of the catalogue explains it.

    Searches a grammar of laws (powers, saturation, thresholds, steps, memories, products) by fitting. What is
    written gains on episodes and protocols that were held out and breaks no law of contacts; the verdict is
    none, with the reason, where nothing does. The file goes on as any effect.

    Example: vegrip sample press && vegrip draft press -o press_law.py
    """
    from vegrip.cli.fit import error_options, judged, opened
    from vegrip.display.draft import parts
    from vegrip.identification.draft import draft as draft_law
    from vegrip.identification.draft.plot import curve, draw_draft
    from vegrip.identification.draft.search import effect_name

    name, rival_name = effect_name(output), effect_name(rival) if rival is not None else ""
    with Outputs(force=force) as outputs:
        outputs.file(output)
        outputs.file(rival)
        outputs.picture(picture)
        measured, start = opened(recording, model, hold_back=hold_back)
        with progress("draft") as report:
            found = draft_law(
                measured, start, name=name, **judged(measured, tolerance, zeros_each_episode), report=report
            )
        files = [(output, name, found.taken)] if found.taken is not None else []
        if rival is not None and found.rivals:
            files.append((rival, rival_name, found.rivals[0]))
        kept = [
            path
            for path, effect, law in files
            if outputs.write(path, partial(write_whole, content=found.text_of(law, effect)))
        ]
        if found.taken is not None:
            outputs.write(picture, partial(draw_draft, found))
        if as_json:
            result = found.as_dict()
            result |= {"file": str(output) if output in kept else None}
            result |= {"rival": str(rival) if rival in kept else None}
            if with_curves:
                result["curve"] = curve(found, CURVE_ROWS) if found.taken is not None else None
            print_json(result)
            return
        for part in parts(found):
            printer().print(part)
        if rival is not None and found.taken is not None and not found.rivals:
            printer().print("no law over anything else is as good: there is no rival to write")
        base = ["--model", model] if model is not None else []
        if len(kept) == 2:
            print_next(
                "vegrip",
                "experiment",
                recording,
                *base,
                "--candidates",
                f"{output},{rival}",
                "-o",
                "next.toml",
            )
        elif kept:
            options = error_options(zeros_each_episode, tolerance)
            print_next("vegrip", "add", output, recording, *base, "-o", f"{name}.toml", *options)
