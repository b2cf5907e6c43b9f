"""Blind recordings: what is hidden in them, what is answered, and whether that is right.

The truth lies in a file apart from the recordings. An answer has the words of ``vegrip diagnose --json``:

    {"001": {"verdict": "named", "named": ["adhesion"]},
     "002": {"verdict": "ambiguous", "sets": [["sensor_lag", "sensor_delay"]]},
     "003": {"verdict": "unexplained", "variable": "speed"},
     "004": {"verdict": "adequate"}}
"""

import json
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from vegrip.config import build
from vegrip.errors import InputError, suggestion
from vegrip.whole_file import reading

T = TypeVar("T")
ANSWER_VERDICTS = ("adequate", "named", "ambiguous", "unexplained")
KINDS = ("none", "one", "pair", "outside")
ZERO_JUMP, FRICTION_TREND = "zero_jump", "friction_trend"  # no effects, which may stand beside one in a set


@dataclass(frozen=True)
class Truth:
    """What is ``hidden`` in a recording, and how much of it the recording can show."""

    hidden: tuple[str, ...]
    visible: tuple[str, ...]
    kind: str  # none, one, pair or outside (of any catalogue)
    shows: tuple[str, ...] = ()  # variables over which the misfit of what is outside is a curve
    style: str = ""  # of the motion
    exponent: float = math.nan  # p of the elastic law

    @property
    def is_out_of_sight(self) -> bool:
        """Whether something is hidden that the recording cannot show."""
        return bool(self.hidden) and not self.visible


@dataclass(frozen=True)
class Answer:
    """What is said of a recording: effects that are ``named``, and ``sets`` of which one is there."""

    verdict: str
    named: tuple[str, ...] = ()
    sets: tuple[tuple[str, ...], ...] = ()
    variable: str = ""
    exponent: float = math.nan  # p, where the answer has it
    seconds: float = math.nan  # of processor time

    def grade(self, truth: Truth) -> str:
        """Return right, set (one that holds it), missed, partly, wrong, unexplained or other variable."""
        if truth.kind == "none":
            return "right" if self.verdict == "adequate" else "wrong"
        if self.verdict == "adequate":
            return "missed"
        if truth.kind == "outside":
            is_there = "right" if self.variable in truth.shows else "other variable"
            return is_there if self.verdict == "unexplained" else "wrong"
        return "unexplained" if self.verdict == "unexplained" else self._grade_of_names(truth)

    def _grade_of_names(self, truth: Truth) -> str:
        hidden, visible, named = set(truth.hidden), set(truth.visible), set(self.named)
        if not self.sets:
            return "right" if visible <= named <= hidden else "partly" if named < hidden else "wrong"
        said = [{name} for name in named] + [set(one) for one in self.sets]
        holds = all(one & hidden for one in said) and visible <= set().union(*said)
        return "set" if holds and len(visible) <= len(said) <= len(hidden) else "wrong"

    def points(self, truth: Truth) -> float:
        """Return what the answer is worth, 0 to 1: how often a draw from its sets would be exactly right."""
        grade = self.grade(truth)
        return (
            1.0 / math.prod(len(set(one)) for one in self.sets) if grade == "set" else float(grade == "right")
        )


def score(truths: Mapping[str, Truth], answers: Mapping[str, Answer]) -> dict[str, Any]:
    """Return points by kind and style; what a recording cannot show is not asked.

    Without an answer a recording is worth nothing, whatever is hidden in it.
    """
    asked = {name: truth for name, truth in truths.items() if not truth.is_out_of_sight}
    points = {name: answers[name].points(t) if name in answers else 0.0 for name, t in asked.items()}
    given = [answers[name] for name in asked if name in answers]
    false = [n for n, t in asked.items() if n in answers and not {*answers[n].named} <= _known(t)]
    bias = [abs(answers[n].exponent - t.exponent) for n, t in asked.items() if n in answers]
    grades = Counter(answers[n].grade(t) if n in answers else "no answer" for n, t in asked.items())

    def part(names: Sequence[str]) -> dict[str, float]:
        return {"points": sum(points[name] for name in names), "of": len(names)}

    return {
        "score": sum(points.values()) / max(len(asked), 1),
        "asked": len(asked),
        "kinds": {kind: part([n for n, t in asked.items() if t.kind == kind]) for kind in KINDS},
        "styles": {
            style: part([n for n, t in asked.items() if t.style == style])
            for style in dict.fromkeys(t.style for t in truths.values())
        },
        "falsely_named": len(false),
        "grades": dict(grades.most_common()),
        "bias": _mean(bias),
        "seconds": _mean([one.seconds for one in given]),
    }


def _known(truth: Truth) -> set[str]:
    return set(truth.hidden) if truth.kind != "outside" else set()


def _mean(values: Sequence[float]) -> float:
    known = [value for value in values if math.isfinite(value)]
    return sum(known) / len(known) if known else math.nan


def read_truths(path: Path) -> tuple[dict[str, Truth], list[str]]:
    """Return what is hidden by recording, and the effects that may be."""
    stored = _read(path)
    if not isinstance(stored.get("recordings"), Mapping) or not isinstance(stored.get("effects"), list):
        raise InputError(
            f"{path}: is not the truth of blind recordings; give the file of `vegrip trial --truth`"
        )
    return {
        name: _built(Truth, one, f"{path}, {name}") for name, one in stored["recordings"].items()
    }, stored["effects"]


def read_answers(path: Path, truths: Mapping[str, Truth], effects: Sequence[str]) -> dict[str, Answer]:
    """Return answers by recording; a name that is none is an error, not a miss."""
    answers = {name: _built(Answer, one, f"{path}, {name}") for name, one in _read(path).items()}
    for name, one in answers.items():
        if name not in truths:
            raise InputError(f"{path}: there is no recording {name!r}; {suggestion(name, truths)}")
        if one.verdict not in ANSWER_VERDICTS:
            raise InputError(
                f"{path}, {name}: verdict is {one.verdict!r}; {suggestion(one.verdict, ANSWER_VERDICTS)}"
            )
        in_sets = {each for group in one.sets for each in group} - {ZERO_JUMP, FRICTION_TREND}
        for effect in (*one.named, *sorted(in_sets)):
            if effect not in effects:
                raise InputError(
                    f"{path}, {name}: no effect is called {effect!r}; {suggestion(effect, effects)}"
                )
    return answers


def _read(path: Path) -> dict[str, Any]:
    with reading(path):
        text = path.read_text(encoding="utf-8", errors="replace")
    try:
        stored = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: is no JSON ({error})") from None
    if not isinstance(stored, dict):
        raise InputError(f"{path}: must be one JSON object, recording -> answer")
    return stored


def _built(cls: type[T], table: Any, where: str) -> T:
    if not isinstance(table, dict):
        raise InputError(f'{where}: must be an object, such as {{"verdict": "adequate"}}')
    return build(cls, table, where)
