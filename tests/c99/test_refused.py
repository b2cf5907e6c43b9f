"""What is outside the subset is refused in one sentence with file and line."""

import textwrap
from pathlib import Path

import pytest

from vegrip.c99 import MEMORY, UntranslatableError, translate

REFUSED = {
    "s = [m[0]]": "List is outside the subset",
    "s = 'word'": "only numbers",
    "f = lambda: 1": "Lambda is outside the subset",
    "with m: m[0] = 1.0": "With is outside the subset",
    "assert m[0] > 0.0": "Assert is outside the subset",
    "m[0] = m[0] // 2.0": "whole numbers only",
    "m[0] = math.nextafter(m[0], 1.0)": "math.nextafter has no counterpart",
    "m[0] = unknown": "is not known here",
    "m[0] = other(m)": "not in this module",
    "m[0] = entry(m)": "recursion",
    "m[0] = default(m)": "every argument is given",
    "x = 1.0\nx = (1.0, 2.0)\nm[0] = x[0]": "two kinds of value",
    "if m[0]: m[0] = 1.0": "a comparison is needed",
    "m[0.5] = 1.0": "not a whole number",
    "m[0] = 2 ** 3": "whole powers",
    "for x in m: m[0] = x": "range(...) or a constant tuple",
    "m[30000000000000000000] = 1.0": "64 bits",
    "m[0] = m[1] if m[0] > bump(m) and bump(m) < 1.0 else m[2]": "an order that C does not fix",
    "m[0] = 1.0 if 0.0 < bump(m) < 1.0 else 0.0": "evaluated twice",
    "import os": "Import is outside the subset",
    "m[0:2] = 1.0": "Slice is outside the subset",
    "m[0] = 1 << 3": "holds double and gets int64_t; convert it",
    "m[0] = ~3": "is not translated",
}


@pytest.mark.parametrize("line", REFUSED)
def test_refused_with_place_and_reason(line: str) -> None:
    body = textwrap.indent(line, "    ")
    text = f"""
def bump(m):
    m[0] += 1.0
    return m[0]

def default(m, x=1.0):
    return x

def entry(m):
    m[1] = 2.0
{body}
"""
    with pytest.raises(UntranslatableError) as told:
        translate(text, {"entry": (MEMORY,)}, place=lambda function, number: f"{function}.py:{number}")
    said = str(told.value)
    assert REFUSED[line] in said
    assert said.startswith(("entry.py:1", "entry.py:2", "default.py"))
    assert "\n" not in said


def test_a_hook_is_named_with_its_file_and_line() -> None:

    from vegrip.estimator.origins import Origins
    from vegrip.model import paper_model

    from . import bad_effect

    origins = Origins([*paper_model(8e-3).effects, bad_effect.EFFECT])
    text = Path(bad_effect.__file__).read_text(encoding="utf-8")
    line = next(i for i, one in enumerate(text.splitlines(), 1) if "nextafter" in one)
    assert origins.place("bad_effect__sense0", 1).endswith(f"bad_effect.py:{line}")
    assert origins.place("take_sample", 0).split(":")[0].endswith("kernels/update.py")
