"""A report as one file: the style sheet and the drawings are in it, nothing is loaded from anywhere. Pure."""

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

STYLE = Path(__file__).parents[1] / "static" / "page.css"

PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
{style}</style>
</head>
<body class="report">
<header class="top"><h1><b>vegrip</b> report <span class="soft">{title}</span></h1></header>
<main>
{body}
</main>
<footer>{foot}</footer>
</body>
</html>
"""


def document(title: str, body: str, foot: str) -> str:
    """Return the whole file."""
    style = STYLE.read_text(encoding="utf-8")
    return PAGE.format(title=escape(title), style=style, body=body, foot=escape(foot))


def section(heading: str, *content: str) -> str:
    """Return one part of the report."""
    return f'<section class="card"><h2>{escape(heading)}</h2>{"".join(content)}</section>'


def facts(rows: Mapping[str, object]) -> str:
    """Return names and values, one pair a line."""
    cells = "".join(
        f"<tr><td>{escape(name)}</td><td>{escape(str(value))}</td></tr>" for name, value in rows.items()
    )
    return f'<table class="facts">{cells}</table>'


def table(head: Sequence[str], rows: Sequence[Sequence[object]], *, numbers: Sequence[int] = ()) -> str:
    """Return a table; columns at the places ``numbers`` are aligned right."""

    def cell(tag: str, place: int, value: object) -> str:
        return f"<{tag}{' class=num' if place in numbers else ''}>{escape(str(value))}</{tag}>"

    lines = [("th", head), *(("td", row) for row in rows)]
    body = "".join(f"<tr>{''.join(cell(tag, i, v) for i, v in enumerate(line))}</tr>" for tag, line in lines)
    return f'<div class="scroll"><table>{body}</table></div>'


def listed(texts: Sequence[str]) -> str:
    """Return sentences, one a line."""
    return "<ul>" + "".join(f"<li>{escape(text)}</li>" for text in texts) + "</ul>" if texts else ""


def commands(lines: Sequence[str]) -> str:
    """Return commands to be copied."""
    return "".join(f'<pre class="command">{escape(line)}</pre>' for line in lines)


def told_versions(versions: Mapping[str, Any]) -> str:
    """Return versions as one line."""
    return "made with " + ", ".join(f"{name} {number}" for name, number in versions.items())
