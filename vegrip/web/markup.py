"""Cards, tables and lists of pages and reports. Pure; all text but :class:`Markup` is escaped."""

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any


class Markup(str):
    """Text that is HTML already."""

    __slots__ = ()


def section(heading: str, *content: str) -> str:
    return f'<section class="card"><h2>{escape(heading)}</h2>{"".join(content)}</section>'


def facts(rows: Mapping[str, object]) -> str:
    cells = "".join(
        f"<tr><td>{escape(name)}</td><td>{escape(str(value))}</td></tr>" for name, value in rows.items()
    )
    return f'<table class="facts">{cells}</table>'


def table(
    head: Sequence[str],
    rows: Sequence[Sequence[object]],
    *,
    numbers: Sequence[int] = (),
    identifier: str = "",
    kind: str = "",
) -> str:
    """Return a table of this ``id`` and CSS class; columns at the places ``numbers`` are aligned right."""

    def cell(tag: str, place: int, value: object) -> str:
        text = value if isinstance(value, Markup) else escape(str(value))
        return f"<{tag}{' class=num' if place in numbers else ''}>{text}</{tag}>"

    lines = [("th", head), *(("td", row) for row in rows)]
    body = "".join(f"<tr>{''.join(cell(tag, i, v) for i, v in enumerate(line))}</tr>" for tag, line in lines)
    attributes = (f' class="{kind}"' if kind else "") + (f' id="{identifier}"' if identifier else "")
    return f'<div class="scroll"><table{attributes}>{body}</table></div>'


def listed(texts: Sequence[str]) -> str:
    return "<ul>" + "".join(f"<li>{escape(text)}</li>" for text in texts) + "</ul>" if texts else ""


def commands(lines: Sequence[str]) -> str:
    return "".join(f'<pre class="command">{escape(line)}</pre>' for line in lines)


def spread(one: Mapping[str, Any], which: str) -> str:
    return f"{100.0 * one[which]:.3g} %" if one["scale"] == "log" else f"{one[which]:.2g}"


def unit_name(unit: str | None) -> str:
    return "" if unit in (None, "1") else str(unit)


def disabled(is_busy: bool) -> str:
    return "disabled" if is_busy else ""


STYLE = Path(__file__).parent / "static" / "page.css"

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
    style = STYLE.read_text(encoding="utf-8")
    return PAGE.format(title=escape(title), style=style, body=body, foot=escape(foot))


def told_versions(versions: Mapping[str, Any]) -> str:
    return "made with " + ", ".join(f"{name} {number}" for name, number in versions.items())
