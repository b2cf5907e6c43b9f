"""What the page shows of one finger: plain values for JSON; what is too old is absent, with its age. Pure."""

import math
from functools import cache, lru_cache
from statistics import NormalDist
from typing import Any

import numpy as np

from vegrip import messages
from vegrip.contact.limit_surface.reference import point
from vegrip.contact.pressure import peak_pressure
from vegrip.effects import effect, names
from vegrip.runtime.monitor.rows import FingerRow
from vegrip.web.live.alarms import CONDITIONS, REASONS, health_in_words

EXPONENT_STEP = 0.1
"""Of the pressure exponent between two curves: the surface moves by less than a line's width."""

EXPONENT_RANGE = (1.0, 50.0)  # of the pressure exponent; beyond, the pressure is as good as uniform
_CENTRES = (0.0, 0.1, 0.2, 0.3, 0.42, 0.55, 0.7, 0.85, 1.0, 1.25, 1.7, 2.6, 5.0, 20.0)
"""Distances of the centre of rotation [contact radii], from pure torque to pure force."""

Curve = tuple[tuple[float, float], ...]
"""Points (f, m): tangential force over mu N, torque over the largest torque, of the quarter f, m >= 0."""

CONFIDENCE = 0.95  # one-sided, of the inner limit surface where the margin names none

OF_THE_CONTACT = ("mu", "k")  # are in ContactEstimate, as they are now

SHOWN = ("normal_force", "contact_radius", "pressure_exponent", "friction_coefficient", "indentation")

NO_LOAD = 0.98  # margin from which on the load is too small to distinguish the certain limit from


@cache
def _units() -> dict[str, str]:
    return {p.symbol: p.unit for name in names() for p in effect(name).parameters if p.unit != "1"}


def finger_view(
    row: FingerRow, now: int, *, wanted: float | None, learned: dict[str, messages.LearnedParameter]
) -> dict[str, Any]:
    """Return the finger as it is at ``now`` [ns].

    Args:
        row: what has been received of it.
        now: [ns].
        wanted: the margin its controller keeps, None = not known.
        learned: newest of each parameter, by symbol.

    """
    said = row.now(now)
    contact, margin = said.contact, said.margin
    return {
        "age": finite(said.margin_age),
        "fresh": margin is not None,
        "in_contact": contact.in_contact if contact is not None else None,
        "margin": _margin(margin, wanted),
        "command": _command(said.command),
        "contact": _contact(contact),
        "surface": _surface(contact, margin),
        "load": _load(said.state),
        "health": _health(said.health),
        "learned": [_learned(one) for symbol, one in learned.items() if symbol not in OF_THE_CONTACT],
    }


def finite(value: float, digits: int = 4) -> float | None:
    return float(f"{value:.{digits}g}") if math.isfinite(value) else None


def _estimate(estimate: messages.Estimate) -> dict[str, Any]:
    return {"value": finite(estimate.value), "std": finite(estimate.std, 3), "valid": estimate.valid}


def _margin(margin: messages.SlipMargin | None, wanted: float | None) -> dict[str, Any] | None:
    if margin is None:
        return None
    return _estimate(margin.margin) | {
        "bound": finite(margin.lower_bound),
        "confidence": finite(margin.confidence),
        "wanted": wanted,
        "reserve": finite(margin.force_reserve),
        "time_to_slip": finite(margin.time_to_slip),
        "never": margin.time_to_slip == math.inf,
        "earliest": finite(margin.earliest_slip),
        "earliest_never": margin.earliest_slip == math.inf,
    }


def _command(command: messages.ForceCommand | None) -> dict[str, Any] | None:
    if command is None:
        return None
    return {
        "force": finite(command.normal_force),
        "adjustment": finite(command.adjustment, 2),
        "reason": command.reason.name.lower(),
        "words": REASONS[command.reason],
    }


def _contact(contact: messages.ContactEstimate | None) -> dict[str, Any] | None:
    if contact is None:
        return None
    shown = {name: _estimate(getattr(contact, name)) for name in SHOWN}
    return {**shown, "peak_pressure": _peak_pressure(contact)}  # [Pa]


def _peak_pressure(contact: messages.ContactEstimate) -> float | None:
    N, a, k = (e.value for e in (contact.normal_force, contact.contact_radius, contact.pressure_exponent))
    if not (contact.in_contact and N > 0.0 and a > 0.0 and k >= 1.0 and math.isfinite(N * a * k)):
        return None
    return finite(float(peak_pressure(N, a, k)))


def _surface(
    contact: messages.ContactEstimate | None, margin: messages.SlipMargin | None
) -> dict[str, Any] | None:
    """Return the limit surface: normalised curve, its size, and how much of it one can be sure of."""
    if contact is None or not contact.in_contact:
        return None
    force, torque = contact.limit_force, contact.limit_torque
    if not (force.value > 0.0 and torque.value > 0.0 and math.isfinite(force.value * torque.value)):
        return None
    return {
        "curve": limit_curve(contact.pressure_exponent.value),
        "force": finite(force.value),
        "torque": finite(torque.value),
        "sure": round(_sure(force, margin), 3),
    }


def _sure(limit: messages.Estimate, margin: messages.SlipMargin | None) -> float:
    """Return the share of the limit surface that holds at the confidence of the margin.

    The margin is 1 - |load|/limit and its bound 1 - |load|/(sure limit), so their loads give the share; with
    next to no load the standard deviation of the limit force does, which is log-normal as friction is.
    """
    if margin is not None and margin.margin.value < NO_LOAD and margin.lower_bound < margin.margin.value:
        return max((1.0 - margin.margin.value) / (1.0 - margin.lower_bound), 0.0)
    confidence = margin.confidence if margin is not None else math.nan
    away = NormalDist().inv_cdf(confidence if 0.5 <= confidence < 1.0 else CONFIDENCE)
    return math.exp(-away * limit.std / limit.value) if math.isfinite(limit.std) else 0.0


def _load(state: messages.FingertipState | None) -> dict[str, Any] | None:
    if state is None or (math.isnan(state.tangential_force_x) and math.isnan(state.tangential_force_y)):
        return None
    x, y = (0.0 if math.isnan(v) else v for v in (state.tangential_force_x, state.tangential_force_y))
    torque = 0.0 if math.isnan(state.torque_z) else state.torque_z
    return {"force": finite(math.hypot(x, y)), "torque": finite(torque)}


def _health(health: messages.ModelHealth | None) -> dict[str, Any]:
    if health is None:
        return {"condition": "unknown", "level": "unknown", "input": "", "words": "", "nis": None}
    level = "ok" if health.condition is messages.Condition.OK else "bad"
    return {
        "condition": health.condition.name.lower(),
        "level": "warn" if health.condition is messages.Condition.DEGRADED else level,
        "input": CONDITIONS[health.condition],
        "words": health_in_words(health),
        "consistent": health.consistent,
        "channel": health.channel,
        "nis": finite(health.nis, 3),
        "suspect": health.suspect,
        "rejected": health.rejected,
        "friction": health.friction,
        "limit": health.limit,
    }


def _learned(one: messages.LearnedParameter) -> dict[str, Any]:
    return {
        "symbol": one.symbol,
        "unit": _units().get(one.symbol, ""),
        "value": finite(one.filtered.value),
        "std": finite(one.filtered.std, 2),
        "valid": one.filtered.valid,
        "raw": finite(one.raw.value),
        "excited": finite(one.excited, 3),
    }


def limit_curve(exponent: float) -> Curve:
    """Return the limit surface of a pressure exponent k; one below 1 or unknown counts as k = 2, Hertz."""
    if not math.isfinite(exponent) or exponent < EXPONENT_RANGE[0]:
        exponent = 2.0
    return _curve(round(min(exponent, EXPONENT_RANGE[1]) / EXPONENT_STEP))


@lru_cache(maxsize=256)
def _curve(steps: int) -> Curve:
    f, m = point(max(steps * EXPONENT_STEP, EXPONENT_RANGE[0]), np.array(_CENTRES))
    points = [(round(float(x), 3), round(float(y / m[0]), 3)) for x, y in zip(f, m, strict=True)]
    return (*points, (1.0, 0.0))
