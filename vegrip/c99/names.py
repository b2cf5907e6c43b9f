"""Names that C has taken, and how long lines are broken."""

import textwrap

RESERVED = frozenset(
    """
    auto break case char const continue default do double else enum extern float for goto if inline int long
    register restrict return short signed sizeof static struct switch typedef union unsigned void volatile
    while _Bool bool true false NAN INFINITY isnan isinf isfinite int32_t int64_t uint32_t
    asm near far interrupt main class new delete this template typename private public protected
    """.split()  # noqa: SIM905 (a table to read)
)
LINE_WIDTH = 110
INDENT = "    "


def local(name: str) -> str:
    return f"{name}_c" if name in RESERVED else name


def joined(prefix: str, name: str) -> str:
    return f"{prefix}_{name.strip('_')}"


def comment(text: str) -> list[str]:
    lines = [line.rstrip() for line in text.strip().replace("*/", "* /").splitlines()]
    first = [f"/* {lines[0]}", *(f" * {line}".rstrip() for line in lines[1:])]
    if len(first) == 1 and len(first[0]) + 3 <= LINE_WIDTH:
        return [f"{first[0]} */"]
    return [*first[:-1], f"{first[-1]} */"]


def broken(line: str) -> list[str]:
    """Break a line of code that is too long, at spaces."""
    if len(line) <= LINE_WIDTH or line.lstrip().startswith(("#", "/*", "*")):
        return [line]
    indent = line[: len(line) - len(line.lstrip())]
    return textwrap.wrap(
        line.strip(),
        LINE_WIDTH,
        initial_indent=indent,
        subsequent_indent=indent + 2 * INDENT,
        break_long_words=False,
        break_on_hyphens=False,
    )
