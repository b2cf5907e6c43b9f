"""A report as one file: the style sheet and the drawings are in it, nothing is loaded from anywhere. Pure."""

from collections.abc import Mapping
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
    style = STYLE.read_text(encoding="utf-8")
    return PAGE.format(title=escape(title), style=style, body=body, foot=escape(foot))


def told_versions(versions: Mapping[str, Any]) -> str:
    return "made with " + ", ".join(f"{name} {number}" for name, number in versions.items())
