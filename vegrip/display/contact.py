"""What is known of a contact, and its margin."""

import math

import numpy as np

from vegrip.contact.pressure import pressure
from vegrip.display import card as cards
from vegrip.display.text import plain, table_of
from vegrip.messages import ContactEstimate, Estimate, SlipMargin
from vegrip.web.axes import Axes, extent
from vegrip.web.markup import legend, table

UNITS = {
    "indentation": (1e3, "mm"),
    "normal_force": (1.0, "N"),
    "contact_radius": (1e3, "mm"),
    "pressure_exponent": (1.0, "1"),
    "friction_coefficient": (1.0, "1"),
    "limit_force": (1.0, "N"),
    "limit_torque": (1e3, "N mm"),
    "limit_radius": (1.0, "N"),
}
HEAD = ("quantity", "value", "std", "unit", "")
Shown = ContactEstimate | SlipMargin


def _rows(one: Shown) -> list[tuple[str, ...]]:
    if isinstance(one, ContactEstimate):
        return [_row(name, getattr(one, name), *UNITS[name]) for name in UNITS]
    bound = "bound" if math.isnan(one.confidence) else f"bound at {100.0 * one.confidence:.3g} %"
    rest = ((bound, one.lower_bound, "1"), ("force reserve", one.force_reserve, "N"))
    times = (("time to slip", one.time_to_slip, "s"), ("earliest slip", one.earliest_slip, "s"))
    return [_row("margin", one.margin, 1.0, "1")] + [
        (name, _number(value), "", unit, "") for name, value, unit in (*rest, *times)
    ]


def _row(name: str, one: Estimate, scale: float, unit: str) -> tuple[str, ...]:
    said, std = "" if one.valid else "not valid", _number(scale * one.std) if math.isfinite(one.std) else "-"
    return (name.replace("_", " "), _number(scale * one.value), std, unit, said)


def _number(value: float) -> str:
    return "-" if math.isnan(value) else "never" if value == math.inf else f"{value:.3g}"


def state_of(one: Shown) -> tuple[str, str]:
    """Return level and word for how it stands."""
    if isinstance(one, ContactEstimate):
        return ("ok", "in contact") if one.in_contact else ("unknown", "no contact")
    if not one.margin.valid or math.isnan(one.lower_bound):
        return "unknown", "not known"
    if one.margin.value <= 0.0:
        return "bad", "slips"
    return ("ok", "holds") if one.lower_bound > 0.0 else ("warn", "may slip")


def brief(one: Shown) -> str:
    state = f"of {one.finger} at {one.stamp / 1e9:.3f} s: {state_of(one)[1]}"
    if isinstance(one, SlipMargin):
        known = f", margin {one.margin.value:.3g}, bound {one.lower_bound:.3g}"
        return state + known if one.margin.valid else state
    force = one.normal_force
    return f"{state}, {force.value:.3g} +- {force.std:.2g} N" if force.valid else state


def text(one: Shown, most: int | None = None) -> str:
    del most
    return plain([brief(one), table_of(HEAD, _rows(one), left=("quantity", "unit", ""))])


def card(one: Shown) -> str:
    level, name = state_of(one)
    drawn = _patch(one) if isinstance(one, ContactEstimate) else _scale(one)
    kind = "contact" if isinstance(one, ContactEstimate) else "slip margin"
    heading = f"{kind} of {one.finger} at {one.stamp / 1e9:.3f} s"
    content = (f'<div style="max-width:420px">{drawn}</div>', table(HEAD, _rows(one), numbers=(1, 2)))
    return cards.verdict(heading, level, name, "", *content)


def _patch(one: ContactEstimate) -> str:
    """Draw the pressure over the patch, eq. (2) of [TiezziKao2007]_; an empty one where nothing touches."""
    N, a, k = (float(each.value) for each in (one.normal_force, one.contact_radius, one.pressure_exponent))
    is_known = one.in_contact and all(math.isfinite(v) and v > 0.0 for v in (N, a, k))
    radius = a if is_known else 1e-3
    r = np.linspace(-radius, radius, 81)
    p = pressure(np.abs(r), N, a, k) / 1e3 if is_known else np.zeros(r.size)
    x = (1e3 * r).tolist()
    high = extent([0.0, *p.tolist()] if is_known else [0.0, 1.0])
    axes = Axes(extent(x), high, "distance from the centre [mm]", "pressure [kPa]", (420, 180))
    axes.line(x, p.tolist(), "blue")
    return axes.svg("pressure over the contact")


def _scale(one: SlipMargin) -> str:
    """Draw margin with its 95 % interval and bound from slipping, 0, to no load, 1."""
    low = min(-0.1, *(v for v in (one.margin.value, one.lower_bound) if math.isfinite(v)), 0.0)
    axes = Axes((low, 1.0), (0.0, 1.0), "margin [1]: 0 slips, 1 is without load", "", (420, 90))
    axes.line((0.0, 0.0), (0.0, 1.0), "red", **{"stroke-dasharray": "4 3"})
    if math.isfinite(one.lower_bound):
        axes.line((one.lower_bound,) * 2, (0.15, 0.85), "orange", **{"stroke-width": 4})
    if math.isfinite(one.margin.value):
        spread = 1.96 * one.margin.std if math.isfinite(one.margin.std) else 0.0
        axes.line((one.margin.value - spread, one.margin.value + spread), (0.5, 0.5), "blue")
        axes.points((one.margin.value,), (0.5,), "blue")
    return legend(("blue", "margin"), ("orange", "its lower bound")) + axes.svg("margin and bound")
