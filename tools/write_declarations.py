"""Write ``generated.pyi`` beside the kernels: what they find in a generated module, for type checkers.

Usage: ``python -m tools.write_declarations``; ``make types`` runs it. The kernels are ordinary files, to be
read, linted and typed; nothing imports them. Their text, without the imports from vegrip, is appended to the
generated module of a model, where these names have that model's values.
"""

import ast
from collections.abc import Iterable, Iterator
from pathlib import Path

import vegrip
from vegrip.estimator.layout import NAMED, layout_of
from vegrip.grip.compiled import constants
from vegrip.grip.layout import FingerLayout
from vegrip.model import paper_model
from vegrip.transport.codec.kernel_text import wire_text

ROOT = Path(vegrip.__file__).parent
LAYOUT = layout_of(paper_model(1e-2))  # the names are the same for every model
ARRAYS = {"f": "Floats", "t": "Wholes", "data": "Bytes"}
HEAD = """from typing import Any
import numpy as np
from numpy.typing import NDArray
from vegrip.contact.limit_surface.fast import gauge as gauge
from vegrip.contact.limit_surface.fast import radius_gradient_towards as radius_gradient_towards
from vegrip.contact.limit_surface.fast import torsion_gradient as torsion_gradient
from vegrip.grip.grasp_memory import GraspMemory as GraspMemory
from vegrip.model.generated import advance as advance, read_radius as read_radius, readout as readout
Bytes = NDArray[np.uint8]
"""
Section = tuple[str, tuple[str, ...], int]


def declarations() -> str:
    """Return the text for the kernels of the estimator and of the grip, which see one module."""
    finger = FingerLayout(LAYOUT, late=1, history=1, is_shared=True)
    parts = LAYOUT.sections().items()
    filters: list[Section] = [(name, NAMED[name][1] if name in NAMED else (), n) for name, n in parts]
    classes = [
        *_class("Floats", "np.float64", "float", [*filters, *finger.real_sections()]),
        *_class("Wholes", "np.int64", "int", finger.whole_sections()),
    ]
    texts = [LAYOUT.constants(), finger.constants(), constants(), wire_text()]
    return "\n".join([HEAD, *classes, *(line for text in texts for line in _declared(text)), ""])


def _class(name: str, item: str, kind: str, sections: Iterable[Section]) -> Iterator[str]:
    """Yield an array whose sections have names, and in them their numbers."""
    own = []
    for section, names, _ in sections:
        if names:
            yield f"class _{section}:"
            yield from (f"    {one.lower()}: {kind}" for one in names)
            yield f"    def __getitem__(self, place: int) -> {kind}: ..."
            yield f"    def __setitem__(self, place: int, value: {kind}) -> None: ..."
        own.append(f"    {section.lower()}: {f'_{section}' if names else f'NDArray[{item}]'}")
    yield from [f"class {name}(np.ndarray[Any, np.dtype[{item}]]):", *own]


def _declared(text: str) -> Iterator[str]:
    tree = ast.parse(text)
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            takes = ", ".join(f"{one.arg}: {ARRAYS.get(one.arg, 'float')}" for one in node.args.args)
            yield f"def {node.name}({takes}) -> Any: ..."
        elif isinstance(node, ast.Assign):
            yield f"{ast.unparse(node.targets[0])}: {_type(node.value)}"


def _type(value: ast.expr) -> str:
    if isinstance(value, ast.Call):
        return "NDArray[np.int64]"
    found = ast.literal_eval(value)
    return f"tuple[{type(found[0]).__name__}, ...]" if isinstance(found, tuple) else type(found).__name__


def main() -> None:
    """Write both."""
    for room, text in {
        "estimator": declarations(),
        "grip": "from vegrip.estimator.kernels.generated import *\n",
    }.items():
        ROOT.joinpath(room, "kernels", "generated.pyi").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
