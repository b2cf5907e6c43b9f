"""What the C does is what numba does with the same text, number by number."""

import math
import random
from collections.abc import Callable

import numpy as np
import pytest

Run = Callable[..., tuple[list[float], list[float]]]
ODD = [0.0, -0.0, 1.0, -1.5, 3.7e-310, 1e308, math.inf, -math.inf, math.nan]

TEXTS = {
    "a loop's variable that its body changes does not count it": """
        def pair(x):
            return x, 0.5 * x

        def entry(m):
            for _ in range(3):
                m[0] += 1.0
                m[1], _ = pair(m[0])
    """,
    "the limits of a loop are taken once": """
        def entry(m):
            n = 3
            for i in range(n):
                n = 1
                m[i] += 1.0
    """,
    "a loop's variable keeps its last value": """
        def entry(m):
            i = 7
            for i in range(2):
                m[0] += 1.0
            m[1] = i + 0.5
    """,
    "values are taken before anything is set": """
        def entry(m):
            a, b = m[0], m[1]
            a, b = b, a
            m[0], m[1] = m[1], m[0]
            m[2], m[3] = a, b
    """,
    "one value for several targets": """
        def entry(m):
            m[0] = m[1] = m[0] + 1.0
            x = y = m[1] * 3.0
            m[2], m[3] = x, y
    """,
    "operands from left to right": """
        def bump(m):
            m[0] = 2.0 * m[0] + 1.0
            return m[0]

        def entry(m):
            m[0] = 1.0
            m[1] = m[0] - bump(m) * 10.0 + m[0] / bump(m)
            m[2] += bump(m)
            m[3] = bump(m) - bump(m)
    """,
    "whole powers are products": """
        WIDE = 1.7320508075688772

        def entry(m):
            x = m[1]
            m[0] = x**2 + x**3 + x**4 + x**7 + WIDE**4 + x**-2
            m[1] = (x + 1.0) ** 2 / x**5
    """,
    "powers": """
        def entry(m):
            x, y = abs(m[1]), m[3]
            m[0] = x**y + x**0.5 + x**1.5 + 2.0**y + x**2.0 + 10.0**y + x**-0.5
    """,
    "whole numbers": """
        def entry(m):
            n = 7
            for i in range(-4, 5, 2):
                m[0] += (i // 3) * 10.0 + i % 3 + i / 3
            m[1] = n // 2 * 3 - 1
            m[2] = max(n, 9) + min(n, 3)
    """,
    "backwards": """
        TABLE = (0.5, 1.5, 2.5)

        def entry(m):
            for i in range(len(TABLE) - 1, -1, -1):
                m[0] = m[0] * 2.0 + TABLE[i]
    """,
    "tables": """
        import numpy as np

        ROWS = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
        OTHER = 0.5 * ROWS
        PAIRS = ((0.5, 2.0), (1.5, 3.0))
        FLAGS = (True, False, True)

        def total(table):
            s = 0.0
            for i in range(table.shape[0]):
                for j in range(table.shape[1]):
                    s = s * 0.3 + table[i, j]
            return s

        def entry(m):
            m[0] = total(ROWS) - total(OTHER)
            for a, b in PAIRS:
                m[1] += a * b
            for i in range(3):
                if FLAGS[i] and i > 0:
                    m[2] += 1.0
            for k in (2, 3):
                m[k] += k
    """,
    "tuples": """
        def three(x):
            if x > 1.0:
                return x, 2.0 * x, 3.0
            return (x, 0.0, 1.0) if x > 0.0 else (0.0, 1.0, 2.0)

        def second(t):
            return t[1] + t[-1]

        def entry(m):
            t = three(m[0])
            a, _, c = three(m[1])
            m[2] = second(t) + a * c + three(m[3])[2]
    """,
    "leaving loops": """
        def first(m):
            for i in range(4):
                if not m[i] < 2.0:
                    continue
                if m[i] < 0.0:
                    return i
            return -1

        def entry(m):
            n = first(m)
            while n < 3:
                n += 1
                if n == 2:
                    break
                m[0] += 1.0
            m[1] += n
    """,
    "a variable that only some branches set": """
        def entry(m):
            for i in range(4):
                if m[i] > 1.0:
                    x = m[i]
                else:
                    x = -1.0
                if i == 0:
                    largest = x
                elif x > largest:
                    largest = x
            m[0] = largest
    """,
    "numbers and truth": """
        def entry(m):
            high = m[0] > 1.0 or m[1] > 1.0
            low = not high and 0.0 < m[2] <= 3.0
            m[3] = 1.0 if low else 0.0
            m[0] = high + bool(m[1]) + int(m[2]) + float(3)
    """,
    "names that C has taken": """
        def entry(m):
            double, long, bool_c = m[0], m[1], m[2]
            if double > 0.0:
                register = long + bool_c
                m[0] = register
    """,
}


@pytest.mark.parametrize("law", TEXTS)
def test_same(law: str, both: Run) -> None:
    for m in ([1.0, 2.0, 3.0, 0.7], [-0.3, 1.25, 0.5, 2.1]):
        by_numba, by_c = both(TEXTS[law], m)
        assert np.array_equal(by_numba, by_c, equal_nan=True)


def test_extremes_comparisons_and_zeros_agree_for_odd_numbers(both: Run) -> None:
    text = """
        def entry(m):
            for i in range(9):
                for j in range(9):
                    a, b = m[i], m[j]
                    at = 9 + 8 * (9 * i + j)
                    m[at] = max(a, b)
                    m[at + 1] = min(a, b)
                    m[at + 2] = max(a, b, 0.5)
                    m[at + 3] = 1.0 if a < b else 0.0
                    m[at + 4] = 1.0 if not a <= b else 0.0
                    m[at + 5] = a / b
                    m[at + 6] = math.copysign(1.0, a) * math.hypot(a, b)
                    m[at + 7] = 1.0 if a == b or math.isnan(a) or math.isinf(b) else a * b
    """
    by_numba, by_c = both(text, ODD + [0.0] * 648)
    assert np.array_equal(by_numba, by_c, equal_nan=True)
    zero = np.array(by_numba) == 0.0
    assert np.array_equal(np.signbit(by_numba)[zero], np.signbit(by_c)[zero])


FUNCTIONS = (
    "acos", "asin", "atan", "acosh", "asinh", "atanh", "cos", "sin", "tan", "cosh", "sinh", "tanh", "exp",
    "expm1", "log", "log10", "log1p", "log2", "sqrt", "erf", "erfc", "lgamma", "fabs",
)  # fmt: skip


def test_functions_of_math_agree(both: Run) -> None:
    draw = random.Random(1)  # noqa: S311 (numbers to compare)
    m = [
        *ODD,
        *(draw.uniform(-1.0, 1.0) for _ in range(300)),
        *(draw.uniform(-30.0, 30.0) for _ in range(300)),
    ]
    n = len(m)
    lines = [f"        m[{n * (k + 1)} + i] = math.{name}(m[i])" for k, name in enumerate(FUNCTIONS)]
    text = "\n".join(["def entry(m):", f"    for i in range({n}):", *lines])
    by_numba, by_c = both(text, m + [0.0] * (n * len(FUNCTIONS)))
    for k, name in enumerate(FUNCTIONS):
        part = slice(n * (k + 1), n * (k + 2))
        assert np.array_equal(by_numba[part], by_c[part], equal_nan=True), name


@pytest.mark.parametrize("name", ["pow", "atan2", "hypot", "copysign"])
def test_functions_of_two_numbers_agree(name: str, both: Run) -> None:
    draw = random.Random(name)  # noqa: S311 (numbers to compare)
    m = [*ODD, *(draw.uniform(0.0, 3.0) for _ in range(600))]
    by_numba, by_c = both(
        f"""
        def entry(m):
            for i in range({len(m) - 1}):
                m[i] = math.{name}(m[i], m[i + 1])
        """,
        m,
    )
    assert np.array_equal(by_numba, by_c, equal_nan=True)
