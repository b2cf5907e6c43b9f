"""The trials of a calibration: press, hold, slide and twist, scaled to the fingertip and the rig."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vegrip.identification.experiment.design import suited_rig
from vegrip.identification.experiment.design_space import (
    MENU,
    Item,
    Rig,
    RigLimits,
    pull_until_slip,
    slow_slide,
)
from vegrip.identification.experiment.hypotheses import Hypotheses
from vegrip.identification.recording import Fingertip, Recording
from vegrip.identification.recording.channels import CHANNELS
from vegrip.identification.simulate import DEFAULT_NOISE, Protocol
from vegrip.virtual.bench.protocol import Episode
from vegrip.virtual.bench.trial import run_trial
from vegrip.virtual.settings import FingertipSettings, SensorSettings, random_fingertip

TRIAL_KINDS = ("press", "hold", "slide", "twist")
"""In the order of a calibration: each needs what the one before has shown."""
MENU_ITEMS = {
    "press": ("presses over two decades of speed", "growing peaks, then a small one"),
    "hold": ("holds at three depths", "one hold"),
    "slide": ("pulls at four loads", "slides at four speeds"),
    "twist": ("twists and pulls after two waits",),
}
SHOWS = {**MENU_ITEMS, "press": MENU_ITEMS["press"][:1]}
"""Those that show what their kind is for: growing peaks are all equally fast."""
SLOW_SLIDE_M_S = 1e-4
"""Of the last slide of a trial: a slip channel that feels it is fine enough to probe for friction."""
SLOW_DEPTH = 0.3  # of the greatest depth: a light press, which slides after a short way
GENTLE = 0.5  # of the greatest depth, in the first trial: the stiffness is then only guessed
QUICK_PULLS, QUICK = 3, 6.4
"""At the end of a slide trial, and how much faster than usual: only a slide that begins within some 0.1 s
shows at which moment, and so how late the slip channel is."""
PRACTICE_RATE_HZ = 200.0  # [Hz]


@dataclass(frozen=True)
class Trial:
    """A motion of the fingertip, for a rig and for a person."""

    kind: str  # one of TRIAL_KINDS
    protocol: Protocol  # the motion; a rig does it as it is, a person as the words say
    words: tuple[str, ...]  # one sentence for each thing to do

    def as_dict(self) -> dict[str, object]:
        return {
            "kind": self.kind,
            "name": self.protocol.name,
            "duration": self.protocol.duration,
            "episodes": len(self.protocol.episodes),
            "words": list(self.words),
            "motion": self.motion(),
        }

    def motion(self) -> dict[str, list[Any]]:
        """Return depth over time, pauses left out: ``t`` [s], ``depth`` [m], ``moves`` (begin, end, name)."""
        t, depth, moves = [0.0], [0.0], []
        for segment in (one for episode in self.protocol.episodes for one in episode):
            end = t[-1] + segment.duration
            if segment.pull_x or segment.pull_y or segment.spin:
                moves.append([t[-1], end, "twist" if segment.spin else "pull"])
            t.append(end)
            depth.append(depth[-1] if segment.depth is None else segment.depth)
        return {"t": t, "depth": depth, "moves": moves}


def trials_of(
    kind: str, contest: Hypotheses, limits: RigLimits, rig: Rig, *, is_first: bool = False
) -> list[Trial]:
    """Return the trials of a kind that the rig can do, each of its amplitudes.

    ``is_first``: only those that show what the kind is for.
    """
    found = []
    for item in (item for item in MENU if item.name in (SHOWS if is_first else MENU_ITEMS)[kind]):
        own, reason = suited_rig(item, contest, limits, rig)
        if not reason:
            found += [_trial(kind, item, own, amplitudes) for amplitudes in item.choices()]
    return [one for one in found if one.protocol.duration <= limits.duration]


def why_not(kind: str, contest: Hypotheses, limits: RigLimits, rig: Rig) -> str:
    """Return why no trial of a kind can be done, empty where one can."""
    item = next(item for item in MENU if item.name == MENU_ITEMS[kind][0])
    reason = suited_rig(item, contest, limits, rig)[1]
    if reason or trials_of(kind, contest, limits, rig):
        return reason
    return f"it takes longer than {limits.duration:g} s"


def first_trial(rig: Rig) -> Trial:
    item = next(item for item in MENU if item.name == MENU_ITEMS["press"][0])
    return _trial("press", item, rig, {"depth": GENTLE})


def _trial(kind: str, item: Item, rig: Rig, amplitudes: dict[str, float]) -> Trial:
    protocol = item.protocol(rig, amplitudes)
    if kind == "slide":
        depth = amplitudes["depth"]
        quick = [pull_until_slip(rig, depth, 0.5, QUICK)] * QUICK_PULLS
        episodes = (*protocol.episodes, *quick, slow_slide(rig, SLOW_DEPTH * depth, SLOW_SLIDE_M_S))
        notes = (*protocol.notes, *[""] * (QUICK_PULLS + 1))
        protocol = replace(protocol, episodes=episodes, notes=notes)
    return Trial(kind, protocol, tuple(_words(kind, protocol)))


def _words(kind: str, protocol: Protocol) -> list[str]:
    said = ["Begin each episode half a second in the air: the sensors' zeros are read there."]
    for number, episode in enumerate(protocol.episodes):
        what = _episode_in_words(episode)
        said += [f"Episode {number + 1}: {what}."] if what else []
    if len(protocol.episodes) > 1:
        said.append(f"Wait {protocol.pause:g} s in the air between the episodes: the material recovers.")
    if kind in ("slide", "twist"):
        said.append("The surface must be the one that the hand will hold: friction belongs to the pair.")
    return said


def _episode_in_words(episode: Episode) -> str:
    deepest = max((s.depth for s in episode if s.depth is not None), default=0.0)
    if deepest <= 0.0:
        return ""
    rise = next(s.duration for s in episode if s.depth == deepest)
    strokes = sum(s.depth == deepest for s in episode)
    moves = [s for s in episode if s.pull_x or s.pull_y or s.spin]
    rests = sum(s.duration for s in episode if s.depth is None and s not in moves)
    said = [f"press {1e3 * deepest:.2g} mm deep within {rise:.2g} s"]
    said += [f"{strokes} times"] if strokes > 1 else []
    said += [f"stay {rests:.2g} s"] if rests > 0.0 else []
    for move in moves:
        is_slow = 0.0 < math.hypot(move.pull_x, move.pull_y) <= SLOW_SLIDE_M_S and not move.spin
        how = "twist" if move.spin else "pull along the surface"
        how += f" at {1e3 * SLOW_SLIDE_M_S:g} mm/s" if is_slow else ""
        said.append(f"{how} for {move.duration:.2g} s until it slides")
    return ", ".join([*said, "and unload"])


def practice_tip(seed: int) -> FingertipSettings:
    return random_fingertip(np.random.default_rng(seed))


def true_values(tip: FingertipSettings) -> dict[str, float]:
    """Return what a calibration of ``tip`` should find: K at a tenth of the radius, p and mu."""
    deeper = 0.1 * tip.radius / tip.reference_indentation
    return {"K": tip.reference_force * deeper**tip.exponent, "p": tip.exponent, "mu": tip.friction}


def practise(trial: Trial, tip: FingertipSettings, seed: int = 0) -> Recording:
    """Return what sensors measure of ``tip`` in ``trial``."""
    sensors = SensorSettings(rate=PRACTICE_RATE_HZ)
    episodes, pause = trial.protocol.episodes, trial.protocol.pause
    made = run_trial(tip, episodes, sensors, seed, pause=pause, rings=8, spokes=16, truth=False)
    columns = {name: values for name, values in made.columns.items() if name in CHANNELS}
    noise = {name: getattr(sensors, name) for name in DEFAULT_NOISE}
    source: dict[str, str | int | float | bool] = {"made_by": "vegrip calibrate --virtual", "seed": seed}
    t, episode = made.columns["t"], made.columns["episode"].astype(np.int64)
    return Recording(trial.protocol.name, t, episode, columns, Fingertip(tip.radius), noise, source)
