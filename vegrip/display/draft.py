"""A draft: the law that was found, or why there is none."""

from html import escape
from typing import TYPE_CHECKING, Any

from vegrip.display import card as cards
from vegrip.display.text import Part, first_rows, plain, table_of
from vegrip.errors import UsageError
from vegrip.identification.draft import Draft
from vegrip.identification.draft.plot import curve, draft_figure
from vegrip.web.figures import over_law
from vegrip.web.markup import legend, listed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HEAD = ("law", "evidence [nats]", "episodes [nats]", "protocols [nats]", "error", "fails")
DOTS = 300  # in a card


def brief(found: Draft) -> str:
    result = found.taken.law.equation if found.taken is not None else f"none, {found.reason}"
    return f"of {found.start.recording.name}: {result}"


def parts(found: Draft, most: int | None = None) -> list[Part]:
    """Return the law and what else was tried, in ``most`` lines where it is given."""
    result = found.as_dict()
    said: list[Part] = [
        f"{result['recording']}: {result['verdict']}" + (f" - {result['reason']}" if result["reason"] else "")
    ]
    if found.taken is not None:
        error, values = (
            result["error"],
            ", ".join(f"{symbol} = {at:.4g}" for symbol, at in result["parameters"].items()),
        )
        said += [
            f"{result['law']}",
            f"error in units of the noise: {error['before']:.3f} -> {error['after']:.3f} (floor 1)",
            f"in the {result['place']}; {values}",
            f"what would refute it: {result['experiment']}",
        ]
    rows, more = first_rows(
        [_row(one) for one in result["tried"]], None if most is None else most - len(said) - 1
    )
    return [*said, *([table_of(HEAD, rows, left=("law", "fails"))] if rows else []), *more]


def _row(one: dict[str, Any]) -> tuple[str, ...]:
    gains = (one["evidence_gain"], one["heldout_gain"], one["heldout_protocols_gain"])
    return (
        one["law"],
        *(f"{gain:.1f}" for gain in gains),
        f"{one['error_after']:.3f}",
        "; ".join(one["failed"]),
    )


def text(found: Draft, most: int | None = None) -> str:
    return plain(parts(found, most))


def card(found: Draft) -> str:
    result, heading = found.as_dict(), f"a law for what is left of {found.start.recording.name}"
    if found.taken is None:
        return cards.verdict(heading, "unknown", "none", "", f"<p>{escape(result['reason'])}</p>")
    change = f"{result['error']['before']:.2f} → {result['error']['after']:.2f}"
    lines = (("ink-soft", "measured less model"), ("blue", "what the law adds, with its 95 % interval"))
    content = (
        f"<p><b>{escape(result['law'])}</b></p>",
        f"<p>In the {result['place']}. A draft is a shape that fits, not physics; what would refute it: "
        f"{escape(result['experiment'])}</p>",
        listed([f"as good: {law}" for law in result["rivals"]]),
        legend(*lines) + over_law(curve(found, DOTS)),
    )
    return cards.verdict(heading, "warn", "drafted", cards.times_noise(change), *content)


def figure(found: Draft, channel: str) -> "Figure":
    del channel
    if found.taken is None:
        raise UsageError(f"there is no law to draw: {found.reason}")
    return draft_figure(found)


def columns(found: Draft) -> dict[str, list[Any]]:
    tried = found.as_dict()["tried"]
    names = ("law", "evidence_gain", "heldout_gain", "heldout_protocols_gain", "error_after")
    return {name: [one[name] for one in tried] for name in names} | {
        "fails": ["; ".join(one["failed"]) for one in tried]
    }


def as_json(found: Draft) -> dict[str, Any]:
    return found.as_dict() | {"file": None, "rival": None}
