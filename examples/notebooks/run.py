"""Run the notebooks of this folder as a user would, each in a folder of its own; a cell that fails ends it.

Usage: python examples/notebooks/run.py [FOLDER]

With a FOLDER the notebooks with their outputs are kept there.
"""

import sys
import tempfile
from pathlib import Path

import nbformat
from nbclient import NotebookClient

HERE = Path(__file__).parent
LONGEST_S = 300  # [s] of a cell


def run(notebook: Path, kept: Path | None) -> int:
    """Run a notebook; return how many pictures its cells show."""
    cells = nbformat.read(notebook, as_version=4)
    with tempfile.TemporaryDirectory() as folder:
        where = {"metadata": {"path": folder}}
        NotebookClient(cells, timeout=LONGEST_S, kernel_name="python3", resources=where).execute()
    if kept is not None:
        kept.mkdir(parents=True, exist_ok=True)
        nbformat.write(cells, kept / notebook.name)
    shown = [output.get("data", {}) for cell in cells.cells for output in cell.get("outputs", [])]
    return sum("image/png" in data or "<svg" in data.get("text/html", "") for data in shown)


def main() -> None:
    """Run all, and say what they show."""
    kept = Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else None
    for notebook in sorted(HERE.glob("*.ipynb")):
        pictures = run(notebook, kept)
        assert pictures >= 3, f"{notebook.name} shows only {pictures} pictures"
        print(f"{notebook.name}: {pictures} pictures and cards")


if __name__ == "__main__":
    main()
