"""What an estimator has learned of its fingertip: judged, smoothed, kept for the next time.

The filter's own values move with every sample and are as good as the last minute was. Here each is watched
at a slow pace: the *filtered* value follows the raw one while the tip moves in contact and the model explains
what is measured; it counts as *valid* after it has become clearly narrower than the prior,
and stays so until it is clearly not (hysteresis). Only valid ones are kept, and they come back as a prior
somewhat wider than they left, to a model of the very same make only.
"""

import dataclasses
import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vegrip.clock import NS
from vegrip.errors import ConfigError
from vegrip.estimator.estimator import LOST, ContactEstimator
from vegrip.messages import Estimate, ModelHealth
from vegrip.model import ContactModel
from vegrip.parameters import changed, coordinate
from vegrip.whole_file import write_whole

VERSION = 1
"""Of the files; raised when their meaning changes."""

SMOOTHING = 10.0  # [s] of excited contact, time constant of the filtered values
NARROW, WIDE = 0.5, 0.8
"""Shares of the prior's spread below which a value becomes valid and above which it no longer is."""

TOLERABLE = 2.0
"""Mean NIS up to which what is learned counts: beyond it the misfit is larger than the noise."""

WIDENED = 2.0
"""By how much a spread grows when a value comes back: the finger was elsewhere meanwhile."""


@dataclass(frozen=True, slots=True)
class Learned:
    """One parameter: as the filter has it now, and as it is judged."""

    raw: Estimate
    filtered: float
    valid: bool
    excited: float  # [s] of motion in contact that went into it


class Learner:
    """Watches what one estimator learns; call :meth:`look` some times a second."""

    def __init__(self, estimator: ContactEstimator) -> None:
        self.estimator = estimator
        self.model = estimator.model
        self.learned: dict[str, Learned] = {}
        self._last: int | None = None

    def look(self, now: int) -> Mapping[str, Learned]:
        """Take note of what is learned at ``now`` [ns]; return it by symbol."""
        dt = 0.0 if self._last is None else max((now - self._last) / NS, 0.0)
        self._last = now
        health = self.estimator.health()
        for symbol in self.symbols:
            raw = self.estimator.value(symbol)
            self.learned[symbol] = self._judged(symbol, raw, dt, sound=_is_sound(health))
        return self.learned

    @property
    def symbols(self) -> tuple[str, ...]:
        """Parameters that the estimator learns, friction among them."""
        names = list(self.model.parameters)
        learned = (names[place] for place in self.estimator.layout.learned)
        return tuple(dict.fromkeys([*learned, names[self.estimator.layout.mu]]))

    def _judged(self, symbol: str, raw: Estimate, dt: float, *, sound: bool) -> Learned:
        prior = self.model.values[symbol]
        old = self.learned.get(symbol, Learned(raw, prior.value, valid=False, excited=0.0))
        moving = raw.valid and sound and self.estimator.is_excited and math.isfinite(raw.std)
        if not moving:
            return Learned(raw, old.filtered, old.valid and sound, old.excited)
        excited = old.excited + dt
        gain = dt / (min(excited, SMOOTHING) + dt) if dt > 0.0 else 0.0
        share = raw.std / max(prior.std, 1e-300)
        valid = share < WIDE if old.valid else share < NARROW
        return Learned(raw, old.filtered + gain * (raw.value - old.filtered), valid, excited)


def _is_sound(health: ModelHealth) -> bool:
    """Whether the model explains enough to learn from: a small misfit of one regime does not count."""
    return health.regime != LOST and not health.nis > TOLERABLE


def fingerprint(model: ContactModel) -> str:
    """Return what a file must agree with: fingertip, effects in order, parameters and their scales."""
    parts = [model.tip_radius, model.reference_depth]
    of = [[e.name, [[p.symbol, p.unit, p.transform] for p in e.parameters]] for e in model.effects]
    return hashlib.sha256(json.dumps([parts, of]).encode()).hexdigest()[:16]


def save(learner: Learner, path: Path) -> int:
    """Write what is valid, whole or not at all; return how many parameters that were."""
    kept = {
        symbol: {"value": one.filtered, "std": one.raw.std, "excited": one.excited}
        for symbol, one in tuple(learner.learned.items())  # a thread may write while the loop learns
        if one.valid
    }
    if not kept:
        return 0
    content = {"version": VERSION, "fingerprint": fingerprint(learner.model), "parameters": kept}
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, json.dumps(content, indent=1))
    return len(kept)


def restored(model: ContactModel, path: Path) -> ContactModel:
    """Return ``model`` with what was learned as its prior; as it is when there is no such file."""
    if not path.exists():
        return model
    remedy = f"delete {path} to learn anew"
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        version, make, kept = content["version"], content["fingerprint"], dict(content["parameters"])
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise ConfigError(f"{path} does not hold learned parameters ({error}); {remedy}") from None
    if version != VERSION:
        raise ConfigError(f"{path} is of version {version}, not {VERSION}; {remedy}")
    if make != fingerprint(model):
        raise ConfigError(f"{path} was learned with another model; use that model, or {remedy}")
    values = dict(model.values)
    for symbol, entry in kept.items():
        values[symbol] = _returned(model, symbol, entry, path, remedy)
    return dataclasses.replace(model, values=values)


def _returned(model: ContactModel, symbol: str, entry: Any, path: Path, remedy: str) -> Any:
    known, (_, parameter) = model.values[symbol], model.parameters[symbol]
    try:
        value, std = float(entry["value"]), float(entry["std"])
    except (KeyError, TypeError, ValueError):
        raise ConfigError(f"{path}: {symbol} lacks a value or its std; {remedy}") from None
    if not (known.low <= value <= known.high and 0.0 < std < math.inf):
        raise ConfigError(
            f"{path}: {symbol} is {value:g} +- {std:g}, not within {known.low:g} .. {known.high:g}; {remedy}"
        )
    assert math.isfinite(coordinate(parameter, value))  # noqa: S101
    return changed(known, value=value, std=min(WIDENED * std, known.std))
