"""Options and arguments that commands share, so that they read alike everywhere."""

from pathlib import Path
from typing import Annotated

import typer

JSON = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]

RECORDING = Annotated[Path, typer.Argument(help="Folder of a recording.")]

START_MODEL = Annotated[
    Path | None, typer.Option("--model", help="Model file to start from; else the paper's model.")
]
"""A model that is fitted further, or added to."""

REFITTED_MODEL = Annotated[
    Path | None, typer.Option("--model", help="Model file; else the paper's model. It is refitted.")
]
"""A model from which a diagnosis begins."""

MODEL_OUT = Annotated[Path | None, typer.Option("-o", "--output", help="Model file to write.")]

EACH = Annotated[
    bool,
    typer.Option("--zeros-each-episode", help="Zeros of displacement and force differ between episodes."),
]
EACH_LAW = Annotated[
    bool,
    typer.Option(
        "--laws-each-episode",
        help="Stiffness and relaxation differ between episodes: other places or specimens.",
    ),
]
TOLERANCE = Annotated[
    float,
    typer.Option(
        min=0.0, max=1.0, help="Share of an episode's peak force by which a model may be wrong, e.g. 0.01."
    ),
]
PORT = Annotated[int, typer.Option(min=0, max=65535, help="of the page; 0 = any free one")]
OPENS = Annotated[bool, typer.Option("--open", help="open the page in the browser")]
SET = Annotated[list[str] | None, typer.Option("--set", help="KEY=VALUE, e.g. transport.channel=can0.")]
NODE_NAME = Annotated[
    str, typer.Argument(help="Name of a running node, e.g. grasp_force or /left/grasp_force.")
]
HOLD_BACK = Annotated[
    str,
    typer.Option("--hold-back", metavar="EPISODES", help="Leave these episodes out, as in 2,5..7."),
]
ONLY = Annotated[
    str, typer.Option("--episodes", metavar="EPISODES", help="Take these episodes alone, as in 2,5..7.")
]


def group(text: str) -> typer.Typer:
    return typer.Typer(add_completion=False, pretty_exceptions_enable=False, no_args_is_help=True, help=text)
