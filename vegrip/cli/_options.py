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
