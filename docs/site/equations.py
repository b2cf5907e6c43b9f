"""Equations as MathML, which browsers draw without a script or a font from elsewhere."""

import html
from typing import Any

from latex2mathml.converter import convert


def display(source: str, language: str, css_class: str, options: dict[str, Any], md: Any, **_: Any) -> str:  # noqa: ARG001
    """Return the LaTeX of a ``math`` block as MathML: a formatter of ``pymdownx.superfences``."""
    return f'<div class="{html.escape(css_class)}">{convert(source.strip(), display="block")}</div>'
