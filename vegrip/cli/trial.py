"""``vegrip trial``: blind recordings with the truth apart, and the score of answers to them."""

import secrets
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vegrip.cli._options import JSON
from vegrip.cli._outputs import FORCE, Outputs
from vegrip.cli._terminal import answer, figures, print_next, progress, show
from vegrip.cli.bench import from_source
from vegrip.errors import UsageError

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


def trial(
    truth: TRUTH,
    folder: FOLDER = None,
    recordings: COUNT = None,
    seed: SEED = None,
    score: SCORE = None,
    jobs: JOBS = 1,
    force: FORCE = False,
    as_json: JSON = False,
) -> None:
    """Make blind recordings, what is hidden in them in a file apart; or score answers to them.

    An answer is exactly right, or a set that holds what is there, which counts as one draw from it would.

    Example: vegrip trial blind --truth hidden.json -n 1 --seed 6

    To make recordings needs a checkout; vegrip trial --score answers.json --truth hidden.json does not.
    """
    if (folder is None) == (not score):
        raise UsageError("give a folder to make recordings in, or --score ANSWERS")
    if folder is not None:
        _make(folder, truth, recordings or 60, seed, jobs, force=force)
        return
    from vegrip.identification.blind import read_answers, read_truths
    from vegrip.identification.blind import score as score_answers

    truths, effects = read_truths(truth)
    asked = dict(list(truths.items())[:recordings])
    told = {str(path): score_answers(asked, read_answers(path, truths, effects)) for path in score or ()}
    answer(told, lambda: show(_table(told)), as_json=as_json)


def _make(folder: Path, truth: Path, count: int, seed: int | None, jobs: int, *, force: bool) -> None:
    maker = from_source(
        "validation.diagnosis_trials.blind", "what makes recordings is", "run this in a checkout"
    )
    if folder.resolve() in truth.resolve().parents:
        raise UsageError(f"{truth}: lies in the folder that is given away; give a file elsewhere")
    with Outputs(force=force) as outputs:
        outputs.folder(folder)
        outputs.file(truth)
        with progress("trial") as report:
            maker.make_blind(
                folder, truth, count, secrets.randbits(64) if seed is None else seed, jobs, report
            )
    print_next("vegrip", "trial", "--score", "answers.json", "--truth", truth)


def _table(told: dict[str, dict[str, Any]]) -> "Table":
    kinds = {"none": "nothing", "one": "one", "pair": "two", "outside": "in no catalogue"}
    head = ("answers", "score", *kinds.values(), "falsely named", "bias of p", "seconds")
    table = figures(*head, left=("answers",))
    for path, one in told.items():
        parts = [f"{one['kinds'][kind]['points']:.3g} of {one['kinds'][kind]['of']}" for kind in kinds]
        means = (f"{one['bias']:.3f}", f"{one['seconds']:.1f}")
        table.add_row(Path(path).stem, f"{one['score']:.1%}", *parts, str(one["falsely_named"]), *means)
    return table
