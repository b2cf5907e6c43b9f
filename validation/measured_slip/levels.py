"""The measured levels: mass, force, and what came of so many lifts."""

import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path

TABLE = Path(__file__).with_name("levels.toml")
GRAVITY = 9.81  # [m/s^2]
OUTCOMES = ("failed", "slid", "held")


@dataclass(frozen=True)
class Level:
    """Lifts of one object with one force."""

    mass: float  # [kg]
    normal_force: float  # [N] of one finger
    failed: int = 0
    slid: int = 0
    held: int = 0

    @property
    def tangential_force(self) -> float:
        """Of one finger [N]: half of the weight."""
        return 0.5 * self.mass * GRAVITY

    @property
    def lifts(self) -> int:
        return self.failed + self.slid + self.held

    @property
    def all_held(self) -> bool:
        """Whether every lift of a level of several was held."""
        return self.held == self.lifts > 1


@cache
def read_levels() -> tuple[Level, ...]:
    return tuple(Level(**row) for row in tomllib.loads(TABLE.read_text(encoding="utf-8"))["level"])


@cache
def tangential_gains() -> dict[str, float]:
    """Return what the pads read of a tangential force, over what there was, by mass."""
    gains: dict[str, float] = tomllib.loads(TABLE.read_text(encoding="utf-8"))["tangential_gain"]
    return gains


def lowest_held() -> dict[str, Level]:
    """Return the level with the least force of which every lift was held, by mass."""
    held = sorted(
        (one for one in read_levels() if one.all_held), key=lambda one: (one.mass, -one.normal_force)
    )
    return {f"{one.mass:.3f}": one for one in held}
