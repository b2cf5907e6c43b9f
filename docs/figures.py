"""Figures of the prose: written by the command that measures them, and compared with the pages.

``python docs/figures.py NAME`` runs the command of ``figures.toml`` and writes what it measured; what pages
must say is printed. ``make docs`` compares.
"""

import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
EXTREMES = {"least": min, "largest": max}
TABLE = Path(__file__).with_name("figures.toml")


def stale_figures() -> Iterator[str]:
    """Sentences of the table that do not stand on their page."""
    for name, figure in tomllib.loads(TABLE.read_text(encoding="utf-8")).items():
        values = {key: value for key, (_, _, value) in figure["values"].items()}
        for page, sentences in figure["pages"].items():
            text = " ".join((ROOT / page).read_text(encoding="utf-8").split())
            for sentence in sentences:
                said = sentence.format(**values)
                if said not in text:
                    command = " ".join(figure["command"])
                    yield f"{page}: does not say {said!r} ({name} of docs/figures.toml, by {command})"


def value_at(answer: Any, path: str) -> Any:
    """Return what stands at ``path`` of the answer; ``least`` and ``largest``: of what stands before them."""
    for part in path.split("/"):
        if part in EXTREMES:
            answer = EXTREMES[part](answer.values() if isinstance(answer, dict) else answer)
        else:
            answer = answer[part]
    return answer


def written(value: Any, form: str) -> str:
    """Return ``value`` as the prose has it; ``count`` is a number of things, of which there may be none."""
    if form == "count":
        return str(value or "none")
    return f"{value:{form}}".replace("%", " %")


def measure(name: str) -> None:
    """Run the command of ``name``, and write its values into the table."""
    text = TABLE.read_text(encoding="utf-8")
    figure = tomllib.loads(text)[name]
    done = subprocess.run(figure["command"], stdout=subprocess.PIPE, text=True, check=False)  # a goal missed
    answer = json.loads(done.stdout)
    for key, (path, form, before) in figure["values"].items():
        line = rf'^({key} = \["{re.escape(path)}", "{re.escape(form)}", )"{re.escape(before)}"'
        now = written(value_at(answer, path), form)
        text = re.sub(line, rf'\g<1>"{now}"', text, flags=re.MULTILINE)
    TABLE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    for each in sys.argv[1:]:
        measure(each)
    sys.stdout.write("\n".join(stale_figures()) + "\n")
