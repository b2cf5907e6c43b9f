"""The numbers of the estimator of friction, from the comments beside them."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2] / "vegrip"
FILES = (
    "estimator/friction_prior.py",
    "estimator/kernels/load_law.py",
    "grip/friction_numbers.py",
    "grip/friction_settings.py",
    "grip/grasp_friction.py",
    "grip/known_objects.py",
    "grip/kernels/friction_shared.py",
    "estimator/kernels/friction.py",
)
COMMENTED = re.compile(r"^([A-Z][A-Z_\d]+)(?:: Final)? = [^#\n]+  # (.+)$", re.MULTILINE)


def page() -> str:
    """Return the page as Markdown."""
    lines = ["# Constants of friction", "", "Numbers of [friction and slip](../friction.md).", ""]
    for file in FILES:
        lines += [f"## `{file}`", "", "| name | value | meaning |", "|---|---|---|", *rows(ROOT / file), ""]
    return "\n".join(lines)


def rows(source: Path) -> Iterator[str]:
    """Yield a row for each number in ``source`` that a comment or a text below it explains."""
    text = source.read_text(encoding="utf-8")
    about = dict(COMMENTED.findall(text))
    body = ast.parse(text).body
    for node, below in zip(body, [*body[1:], None], strict=True):
        match node:
            case ast.Assign(targets=[ast.Name(id=name)], value=value):
                pass
            case ast.AnnAssign(target=ast.Name(id=name), value=ast.expr() as value):
                pass
            case _:
                continue
        match below:
            case ast.Expr(value=ast.Constant(value=str() as told)):
                about.setdefault(name, " ".join(told.split()))
        if name in about and isinstance(value, ast.Constant | ast.BinOp | ast.Name):
            meaning = about[name].replace("|", "\\|")
            yield f"| `{name}` | {ast.unparse(value)} | {meaning} |"
