"""``vegrip fit``, ``add``, ``refine`` and ``compare``, and what every command that fits models shares."""

import json
import logging
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vegrip.cli import _options, _terminal
from vegrip.cli._outputs import FORCE, Outputs
from vegrip.whole_file import write_whole

if TYPE_CHECKING:
    from vegrip.display.text import Part
    from vegrip.identification.compare import Comparison
    from vegrip.identification.diagnosis.data_checks import Doubt
    from vegrip.identification.diagnosis.error_ladder import Rung
    from vegrip.identification.fit import Fit
    from vegrip.identification.fit.problem import Problem
    from vegrip.identification.recording import Recording
    from vegrip.model import ContactModel

log = logging.getLogger(__name__)


def fit(
    recording: _options.RECORDING,
    model: _options.START_MODEL = None,
    output: _options.MODEL_OUT = None,
    force: FORCE = False,
    zeros_each_episode: _options.EACH = False,
    laws_each_episode: _options.EACH_LAW = False,
    tolerance: _options.TOLERANCE = 0.0,
    hold_back: _options.HOLD_BACK = "",
    as_json: _options.JSON = False,
) -> None:
    """Fit a contact model to a recording: all channels at once, noise of force and displacement alike.

    Prints every value with its standard error, what is left of each channel against its noise, and what to
    be wary of: values that the recording does not determine, or that sit on a bound.

    Example: vegrip sample press && vegrip fit press -o press-fit.toml
    """
    from vegrip.identification.fit import fit as fit_model
    from vegrip.model import write_model

    with Outputs(force=force) as outputs:
        outputs.file(output)
        measured, start = opened(recording, model, hold_back=hold_back)
        with _terminal.progress("fit") as report:
            same = judged(measured, tolerance, zeros_each_episode, laws_each_episode)
            found = fit_model(measured, start, **same, report=report)
        doubts = doubted(found.problem)
        kept = outputs.write(output, partial(write_model, found.model))
        if as_json:
            _terminal.print_json(found.as_dict() | {"doubts": [doubt.text for doubt in doubts]})
            return
        _terminal.print_sentences(
            doubt.text for doubt in doubts
        )  # before the figures that they put in question
        print_fit(found)
        next_command = _next(recording, found, output if kept else None)
        can_follow = not found.laws or "compare" not in next_command  # which knows one law for all
        if can_follow and not any(doubt.is_grave for doubt in doubts):
            _terminal.print_next(
                *next_command, *error_options(zeros_each_episode, tolerance, laws_each_episode)
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
    recording: _options.RECORDING,
    model: _options.START_MODEL = None,
    output: _options.MODEL_OUT = None,
    force: FORCE = False,
    zeros_each_episode: _options.EACH = False,
    tolerance: _options.TOLERANCE = 0.0,
    hold_back: _options.HOLD_BACK = "",
    as_json: _options.JSON = False,
) -> None:
    """Put an effect into the model, fit again, and say how far the error fell.

    The file that is written runs in the node as it is.

    Example: vegrip sample press && vegrip add adhesion press -o press-adhesion.toml
    """
    from vegrip.effects import effect as known_effect
    from vegrip.identification.diagnosis.error_ladder import add_effect
    from vegrip.identification.fit import fit as fit_model
    from vegrip.model import write_model

    with Outputs(force=force) as outputs:
        outputs.file(output)
        known_effect(effect)  # an unknown one is refused before the fit
        measured, start = opened(recording, model, hold_back=hold_back)
        with _terminal.progress("add") as report:
            same = judged(measured, tolerance, zeros_each_episode)
            before = fit_model(measured, start, **same, report=report)
            doubts = [doubt.text for doubt in doubted(before.problem)]
            after, base = add_effect(effect, before)
        outputs.write(output, partial(write_model, after.model))
        error = {"before": base.error, "after": after.error, "noise_floor": 1.0}
        if as_json:
            printed = after.as_dict()
            kept = {name: printed[name] for name in ("parameters", "warnings")}
            _terminal.print_json({"effect": effect, "error": error, "doubts": doubts} | kept)
            return
        _terminal.print_sentences(doubts)
        print_fit(after)
        text = f"error in units of the noise: {error['before']:.3f} -> {error['after']:.3f} (floor 1)"
        _terminal.printer().print(text)


REPORT = Annotated[
    Path | None,
    typer.Option("--report", metavar="DIR", help="Write ladder.png and report.json, for `vegrip report`."),
]
MOST = Annotated[int, typer.Option(min=1, max=10, help="Add at most this many effects.")]


def refine(
    recording: _options.RECORDING,
    model: _options.START_MODEL = None,
    output: _options.MODEL_OUT = None,
    force: FORCE = False,
    report: REPORT = None,
    most: MOST = 4,
    zeros_each_episode: _options.EACH = False,
    tolerance: _options.TOLERANCE = 0.0,
    hold_back: _options.HOLD_BACK = "",
    as_json: _options.JSON = False,
) -> None:
    """Add effect after effect, refitting each time, and show the ladder of errors down to the noise.

    It stops when the next effect does not pay, and says so. Held-out errors are those of each episode under
    a fit without it.

    Example: vegrip sample press && vegrip refine press -o press-refined.toml --report press-ladder
    """
    from vegrip.display import ladder
    from vegrip.identification.diagnosis import error_ladder
    from vegrip.identification.diagnosis.account import account
    from vegrip.identification.experiment.design import next_experiment
    from vegrip.model import write_model

    with Outputs(force=force) as outputs:
        outputs.file(output)
        outputs.pictures(report)
        measured, start = opened(recording, model, hold_back=hold_back)
        with _terminal.progress("refine") as say:
            same = judged(measured, tolerance, zeros_each_episode)
            refined = error_ladder.refine(measured, start, **same, most=most, report=say)
        found, rungs = refined.diagnosis, refined.rungs
        outputs.write(output, partial(write_model, found.model))
        if report is not None:
            again = f"vegrip refine {recording}" + (f" --model {model}" if model is not None else "")
            again += f" --hold-back {hold_back}" if hold_back else ""
            outputs.write(
                report,
                partial(_write_report, rungs, account(found, recording, [again], next_experiment(found))),
            )
        _terminal.answer(
            ladder.as_json(refined), lambda: _print_parts(ladder.parts(refined)), as_json=as_json
        )


def _write_report(rungs: "list[Rung]", printed: dict[str, Any], folder: Path) -> None:
    from vegrip.identification.diagnosis.error_ladder import draw_ladder

    draw_ladder(rungs, folder / "ladder.png")
    write_whole(folder / "report.json", json.dumps(printed, indent=2) + "\n")


MODEL = Annotated[Path | None, typer.Option("--model", help="Model file; else the paper's model is fitted.")]
VERSUS = Annotated[
    Path | None, typer.Option("--versus", help="A second model (file) or recording (folder) beside it.")
]
OUT = Annotated[Path | None, typer.Option("-o", "--output", metavar="DIR", help="Draw pictures into DIR.")]
CURVES = Annotated[
    bool,
    typer.Option("--curves", help="In the JSON: curves over time, residuals by regime and over variables."),
]


def compare(
    recording: _options.RECORDING,
    model: MODEL = None,
    versus: VERSUS = None,
    output: OUT = None,
    force: FORCE = False,
    zeros_each_episode: _options.EACH = False,
    tolerance: _options.TOLERANCE = 0.0,
    hold_back: _options.HOLD_BACK = "",
    only: _options.ONLY = "",
    as_json: _options.JSON = False,
    with_curves: CURVES = False,
) -> None:
    """Say how large the error of every channel is against its noise, and where the model fails.

    With --versus a second model, or a second recording under the same model, is shown beside.
    --episodes looks at some of the episodes alone, e.g. at those that a fit held back.

    Example: vegrip sample press && vegrip fit press -o base.toml
    && vegrip compare press --model base.toml -o pictures
    """
    from vegrip.display.comparison import FITTED, parts
    from vegrip.identification.compare import compare as compare_model
    from vegrip.identification.compare.plot import curves

    with Outputs(force=force) as outputs:
        outputs.pictures(output)
        pairs = [(recording, model)]
        if versus is not None:
            pairs.append((versus, model) if versus.is_dir() else (recording, versus))
        names = [file.stem if file is not None else FITTED for _, file in pairs]
        read = [opened(folder, file, hold_back=hold_back, only=only) for folder, file in pairs]
        with _terminal.progress("compare") as report:
            found = [
                compare_model(
                    measured, start, **judged(measured, tolerance, zeros_each_episode), report=report
                )
                for measured, start in read
            ]
        printed = [
            one.as_dict() | {"doubts": [doubt.text for doubt in doubted(one.problem)]} for one in found
        ]
        if with_curves:
            printed = [values | {"curves": curves(one)} for one, values in zip(found, printed, strict=True)]
        outputs.write(output, partial(_drawn, found, names))
        if as_json:
            _terminal.print_json(printed[0] | ({"versus": printed[1]} if len(printed) > 1 else {}))
            return
        for one, values, name in zip(found, printed, names, strict=True):
            _print_parts(parts(one, name if one.fitted else f"{name} as it is"))
            _terminal.print_sentences(values["doubts"])


def _drawn(found: "list[Comparison]", names: list[str], out: Path) -> None:
    from vegrip.identification.compare.plot import curves, draw_channels

    for i, (one, name) in enumerate(zip(found, names, strict=True)):
        title, folder = f"{one.recording.name}, {name}", out if i == 0 else out / "versus"
        files = draw_channels(title, {name: curves(one)}, folder)
        _terminal.printer(stderr=True).print(f"{len(files)} pictures in {files[0].parent}", soft_wrap=True)


def _print_parts(parts: "list[Part]") -> None:
    for part in parts:
        _terminal.printer().print(part)


def judged(
    recording: "Recording", tolerance: float, has_own_zeros: bool, has_own_laws: bool = False
) -> dict[str, Any]:
    """Return ``noise``, ``zeros`` and own ``laws``, by which every command decides what an error is."""
    from vegrip.identification.fit import excerpt, noise_of

    zeros = "episode" if has_own_zeros else "recording"
    laws = {"laws": "episode"} if has_own_laws else {}
    return {"noise": noise_of(excerpt(recording)).tolerant(tolerance), "zeros": zeros, **laws}


def error_options(has_own_zeros: bool, tolerance: float, has_own_laws: bool = False) -> list[str]:
    return [
        *["--zeros-each-episode"] * has_own_zeros,
        *["--laws-each-episode"] * has_own_laws,
        *(["--tolerance", f"{tolerance:g}"] if tolerance else []),
    ]


def opened(
    recording: Path, model: Path | None, *, hold_back: str = "", only: str = ""
) -> "tuple[Recording, ContactModel | None]":
    """Read a recording, all of it or some of its episodes, and, if there is one, a model."""
    from vegrip.identification.recording import read_recording
    from vegrip.identification.recording.checks import AIRLESS, is_airless
    from vegrip.identification.recording.data import select_episodes
    from vegrip.model import read_model

    start = read_model(model) if model is not None else None
    with _terminal.progress("read") as report:
        whole = read_recording(recording, progress=_terminal.counted(report))
    chosen = select_episodes(whole, only=only, without=hold_back)
    if chosen is not whole and is_airless(chosen.columns):
        log.warning("%s: %s", recording, AIRLESS)
    return chosen, start


def doubted(problem: "Problem") -> "list[Doubt]":
    """Return what is wrong with the recording itself."""
    from vegrip.identification.diagnosis.data_checks import check_before_search, refuse_unusable

    refuse_unusable(problem.measured.recording, problem.measured)
    return list(check_before_search(problem))


def print_fit(fit: "Fit") -> None:
    """Print values with their standard errors, errors by channel, and warnings."""
    from vegrip.display.fit import parts

    _print_parts(parts(fit))
    printed = fit.as_dict()
    print_noise(printed["noise"])
    _terminal.print_sentences([*printed["warnings"], *([fit.laws_note] if fit.laws else [])])


def print_noise(noise: dict[str, Any]) -> None:
    """Say how large the noise of every channel was taken to be, and where that comes from."""
    console = _terminal.printer()
    for channel, source in noise["source"].items():
        size = f"{noise[channel]:.3g}, " if noise.get(channel) else ""
        slow = f", {noise['slow_time']:.2g} s" if channel == "slow_force" and noise["slow_force"] else ""
        console.print(f"noise of {channel}: {size}{source}{slow}")
    if noise.get("tolerance"):
        console.print(f"and {100.0 * noise['tolerance']:.3g} % of each episode's peak force, as asked for")
