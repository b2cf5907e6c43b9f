"""A ladder of models: the error that falls with every effect."""

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from vegrip.display import card as cards
from vegrip.display.text import Part, plain, table_of
from vegrip.identification.diagnosis.error_ladder import Ladder, Refinement, Rung, ladder_figure
from vegrip.web import figures
from vegrip.web.markup import legend, table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HEAD = ("model", "error / noise", "held out")
LINES = (("blue", "fitted"), ("orange dash", "held-out episodes"), ("green dash", "noise"))


def name_of(rung: Rung) -> str:
    return "start" if rung.effect is None else f"+ {rung.effect}"


def brief(one: Ladder) -> str:
    steps = " -> ".join(f"{rung.error:.3f}" for rung in one.rungs)
    return f"of {one.recording}: {steps} times the noise, {', '.join(map(name_of, one.rungs))}"


def parts(one: Ladder) -> list[Part]:
    ends: list[Part] = []
    if isinstance(one, Refinement):
        ends.append(f"verdict: {one.diagnosis.verdict}; the next effect does not pay")
    return [table_of(HEAD, _rows(one), left=("model",)), *ends]


def _rows(one: Ladder) -> list[tuple[str, ...]]:
    return [(name_of(rung), f"{rung.error:.3f}", f"{rung.heldout_error:.3f}") for rung in one.rungs]


def text(one: Ladder, most: int | None = None) -> str:
    del most
    return plain(parts(one))


def card(one: Ladder) -> str:
    first, last = one.rungs[0].error, one.rungs[-1].error
    huge = cards.times_noise(f"{first:.2f} → {last:.2f}")
    content = (drawn(one.rungs), table(HEAD, _rows(one), numbers=(1, 2)))
    return cards.verdict(f"ladder of errors: {one.recording}", "", "", huge, *content)


def drawn(rungs: list[Rung]) -> str:
    """Return the ladder as inline SVG."""
    width = figures.ladder_width(len(rungs))
    svg = figures.ladder([asdict(rung) for rung in rungs])
    return f'{legend(*LINES)}<div style="max-width:{width}px">{svg}</div>'


def figure(one: Ladder, channel: str) -> "Figure":
    del channel
    return ladder_figure(one.rungs)


def columns(one: Ladder) -> dict[str, list[Any]]:
    return {
        "model": [name_of(rung) for rung in one.rungs],
        "error": [rung.error for rung in one.rungs],
        "heldout_error": [rung.heldout_error for rung in one.rungs],
    }


def as_json(one: Ladder) -> dict[str, Any]:
    verdict = {"verdict": one.diagnosis.verdict} if isinstance(one, Refinement) else {}
    return {"ladder": [asdict(rung) for rung in one.rungs], **verdict, "noise_floor": 1.0}
