"""The card of a notebook: HTML with its style and inline SVG, and no script."""

import re
from html import escape
from pathlib import Path
from string import Template

from vegrip.web.markup import STYLE, section

# of the style sheet of the pages, light and dark
PALETTES = (r"^:root \{(.*?)\}", r'^:root\[data-theme="dark"\] \{(.*?)\}')
RULES = Path(__file__).with_name("card.css")


def framed(*content: str) -> str:
    """Return ``content`` as a card that looks the same wherever it stands."""
    sheet = STYLE.read_text(encoding="utf-8")
    light, dark = ("".join(re.findall(one, sheet, re.DOTALL | re.MULTILINE)) for one in PALETTES)
    style = Template(RULES.read_text(encoding="utf-8")).substitute(light=light, dark=dark)
    return f'<div class="vegrip"><style>{style}</style>{"".join(content)}</div>'


def verdict(heading: str, level: str, name: str, huge: str, *content: str) -> str:
    """Return a card with a chip of ``level`` (ok, warn, bad, unknown) and the figure that matters."""
    chip = f'<p><span class="chip {level}">{escape(name)}</span></p>' if name else ""
    figure = f'<p class="huge">{huge}</p>' if huge else ""
    return framed(section(heading, chip, figure, *content, kind=""))


def times_noise(text: str) -> str:
    return f"{text} <small>times the noise (1 is all that noise allows)</small>"
