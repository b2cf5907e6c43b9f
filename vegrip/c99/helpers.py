"""Small functions in C that do what Python's operators do and C's do not."""

import re

HELPERS = {
    "max": """/* As Python's: the first, unless the second is greater; NaN stays only as the first. */
static inline double {name}(double a, double b)
{{
    return b > a ? b : a;
}}
""",
    "min": """/* As Python's: the first, unless the second is less. */
static inline double {name}(double a, double b)
{{
    return b < a ? b : a;
}}
""",
    "max_whole": """static inline int32_t {name}(int32_t a, int32_t b)
{{
    return b > a ? b : a;
}}
""",
    "min_whole": """static inline int32_t {name}(int32_t a, int32_t b)
{{
    return b < a ? b : a;
}}
""",
    "max_long": """static inline int64_t {name}(int64_t a, int64_t b)
{{
    return b > a ? b : a;
}}
""",
    "min_long": """static inline int64_t {name}(int64_t a, int64_t b)
{{
    return b < a ? b : a;
}}
""",
    "real_of_bits": """/* The number of an IEEE 754 single whose bits are given. */
static inline double {name}(int64_t bits)
{{
    union {{ uint32_t bits; float value; }} both;
    both.bits = (uint32_t)bits;
    return (double)both.value;
}}
""",
    "bits_of_real": """/* The bits of the nearest IEEE 754 single; none is beyond the largest. */
static inline int64_t {name}(double value)
{{
    union {{ uint32_t bits; float value; }} both;
    both.value = (float)value;
    return (int64_t)both.bits;
}}
""",
    "whole": """/* Towards zero; what does not fit into 32 bits, and NaN, gives 0. */
static inline int32_t {name}(double x)
{{
    return x > -2147483648.0 && x < 2147483648.0 ? (int32_t)x : 0;
}}
""",
    "floor_div": """/* Division of whole numbers towards minus infinity. */
static inline int32_t {name}(int32_t a, int32_t b)
{{
    const int32_t q = a / b;
    return a % b != 0 && (a < 0) != (b < 0) ? q - 1 : q;
}}
""",
    "floor_div_long": """/* Division of whole numbers towards minus infinity. */
static inline int64_t {name}(int64_t a, int64_t b)
{{
    const int64_t q = a / b;
    return a % b != 0 && (a < 0) != (b < 0) ? q - 1 : q;
}}
""",
    "modulo_long": """/* Remainder with the sign of the divisor. */
static inline int64_t {name}(int64_t a, int64_t b)
{{
    const int64_t r = a % b;
    return r != 0 && (r < 0) != (b < 0) ? r + b : r;
}}
""",
    "modulo": """/* Remainder with the sign of the divisor. */
static inline int32_t {name}(int32_t a, int32_t b)
{{
    const int32_t r = a % b;
    return r != 0 && (r < 0) != (b < 0) ? r + b : r;
}}
""",
}
POWER = re.compile(r"power(\d+)")


def helper(kind: str, name: str) -> str:
    """Return the text of a helper under its ``name`` in C."""
    if found := POWER.fullmatch(kind):
        return _power(int(found[1]), name)
    return HELPERS[kind].format(name=name)


def _power(n: int, name: str) -> str:
    """``x ** n`` as products of squares, in the order in which numba multiplies."""
    lines: list[str] = []
    exponent, product, square = n, "", "x"
    while exponent:
        if exponent & 1:
            product = f"{product} * {square}" if product else square
        exponent >>= 1
        if exponent:
            following = f"x{2 ** (len(lines) + 1)}"
            lines.append(f"    const double {following} = {square} * {square};")
            square = following
    return "\n".join(
        [f"static inline double {name}(double x)", "{", *lines, f"    return {product};", "}", ""]
    )
