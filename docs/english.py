"""The project's English: one spelling, and sentences that name who acts.

Pages, docstrings and comments are checked; identifiers, quoted code and titles in ``references.md`` are not.
"""

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

SPELLINGS = {
    # American: British
    r"behavior": "behaviour",
    r"neighbor": "neighbour",
    r"colors?\b(?!=)": "colour",
    r"centers?\b": "centre",
    r"centered\b": "centred",
    r"fibers?\b": "fibre",
    r"gray\b": "grey",
    r"favor": "favour",
    r"catalogs?\b": "catalogue",
    r"label(ed|ing)\b": "labelled, labelling",
    r"model(ed|ing)\b": "modelled, modelling",
    r"cancel(ed|ing)\b": "cancelled, cancelling",
    r"travel(ed|ing)\b": "travelled, travelling",
    r"analyz": "analyse",
    r"\w+(?<!s)(?<!pr)iz(e|es|ed|er|ing|ation)\b": "-ise, -isation",
}
KEPT = {
    "size",
    "sizes",
    "sized",
    "resize",
    "resized",
    "oversized",
    "prize",
    "seize",
    "seized",
    "bitsize",
    "finalized",
}  # the last is a state of ROS 2
NAMELESS = r"(who(m?)ever|somebody|nobody|anybody|everybody|someone|anyone|everyone)\b"
QUOTED = re.compile(r"```.*?```|``.*?``|`[^`\n]*`|https?://\S+|<[^>\n]*>", re.DOTALL)


def complaints(text: str) -> Iterator[tuple[int, str]]:
    """Yield (position, what is wrong) for the prose in ``text``."""
    prose = QUOTED.sub(lambda quoted: re.sub(r"[^\n]", " ", quoted[0]), text)
    for pattern, better in [*SPELLINGS.items(), (NAMELESS, "say who: the node, a reader")]:
        for found in re.finditer(rf"(?<![\w.])(?:{pattern})", prose, re.IGNORECASE):
            if found[0].lower() not in KEPT:
                yield found.start(), f"{found[0]!r}: {better}"


def prose_of(source: Path) -> Iterator[tuple[int, str]]:
    """Yield (line, text) of the docstrings and comments of a Python file."""
    text = source.read_text(encoding="utf-8")
    for node in ast.walk(ast.parse(text)):
        match node:
            case ast.Expr(value=ast.Constant(value=str() as docstring)):
                yield node.lineno, docstring
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string
