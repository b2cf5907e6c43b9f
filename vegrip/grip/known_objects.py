"""What was learned of an object, by its name: its friction is the prior of its next grasp.

One file for each object, ``FOLDER/objects/<name>.json``, with mean and standard deviation of ln mu. The next
grasp may touch the object elsewhere, or on another day, so it begins with ``ANEW`` more.
"""

import json
import logging
import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from vegrip.errors import ConfigError
from vegrip.whole_file import write_whole

ANEW: Final = 0.1
"""Standard deviation of ln mu from one grasp of an object to the next."""
NAME: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}")
WIDEST: Final = 2.0  # standard deviation of ln mu; a file that says more is no result of a grasp


@dataclass(frozen=True)
class ObjectFriction:
    """Friction of an object with the fingertips: mean and standard deviation of ln mu at 5 N."""

    mean: float
    std: float

    @property
    def is_plausible(self) -> bool:
        """Whether a grasp may have learned it."""
        return abs(self.mean) < WIDEST and 0.0 < self.std <= WIDEST

    @property
    def prior(self) -> tuple[float, float]:
        """Mean and standard deviation of ln mu with which the next grasp begins."""
        return self.mean, math.hypot(self.std, ANEW)


class KnownObjects:
    """The objects that are kept in a folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder / "objects"

    def read(self, name: str) -> ObjectFriction | None:
        """Return what is known of an object, None where it is new; a damaged file is put aside and logged."""
        path = self._file(name)
        try:
            stored = json.loads(path.read_text(encoding="utf-8"))
            found = ObjectFriction(float(stored["ln_friction"]), float(stored["std"]))
        except FileNotFoundError:
            return None
        except (OSError, ValueError, TypeError, KeyError, RecursionError):
            found = ObjectFriction(math.nan, math.nan)
        if found.is_plausible:
            return found
        aside = path.with_name(f"{path.name}.damaged")
        logger = logging.getLogger("vegrip.memory")
        logger.error("what is known of %s cannot be used, and is put aside as %s", name, aside)
        try:
            path.replace(aside)
        except OSError as error:
            logger.warning("%s cannot be put aside: %s", path, error.strerror)
        return None

    def write(self, name: str, friction: ObjectFriction) -> None:
        """Keep what was learned; a folder that cannot be written is reported."""
        path = self._file(name)
        stored = {"ln_friction": friction.mean, "std": friction.std}
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            write_whole(path, json.dumps(stored) + "\n")
        except OSError as error:
            logging.getLogger("vegrip.memory").warning(
                "what was learned of %s cannot be written to %s: %s", name, path, error.strerror
            )

    def _file(self, name: str) -> Path:
        if not NAME.fullmatch(name):
            raise ConfigError(f"friction.object is {name!r}: give letters, digits, - and _, at most 64")
        return self._folder / f"{name}.json"
