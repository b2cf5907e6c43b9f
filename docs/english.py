"""The project's English: one spelling, and sentences that name who acts.

Pages, docstrings and comments are checked; identifiers, and quoted code are not.
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


PRIVATE = {
    # word of ours: the field's word; in messages, which are read without the pages beside them
    r"(tells?|told)\b": "report, show, say, distinguish",
    r"(heard|hears?)\b": "received, accepts",
    r"let(s|ting)? go( of)?\b": "lower, unload, release",
    r"(rid(e|es|ing)|rode) out\b": "hold the last command",
    r"witness(es)?\b": "evidence",
    r"(untold|dear(er|est))\b": "not reported; expensive, large",
    r"wanted\b": "target, required",
    r"play\b(?! a\b)": "backlash; of a command: clearance",
    r"nothing to\b": "say what is missing, and what to do",
    r"(comes?|came) back\b": "recovers, returns",
}
LEAST_SPACES = 2
"""Texts with fewer are names and keys rather than messages."""


def complaints(text: str, *, message: bool = False) -> Iterator[tuple[int, str]]:
    """Yield (position, what is wrong) for the prose in ``text``; ``message``: those of PRIVATE too."""
    prose = QUOTED.sub(lambda quoted: re.sub(r"[^\n]", " ", quoted[0]), text)
    private = PRIVATE if message else {}
    for pattern, better in [*SPELLINGS.items(), *private.items(), (NAMELESS, "say who: the node, a reader")]:
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


def messages_of(source: Path) -> Iterator[tuple[int, str]]:
    """Yield (line, text) of what a Python file may show: raised, printed, logged, or said as help."""
    tree = ast.parse(source.read_text(encoding="utf-8"))
    skipped = {id(part) for node in ast.walk(tree) for part in _no_messages(node)}
    for node in ast.walk(tree):
        match node:
            case ast.Constant(value=str() as text) if id(node) not in skipped:
                if text.count(" ") >= LEAST_SPACES:
                    yield node.lineno, text


def _no_messages(node: ast.AST) -> Iterator[ast.expr]:
    """Yield docstrings, and places in a picture such as ``lower center``."""
    match node:
        case ast.Expr(value=ast.Constant() as docstring):
            yield docstring
        case ast.keyword(arg="loc", value=place):
            yield place
