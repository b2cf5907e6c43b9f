"""Write ``generated.pyi`` beside the kernels: what they find in a generated module, for type checkers.

Usage: ``python -m tools.write_declarations``; ``make types`` runs it. The kernels are ordinary files, to be
read, linted and typed; nothing imports them. Their text, without the imports from vegrip, is appended to the
generated module of a model, where these names have that model's values.
"""

import ast
from collections.abc import Iterator
from pathlib import Path

import vegrip
from vegrip.estimator.layout import layout_of
from vegrip.estimator.memory import SampleLayout
from vegrip.grip.compiled import constants
from vegrip.grip.layout import FingerLayout
from vegrip.model import paper_model
from vegrip.transport.codec.kernel_text import wire_text
from vegrip.transport.codec.part_text import part_text

ROOT = Path(vegrip.__file__).parent
ARRAYS = {"f": "Floats", "t": "Wholes", "data": "Bytes"}
HEADS = {
    "estimator": """import numpy as np
from numpy.typing import NDArray
from vegrip.contact.limit_surface.fast import gauge as gauge
from vegrip.contact.limit_surface.fast import radius_gradient_towards as radius_gradient_towards
from vegrip.contact.limit_surface.fast import torsion_gradient as torsion_gradient
from vegrip.model.generated import Floats as Floats, advance as advance, readout as readout
Wholes = NDArray[np.int64]
""",
    "grip": """import numpy as np
from typing import Any
from numpy.typing import NDArray
from vegrip.estimator.kernels.generated import *
Bytes = NDArray[np.uint8]
""",
}


def declarations(room: str) -> str:
    """Return the text for the kernels of a room; the names are the same for every model."""
    layout = layout_of(paper_model(1e-2))
    texts = [layout.constants(), SampleLayout(layout).constants()]
    if room == "grip":
        finger = FingerLayout(layout, is_shared=True, part_bytes=1).constants()
        known, texts = texts, [finger, constants(), wire_text(), part_text()]
    else:
        known = []
    before = {line for text in known for line in _declared(text)}
    lines = [line for text in texts for line in _declared(text) if line not in before]
    return "\n".join([HEADS[room], *lines, ""])


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
    for room in HEADS:
        ROOT.joinpath(room, "kernels", "generated.pyi").write_text(declarations(room), encoding="utf-8")


if __name__ == "__main__":
    main()
