"""What many outcomes come to: shares by kind, and the confusion matrix."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

from validation.diagnosis_trials.outcome import Outcome
from vegrip.identification.blind import KINDS


def tally_outcomes(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Return counts by kind, by effect, and what was said for what was hidden.

    Recordings that cannot show what is hidden in them count by themselves, whatever was said of them.
    """
    shown = [one for one in outcomes if not one.out_of_sight]
    kinds = {kind: [one for one in shown if one.case.kind == kind] for kind in KINDS}
    explained = [one for one in kinds["one"] + kinds["pair"] if one.answer != "missed"]
    return {
        "trials": len(outcomes),
        "kinds": {kind: _counts(some) for kind, some in kinds.items() if some},
        "sizes": {
            size: _counts([one for one in kinds["one"] if one.case.size == size])
            for size in ("strong", "weak")
            if kinds["one"]
        },
        "out_of_sight": _confusion([one for one in outcomes if one.out_of_sight]),
        "false_alarms": sum(not one.right for one in kinds["none"]),
        "at_the_floor": {
            "right": sum(one.at_the_floor for one in explained),
            "of": len(explained),
        },
        "effects": _by_effect(kinds["one"] + kinds["outside"]),
        "confusion": _confusion(shown),
        "seconds": sum(one.seconds for one in outcomes) / max(len(outcomes), 1),
    }


def _counts(some: Sequence[Outcome]) -> dict[str, Any]:
    answers = Counter(one.answer for one in some)
    return {
        "trials": len(some),
        "right": sum(one.right for one in some),
        "share": sum(one.right for one in some) / max(len(some), 1),
        "answers": dict(answers.most_common()),
    }


def _by_effect(some: Sequence[Outcome]) -> dict[str, dict[str, Any]]:
    names = sorted({one.case.hidden[0] for one in some})
    out = {}
    for name in names:
        here = [one for one in some if one.case.hidden == (name,)]
        out[name] = {
            **_counts(here),
            "before": _mean([one.before for one in here]),
            "after": _mean([one.after for one in here]),
        }
    return out


def _confusion(outcomes: Sequence[Outcome]) -> dict[str, dict[str, int]]:
    """Return hidden -> said -> how often."""
    matrix: dict[str, Counter[str]] = {}
    for one in outcomes:
        hidden = "+".join(one.case.hidden) or "nothing"
        matrix.setdefault(hidden, Counter())[said(one)] += 1
    return {hidden: dict(counts.most_common()) for hidden, counts in sorted(matrix.items())}


def said(one: Outcome) -> str:
    """Return the verdict in a word or two."""
    if one.verdict == "named":
        return "+".join(sorted(one.named))
    if one.verdict == "ambiguous":
        return "one of " + " / ".join("|".join(group) for group in one.sets)
    if one.verdict == "unexplained":
        return f"unexplained ({one.variable or 'nowhere'})" + ("".join(f" +{n}" for n in one.named))
    return one.verdict


def _mean(values: Sequence[float]) -> float:
    return sum(values) / max(len(values), 1)
