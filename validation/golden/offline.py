"""What is answered without a loop: recordings with a hidden effect, and the vectors of exports."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any

from validation.golden.play import text
from validation.golden.store import Answered
from vegrip.effects import effect
from vegrip.estimator import EstimatorSettings
from vegrip.export import estimator, finger
from vegrip.export.precision import Request
from vegrip.model import paper_model

RECORDINGS = Path(os.environ.get("GOLDEN_RECORDINGS", "../shared/data/hidden-effects"))
"""Not part of the repository; without them their entries stay as they are."""
RECORDING = "recording, "
DIGITS = 4  # significant, of what an iteration ends at
EFFECTS = {
    "paper": (),
    "memory": ("mullins_softening", "rate_stiffening"),
    "surface": ("load_dependent_friction",),
}


@dataclass(frozen=True)
class OfRecording:
    """``vegrip diagnose`` of one recording."""

    name: str

    def __call__(self) -> Answered:
        """Return its verdict, the effects that were taken or not, and the errors."""
        command = [sys.executable, "-m", "vegrip", "diagnose", str(RECORDINGS / self.name), "--json"]
        quiet = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
        done = subprocess.run(command, capture_output=True, text=True, check=True, env=quiet)
        found: dict[str, Any] = json.loads(done.stdout)
        tried = found["effects"]
        verdict = [
            found["verdict"],
            *(f"named {name}" for name in found["named"]),
            *(f"{'taken' if one['taken'] else 'left'} {one['name']}: {one['outcome']}" for one in tried),
            f"indistinguishable {found['indistinguishable']}",
        ]
        errors = [f"{name} {value:.{DIGITS}g}" for name, value in found["error"].items()]
        errors += [f"{one['name']} {one['error_after']:.{DIGITS}g}" for one in tried]
        numbers = {name: float(f"{value:.{DIGITS}g}") for name, value in found["error"].items()}
        return Answered(RECORDING + self.name, {"verdict": verdict, "errors": errors}, numbers)


@dataclass(frozen=True)
class OfExport:
    """The vectors of the self-test of an export."""

    model: str
    entry: str

    @property
    def name(self) -> str:
        """Return its name in the file."""
        return f"export, {self.entry}, {self.model}"

    def __call__(self) -> Answered:
        """Return the frames."""
        model = paper_model(9e-3)
        for name in EFFECTS[self.model]:
            model = model.with_effect(effect(name))
        settings = EstimatorSettings(hold="position" if self.model == "paper" else "mixed")
        request = Request(model, settings=settings, entry=self.entry)
        frames: tuple[Any, ...]
        if self.entry == "finger":
            frames = finger.record(request).meetings
        else:
            frames = estimator.record(request).frames
        lines = [" ".join(_words(frame)) for frame in frames]
        return Answered(self.name, {"frames": lines}, {"frames": len(lines)})


def _words(value: Any) -> Iterator[str]:
    if is_dataclass(value):
        for one in fields(value):
            yield from _words(getattr(value, one.name))
    elif isinstance(value, tuple):
        for each in value:
            yield from _words(each)
    else:
        yield value.hex() if isinstance(value, bytes) else text(value)


def recordings() -> list[OfRecording]:
    """Return those that are there."""
    return [OfRecording(path.parent.name) for path in sorted(RECORDINGS.glob("*/recording.toml"))]


def exports() -> list[OfExport]:
    """Return all of them."""
    return [OfExport(model, entry) for entry in ("estimator", "finger") for model in EFFECTS]
