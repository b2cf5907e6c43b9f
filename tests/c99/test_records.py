"""Records: the same text over a struct of the same memory gives the same in Python and in C."""

import ctypes

import pytest

from vegrip.c99 import BOOL, LONG, REAL, UntranslatableError, host, record, translate

TEXT = """
def first(box, at):
    return box.parts[at]

def work(box, at, scale):
    part = first(box, at)
    part.count += 1
    part.values[part.count] = scale * float(part.count)
    part.data[1] = part.data[0] ^ 3 << 2
    box.last = part
    box.last.is_set = not part.is_set and box.total > 2
    other = box.last
    other.count -= 5
    box.total = box.total + twice(part.count) + box.last.count
    return box.total
"""


class Part(ctypes.Structure):
    _fields_ = [
        ("count", ctypes.c_int64),
        ("is_set", ctypes.c_bool),
        ("data", ctypes.c_uint8 * 3),
        ("values", ctypes.c_double * 4),
    ]


class Box(ctypes.Structure):
    _fields_ = [("total", ctypes.c_int64), ("last", Part), ("parts", Part * 3)]


OUTSIDE = "static int64_t vg_twice(int64_t x)\n{\n    return 2 * x;\n}\n"


def translated(text):
    return translate(text, {"work": (record(Box), LONG, REAL)}, outside={"twice": LONG}).text()


def filled():
    box = Box(total=3)
    box.parts[1].data[0] = 77
    return box


@pytest.mark.skipif(host.compiler() is None, reason="no C compiler")
def test_python_and_c_leave_the_same_bytes(tmp_path):
    host.build(OUTSIDE + translated(TEXT), tmp_path / "work.so")
    function = host.load(tmp_path / "work.so").vg_work
    function.argtypes, function.restype = [ctypes.c_void_p, ctypes.c_int64, ctypes.c_double], ctypes.c_int64
    scope = {"twice": lambda x: 2 * x}
    exec(TEXT, scope)  # noqa: S102 (of this file)
    python, c = filled(), filled()
    for scale in (0.5, -3.25, 1e300):
        assert scope["work"](python, 1, scale) == function(ctypes.addressof(c), 1, scale)
    assert bytes(python) == bytes(c)


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("    box.parts = 3\n", "element by element"),
        ("    box.total = 0.5\n", "convert it"),
        ("    box.nothing = 1\n", "no field of a record"),
        ("    rows = box.parts\n", "get a name"),
    ],
)
def test_what_a_record_cannot_do_is_refused(line, reason):
    with pytest.raises(UntranslatableError, match=reason):
        translated(TEXT.replace("    return box.total\n", f"{line}    return box.total\n"))


def test_a_record_has_the_kinds_that_are_declared():
    fields = record(Box).fields
    assert fields["total"] == (LONG, 1)
    assert fields["last"][0].fields["is_set"] == (BOOL, 1)
    assert fields["parts"][0].item is fields["last"][0]
