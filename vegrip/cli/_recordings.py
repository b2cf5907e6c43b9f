"""How the command line shows a recording."""

from pathlib import Path

from rich.text import Text

from vegrip.cli._terminal import print_sentences, printer
from vegrip.display.recording import describe, size_of, table_of_columns
from vegrip.display.text import printable
from vegrip.identification.recording import Recording


def print_recording(recording: Recording, folder: Path) -> None:
    """Print the columns with their ranges, and everything that was found while reading."""
    console, about = printer(), describe(recording)
    console.print(
        Text(printable(str(folder)), style="bold") + Text(printable(f": {size_of(about)}"), "not bold")
    )
    console.print(table_of_columns(about))
    console.print(recording.report.summary())
    print_sentences(about["lacking"])
