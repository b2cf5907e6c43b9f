"""Write ``vegrip/estimator/kernels/generated.py``, the declarations of what a layout puts before the kernels.

Usage: ``python -m tools.write_declarations``; ``make format`` runs it. A test compares.
"""

from pathlib import Path

from vegrip.estimator import kernels
from vegrip.estimator.layout import layout_of
from vegrip.model import paper_model

FILE = Path(kernels.__file__).parent / "generated.py"

HEAD = '''"""What the kernels find in a generated module: the model, the gauge, sizes and places.

The kernels are ordinary files, to be read, linted and typed; nothing imports them. Their text, without the
imports from vegrip, is appended to the generated module of a model, where these names have that model's
values (:meth:`vegrip.estimator.layout.Layout.names`). This file declares them; it is written by
``python -m tools.write_declarations``.
"""

from vegrip.contact.limit_surface.fast import gauge, radius_gradient_towards, torsion_gradient
from vegrip.model.generated import Floats, advance, readout

__all__ = ["Floats", "advance", "gauge", "radius_gradient_towards", "readout", "torsion_gradient"]

'''


def declarations() -> str:
    """Return the text of the file."""
    names = layout_of(paper_model(1e-2)).names()  # the same names for every model
    return HEAD + "".join(f"{name}: {_type(value)}\n" for name, value in names.items())


def _type(value: object) -> str:
    if isinstance(value, tuple):
        return f"tuple[{type(value[0]).__name__}, ...]"
    return type(value).__name__


def main() -> None:
    """Write it."""
    FILE.write_text(declarations(), encoding="utf-8")


if __name__ == "__main__":
    main()
