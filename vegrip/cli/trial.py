"""``vegrip trial``: blind recordings with the truth apart, and the score of answers to them."""

import secrets
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vegrip.cli._options import JSON
from vegrip.cli._outputs import FORCE, Outputs
from vegrip.cli._terminal import answer, print_next, progress, show
from vegrip.cli.bench import from_source
from vegrip.display.text import figures
from vegrip.errors import UsageError, suggestion

if TYPE_CHECKING:
    from rich.table import Table

FOLDER = Annotated[Path | None, typer.Argument(help="Folder for the recordings.")]
TRUTH = Annotated[Path, typer.Option("--truth", help="File of what is hidden: written, or read to score.")]
COUNT = Annotated[
    int | None,
    typer.Option(
        "--recordings", "-n", min=1, help="How many to make, 60 when not given; or to score, of the first."
    ),
]
SEED = Annotated[
    int | None, typer.Option("--seed", min=0, help="Of all that is drawn; a secret one when not given.")
]
SCORE = Annotated[
    list[Path] | None, typer.Option("--score", metavar="ANSWERS", help="File to score; may be repeated.")
]
JOBS = Annotated[int, typer.Option("--jobs", "-j", min=1, help="Recordings at a time.")]
STYLE = Annotated[str | None, typer.Option("--style", help="Of the motion: laboratory, short or use.")]
NOISE_STATED = Annotated[
    float, typer.Option("--noise-stated", min=0.01, help="Noise of the sensors as stated, over the true one.")
]
RADIUS_STATED = Annotated[
    float, typer.Option("--radius-stated", min=0.01, help="Radius of the tip as stated, over the true one.")
]
JITTER = Annotated[bool, typer.Option("--jitter", help="Take and stamp rows at uneven times.")]
GAPS = Annotated[bool, typer.Option("--gaps", help="Lose rows, tenths of a second at a time.")]
IN_CONTACT = Annotated[bool, typer.Option("--in-contact", help="Begin in the first contact.")]
ZERO_SHIFT = Annotated[
    bool, typer.Option("--zero-shift", help="Let the zero of force or displacement jump once.")
]


def trial(
    truth: TRUTH,
    folder: FOLDER = None,
    recordings: COUNT = None,
    seed: SEED = None,
    score: SCORE = None,
    style: STYLE = None,
    noise_stated: NOISE_STATED = 1.0,
    radius_stated: RADIUS_STATED = 1.0,
    jitter: JITTER = False,
    gaps: GAPS = False,
    in_contact: IN_CONTACT = False,
    zero_shift: ZERO_SHIFT = False,
    jobs: JOBS = 1,
    force: FORCE = False,
    as_json: JSON = False,
) -> None:
    """Make blind recordings, what is hidden in them in a file apart; or score answers to them.

    An answer is exactly right, or a set that holds what is there, which counts as one draw from it would.

    Example: vegrip trial blind --truth hidden.json -n 1 --style short

    To make recordings needs a checkout; vegrip trial --score answers.json --truth hidden.json does not.
    """
    if (folder is None) == (not score):
        raise UsageError("give a folder to make recordings in, or --score ANSWERS")
    if folder is not None:
        faults = {
            "noise_stated": noise_stated,
            "radius_stated": radius_stated,
            "jitter": jitter,
            "gaps": gaps,
            "in_contact": in_contact,
            "zero_shift": zero_shift,
        }
        _make(folder, truth, recordings or 60, seed, jobs, style, faults, force=force)
        return
    from vegrip.identification.blind import read_answers, read_truths
    from vegrip.identification.blind import score as score_answers

    truths, effects = read_truths(truth)
    asked = dict(list(truths.items())[:recordings])
    scores = {str(path): score_answers(asked, read_answers(path, truths, effects)) for path in score or ()}
    answer(scores, lambda: show(_table(scores)), as_json=as_json)


def _make(
    folder: Path,
    truth: Path,
    count: int,
    seed: int | None,
    jobs: int,
    style: str | None,
    faults: dict[str, float | bool],
    *,
    force: bool,
) -> None:
    maker = from_source(
        "validation.diagnosis_trials.blind", "what makes recordings is", "run this in a checkout"
    )
    if style is not None and style not in maker.STYLES:
        raise UsageError(f"there is no style {style!r}; {suggestion(style, maker.STYLES)}")
    if folder.resolve() in truth.resolve().parents:
        raise UsageError(f"{truth}: lies in the folder that is given away; give a file elsewhere")
    with Outputs(force=force) as outputs:
        outputs.folder(folder)
        outputs.file(truth)
        with progress("trial") as report:
            drawn = secrets.randbits(64) if seed is None else seed
            cases = maker.blind_cases(count, drawn, style, maker.Faults(**faults))
            maker.make_blind(folder, truth, cases, drawn, jobs, report)
    print_next("vegrip", "trial", "--score", "answers.json", "--truth", truth)


def _table(scores: dict[str, dict[str, Any]]) -> "Table":
    kinds = {"none": "nothing", "one": "one", "pair": "two", "outside": "in no catalogue"}
    head = ("answers", "score", *kinds.values(), "falsely named", "bias of p", "seconds")
    table = figures(*head, left=("answers",))
    for path, one in scores.items():
        parts = [f"{one['kinds'][kind]['points']:.3g} of {one['kinds'][kind]['of']}" for kind in kinds]
        means = (f"{one['bias']:.3f}", f"{one['seconds']:.1f}")
        table.add_row(Path(path).stem, f"{one['score']:.1%}", *parts, str(one["falsely_named"]), *means)
    return table
