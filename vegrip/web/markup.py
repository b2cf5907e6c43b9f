"""Cards, tables and lists of pages and reports. Pure; all text but :class:`Markup` is escaped."""

from collections.abc import Collection, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any


class Markup(str):
    """Text that is HTML already."""

    __slots__ = ()


def section(heading: str, *content: str, kind: str = "card", **given: object) -> str:
    return (
        f"<section{attributes(class_=kind, **given)}><h2>{escape(heading)}</h2>{''.join(content)}</section>"
    )


def huge_error(error: float) -> str:
    return f'<p class="huge">{error:.2f} <small>times the noise (1 is all that noise allows)</small></p>'


def attributes(**given: object) -> str:
    """Return attributes of an element, ``_`` for ``-``; empty, false and absent ones are left out."""
    renamed = {name.strip("_").replace("_", "-"): value for name, value in given.items()}
    kept = [
        (name, value)
        for name, value in renamed.items()
        if not (value is None or value is False or value == "")
    ]
    return "".join(f" {n}" if value is True else f' {n}="{escape(str(value))}"' for n, value in kept)


def button(text: str, do: str, *, is_busy: bool, **given: object) -> str:
    return f'<button type="button"{attributes(data_do=do, disabled=is_busy, **given)}>{text}</button>'


def entry(label: str, name: str, *, is_busy: bool, **given: object) -> str:
    return f"<label>{label} <input{attributes(name=name, disabled=is_busy, **given)}></label>"


def choice(label: str, name: str, options: str, *, is_busy: bool, **given: object) -> str:
    return (
        f"<label>{label} <select{attributes(name=name, disabled=is_busy, **given)}>{options}</select></label>"
    )


def form(do: str, submit: str, *fields: str, is_busy: bool, kind: str = "") -> str:
    sends = f"<button{attributes(class_=kind, disabled=is_busy)}>{submit}</button>"
    return f'<form data-do="{do}" class="inline">{"".join(fields)}{sends}</form>'


def legend(*lines: tuple[str, str]) -> str:
    """Return what the lines of a figure are: colour (``colour dash`` for a dashed one) and words."""
    entries = (
        f"<span><i{attributes(class_=kind, style=f'border-color:var(--{colour})')}></i>{escape(text)}</span>"
        for (colour, _, kind), text in ((name.partition(" "), text) for name, text in lines)
    )
    return f'<div class="legend">{"".join(entries)}</div>'


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
    named: Collection[int] = (),
) -> str:
    """Return a table of this ``id`` and CSS class.

    Columns at the places ``numbers`` are aligned right; rows at the places ``named``, from 1, stand out.
    """

    def cell(tag: str, place: int, value: object) -> str:
        text = value if isinstance(value, Markup) else escape(str(value))
        label = head[place] if tag == "td" and place > 0 else ""  # where a narrow screen has no header
        return (
            f"<{tag}{attributes(class_='num' if place in numbers else '', data_label=label)}>{text}</{tag}>"
        )

    lines = [("th", head), *(("td", row) for row in rows)]
    body = "".join(
        f"<tr{attributes(class_='named' if row in named else '')}>"
        f"{''.join(cell(tag, i, v) for i, v in enumerate(line))}</tr>"
        for row, (tag, line) in enumerate(lines)
    )
    given = attributes(class_=f"stacks {kind}".strip(), id=identifier)
    return f'<div class="scroll"><table{given}>{body}</table></div>'


def listed(texts: Sequence[str]) -> str:
    return "<ul>" + "".join(f"<li>{escape(text)}</li>" for text in texts) + "</ul>" if texts else ""


def commands(lines: Sequence[str]) -> str:
    return "".join(f'<pre class="command">{escape(line)}</pre>' for line in lines)


def spread(one: Mapping[str, Any], which: str) -> str:
    return f"{100.0 * one[which] / one['value']:.3g} %" if one["scale"] == "log" else f"{one[which]:.2g}"


def unit_name(unit: str | None) -> str:
    return "" if unit in (None, "1") else str(unit)


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


def versions_line(versions: Mapping[str, Any]) -> str:
    return "made with " + ", ".join(f"{name} {number}" for name, number in versions.items())
