"""What changed between two recordings: each value with its interval, changed or not."""

from html import escape
from typing import TYPE_CHECKING, Any

from vegrip.display import card as cards
from vegrip.identification.changed.plot import changed_figure
from vegrip.identification.changed.result import Change, Changed, label_of
from vegrip.web.markup import listed, table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LEVELS = {"nothing": "ok", "named": "warn", "ambiguous": "unknown", "new_effect": "bad"}
HEAD = ("value", "change", "95 % of it", "")
WORDS, WIDTH, ROW = 160, 320, 18  # [px] of the drawing: its names, its intervals, a row


def brief(found: Changed) -> str:
    return f"{found.verdict} - {found.sentence}"


def text(found: Changed, most: int | None = None) -> str:
    return "\n".join([brief(found), *found.remarks][:most])


def card(found: Changed) -> str:
    named = {one.name for one in found.changes}
    every = [*found.changes, *found.unchanged]
    rows = [
        (
            label_of(one.name, found.pair.model),
            one.amount(size_of(one)),
            ends_of(one),
            "*" * (one.name in named),
        )
        for one in every
    ]
    content = (
        f"<p>{escape(found.sentence)}</p>",
        drawn(every, [row[0] for row in rows]),
        table(HEAD, rows, numbers=(1, 2)),
    )
    first, second = (one.measured.recording.name for one in (found.pair.first, found.pair.second))
    level = LEVELS[found.verdict]
    return cards.verdict(
        f"from {first} to {second}", level, found.verdict, "", *content, listed([*found.remarks])
    )


def size_of(one: Change) -> float:
    """Return the difference in percent, or where that says nothing in its unit."""
    return one.after - one.before if one.percent is None else one.percent


def ends_of(one: Change) -> str:
    return " to ".join(map(one.amount, one.interval))


def drawn(every: list[Change], labels: list[str]) -> str:
    """Return the intervals as inline SVG, a row each; percent share a scale, each other has its own."""
    percents = max((one.within for one in every if one.percent is not None), default=1.0)
    nothing, height = WORDS + WIDTH / 2, max(ROW * len(every), 1)
    lines = [f'<path d="M{nothing} 0V{height}" stroke="currentColor" opacity="0.4"/>']
    for row, (one, label) in enumerate(zip(every, labels, strict=True)):
        scale = 0.45 * WIDTH / ((one.within if one.percent is None else percents) or 1.0)
        ends = (one.interval[0], size_of(one), one.interval[1])
        low, middle, high = (nothing + scale * at for at in ends)
        y = ROW * (row + 0.5)
        lines += [
            f'<text x="0" y="{y + 4}" font-size="12" fill="currentColor">{escape(label)}</text>',
            f'<path d="M{low:.1f} {y}H{high:.1f}" stroke="currentColor" stroke-width="2"/>',
            f'<circle cx="{middle:.1f}" cy="{y}" r="3" fill="currentColor"/>',
        ]
    size = f'viewBox="0 0 {WORDS + WIDTH} {height}" width="{WORDS + WIDTH}"'
    return f'<svg {size} role="img" aria-label="intervals of the changes">{"".join(lines)}</svg>'


def figure(found: Changed, channel: str) -> "Figure":
    del channel
    return changed_figure(found)


def columns(found: Changed) -> dict[str, list[Any]]:
    every = [*found.changes, *found.unchanged]
    return {
        "name": [one.name for one in every],
        "changed": [one in found.changes for one in every],
        "before": [one.before for one in every],
        "after": [one.after for one in every],
        "std": [one.std for one in every],
        "unit": [one.unit for one in every],
        "p": [one.p for one in every],
    }


def as_json(found: Changed) -> dict[str, Any]:
    return found.as_dict()
