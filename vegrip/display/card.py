"""The card of a notebook: HTML with its style and inline SVG, and no script."""

import re
from html import escape

from vegrip.web.markup import STYLE, section

# of the style sheet of the pages, light and dark
PALETTES = (r"^:root \{(.*?)\}", r'^:root\[data-theme="dark"\] \{(.*?)\}')
# as the pages look; `div.vegrip` in front is more than what a notebook says of its tables
RULES = """
div.vegrip { max-width: 1000px; padding: 12px 16px; border: 1px solid var(--line); border-radius: 10px;
  background: var(--card); color: var(--ink); font: 14px/1.45 system-ui, sans-serif; }
div.vegrip section { margin: 0; } div.vegrip p { margin: 4px 0; }
div.vegrip h2 { font-size: 13px; margin: 0 0 6px; color: var(--soft); }
div.vegrip .soft, div.vegrip small { color: var(--soft); }
div.vegrip .huge { font-size: 26px; margin: 4px 0; }
div.vegrip .huge small { font-size: 13px; }
div.vegrip .chip { display: inline-block; border: 1px solid currentColor; border-radius: 99px;
  padding: 0 10px; }
div.vegrip .ok { color: var(--green); } div.vegrip .warn { color: var(--orange); }
div.vegrip .bad { color: var(--red); } div.vegrip .unknown { color: var(--soft); }
div.vegrip table { border-collapse: collapse; margin: 6px 0; font-size: 13px; }
div.vegrip table tr:nth-child(n) { background: none; }
div.vegrip table th, div.vegrip table td { padding: 2px 16px 2px 0; text-align: left; color: var(--ink);
  background: none; border: 0; border-bottom: 1px solid var(--line); }
div.vegrip table th { color: var(--soft); font-weight: 600; }
div.vegrip table .num { text-align: right; white-space: nowrap; }
div.vegrip svg { display: block; margin: 6px 0; } div.vegrip svg text { font-size: 12px; fill: var(--soft); }
div.vegrip svg[viewBox^="0 0 1300"] text { font-size: 15px; }
div.vegrip svg .axis { stroke: var(--line); fill: none; } div.vegrip svg text.bad { fill: var(--red); }
div.vegrip .legend { font-size: 12px; color: var(--soft); } div.vegrip .legend span { margin-right: 14px; }
div.vegrip .legend i { display: inline-block; width: 18px; border-top: 3px solid; margin-right: 5px;
  vertical-align: middle; } div.vegrip .legend i.dash { border-top-style: dashed; }
div.vegrip .legend i.area { height: 9px; border: 0; background: var(--measured); }
"""


def framed(*content: str) -> str:
    """Return ``content`` as a card that looks the same wherever it stands."""
    sheet = STYLE.read_text(encoding="utf-8")
    light, dark = ("".join(re.findall(one, sheet, re.DOTALL | re.MULTILINE)) for one in PALETTES)
    by_scheme = f"div.vegrip {{{light}}} @media (prefers-color-scheme: dark) {{ div.vegrip {{{dark}}} }}"
    return f'<div class="vegrip"><style>{by_scheme}{RULES}</style>{"".join(content)}</div>'


def verdict(heading: str, level: str, name: str, huge: str, *content: str) -> str:
    """Return a card with a chip of ``level`` (ok, warn, bad, unknown) and the figure that matters."""
    chip = f'<p><span class="chip {level}">{escape(name)}</span></p>' if name else ""
    figure = f'<p class="huge">{huge}</p>' if huge else ""
    return framed(section(heading, chip, figure, *content, kind=""))


def times_noise(text: str) -> str:
    return f"{text} <small>times the noise (1 is all that noise allows)</small>"
