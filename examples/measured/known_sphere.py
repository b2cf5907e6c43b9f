"""The one recording whose sphere is known: the stiffness learned, as a modulus, beside the instrument's."""

from cases import Result

RADIUS = 27.5e-6  # [m]
INSTRUMENT = 156.0  # [Pa] effective modulus in the instrument's file


def known_sphere(result: Result) -> str:
    """Return the table. Hertz at ``x_ref = R / 10``: ``K = 4/3 E* sqrt(R) x_ref^1.5``; needs p near 1.5."""
    stiffness, p, c1 = (result.learned[symbol][0] for symbol in ("K", "p", "c1"))
    modulus = 0.75 * stiffness / (RADIUS**0.5 * (RADIUS / 10.0) ** 1.5)
    return "\n".join(
        [
            "| exponent p (Hertz: 1.5) | E* at once | E* relaxed | E* of the instrument |",
            "|---|---|---|---|",
            f"| {p:.2f} | {modulus:.0f} Pa | {(1.0 - c1) * modulus:.0f} Pa | {INSTRUMENT:.0f} Pa |",
        ]
    )
