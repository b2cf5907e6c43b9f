"""Numbers as instruments and spreadsheets write them: a typographic minus, marks between thousands.

``1 199`` and ``1'199`` can be read in one way only, ``1.199,5`` and ``1,199.5`` too, where the decimal sign
is known. ``1.199`` in a column of whole numbers cannot: it is read as what makes the column smoother.
"""

import functools
import re
from collections.abc import Sequence
from typing import Final

import numpy as np

from vegrip.types import Floats

MINUS: Final = str.maketrans({"\u2212": "-", "\u2013": "-", "\u2010": "-", "\u2011": "-", "\ufe63": "-"})
SPACES: Final = " \u00a0\u2007\u2009\u202f'\u2019"
"""What stands between thousands and nowhere else in a number."""
WHOLE: Final = re.compile(r"[-+]?\d{1,3}")
MARKED: Final = {sign: re.compile(rf"[-+]?[1-9]\d{{0,2}}(?:\{sign}\d{{3}})+") for sign in ".,"}
SPACED: Final = re.compile(rf"[-+]?\d{{1,3}}(?:[{SPACES}]\d{{3}})+(?:[.,]\d*)?")
GROUPED: Final = {
    sign: re.compile(rf"[-+]?[1-9]\d{{0,2}}(?:\{mark}\d{{3}})+(?:\{sign}\d*)?")
    for sign, mark in ((".", ","), (",", "."))
}
"""Decimal sign -> numbers with the other sign between thousands."""
NONE: Final = "none"
SMOOTHER: Final = 0.7  # times the variation of the other reading, from which one is taken (origin: rule)


def plain_number(cell: str, decimal: str = ".", thousands: str = "") -> str:
    r"""Return ``cell`` as Python reads a number; what is none stays as it is.

    >>> plain_number("\u22121 199,5", ",")
    '-1199.5'
    """
    cell = cell.translate(MINUS)
    if thousands and thousands != NONE:
        if thousands in cell and not _grouped_by(thousands, decimal).fullmatch(cell):
            return cell
        cell = cell.replace(thousands, "")
    elif not thousands and SPACED.fullmatch(cell):
        cell = re.sub(f"[{SPACES}]", "", cell)
    elif not thousands and GROUPED[decimal].fullmatch(cell):
        cell = cell.replace("," if decimal == "." else ".", "")
    elif not thousands and cell.count(decimal) > 1 and MARKED[decimal].fullmatch(cell):
        cell = cell.replace(decimal, "")
    return cell.replace(decimal, ".") if decimal != "." else cell


@functools.cache
def _grouped_by(mark: str, decimal: str) -> re.Pattern[str]:
    """Return the numbers with ``mark`` between groups of three digits, or of two, as in India."""
    mark, decimal = re.escape(mark), re.escape(decimal)
    return re.compile(rf"[-+]?\d{{1,3}}(?:{mark}\d{{2,3}})*{mark}\d{{3}}(?:{decimal}\d*)?")


def is_doubtful(values: Floats) -> bool:
    """Whether ``values`` could be whole numbers whose thousands were read as decimals."""
    known = np.abs(values[np.isfinite(values)])
    is_whole = known == np.round(known)
    broken = known[~is_whole]
    if not is_whole.any() or not np.ptp(known) or np.any(broken < 1.0) or np.any(broken >= 1e3):
        return False
    return bool(np.all(np.abs(broken * 1e3 - np.round(broken * 1e3)) < 1e-6))


def thousands_read(cells: Sequence[str], as_decimals: Floats, sign: str) -> tuple[Floats | None, bool]:
    """Return ``cells`` with marks between thousands, None where they are decimals; and whether it is sure."""
    filled = [cell.translate(MINUS) for cell in cells]
    marked = np.array([bool(MARKED[sign].fullmatch(cell)) for cell in filled])
    bare = np.array([bool(WHOLE.fullmatch(cell)) for cell in filled])
    if not np.all(marked | bare | np.isnan(as_decimals)) or not marked.any() or not bare.any():
        return None, True
    whole = np.array([float(cell.replace(sign, "")) if cell else np.nan for cell in filled])
    if any(cell.count(sign) > 1 for cell in filled):
        return whole, True
    one, other = _variation(whole), _variation(as_decimals)
    if one <= SMOOTHER * other:
        return whole, True
    return None, other <= SMOOTHER * one


def _variation(values: Floats) -> float:
    """Return the sum of all changes over the range."""
    known = values[np.isfinite(values)]
    return float(np.sum(np.abs(np.diff(known)))) / (float(np.ptp(known)) or 1.0)
