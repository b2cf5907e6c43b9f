"""A comparison of a model with a recording."""

from dataclasses import asdict
from math import isnan
from typing import TYPE_CHECKING, Any

from rich.text import Text

from vegrip.display import card as cards
from vegrip.display.text import Part, plain, table_of
from vegrip.displayed import one_of
from vegrip.identification.compare import Comparison
from vegrip.identification.compare.plot import channel_figure, curves
from vegrip.identification.compare.where import SPOKEN_UNITS
from vegrip.identification.diagnosis.data_checks import check_before_search
from vegrip.identification.fit.problem import Problem
from vegrip.identification.fit.result import MISFIT
from vegrip.web.check.render import channels, where
from vegrip.web.figures import over_time, residual_over_time
from vegrip.web.markup import legend

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FITTED = "the paper's model, fitted"
NOTHING = "nothing stands out of the noise"


def brief(one: Comparison) -> str:
    return f"of {one.recording.name}: {one.error:.3f} times the noise"


def parts(one: Comparison, name: str = "") -> list[Part]:
    """Return error by channel and where the model fails; ``name`` is that of the model."""
    which = name or (FITTED if one.fitted else "a model as it is")
    head = Text(one.recording.name, style="bold")
    regimes = [f"- {regime.note}" for regime in one.where] or [NOTHING]
    return [
        head + Text(f": {which}, {one.error:.3f} times the noise", style="not bold"),
        channel_table({channel: asdict(error) for channel, error in one.channels.items()}),
        *regimes,
        *([one.repeated.note] if one.repeated is not None else []),
    ]


def text(one: Comparison, most: int | None = None) -> str:
    del most  # four channels and six regimes at most
    return plain(parts(one))


def channel_table(channels_of: dict[str, Any]) -> Part:
    head = ("channel", "rmse", "noise", "unit", "ratio", "white (p)", "in 95 % band")
    rows = [
        (
            name,
            f"{one['rmse']:.3g}",
            f"{one['noise']:.3g}",
            SPOKEN_UNITS[name],
            f"{one['ratio']:.3f}",
            "-" if isnan(one["whiteness_p"]) else f"{one['whiteness_p']:.2g}",
            f"{100.0 * one['coverage95']:.1f} %",
        )
        for name, one in channels_of.items()
    ]
    return table_of(head, rows, left=("channel", "unit"))


def card(one: Comparison) -> str:
    level, name = ("ok", "as good as the noise") if one.error <= MISFIT else ("bad", "misfit")
    answer = one.as_dict()
    content = (pictures({"model": curves(one)}), where(answer), channels(answer))
    huge = cards.times_noise(f"{one.error:.2f}")
    return cards.verdict(f"{one.recording.name}: model and recording", level, name, huge, *content)


def pictures(models: dict[str, Any], channel: str = "normal_force") -> str:
    """Return inline SVG of the last of ``models`` (curves by name) and, dashed, of the one before."""
    *before, (name, last) = models.items()
    beside = before[0][1].get(channel) if before else None
    lines = [("measured area measured", "measured, with 95 % of the noise"), ("blue", name)]
    lines += [("orange dash", before[0][0])] if before else []
    return (
        legend(*lines)
        + over_time(channel, last[channel], beside)
        + residual_over_time(channel, last[channel])
    )


def figure(one: Comparison, channel: str) -> "Figure":
    drawn = curves(one)
    title = f"{one.recording.name}: {one.error:.2f} times the noise"
    return channel_figure(title, {"model": drawn}, one_of(channel, list(drawn)))


def columns(one: Comparison) -> dict[str, list[Any]]:
    answer = {channel: asdict(error) for channel, error in one.channels.items()}
    names = list(answer["normal_force"])
    return {"channel": list(answer)} | {name: [each[name] for each in answer.values()] for name in names}


def as_json(one: Comparison) -> dict[str, Any]:
    return one.as_dict() | {"doubts": doubts_of(one.problem)}


def doubts_of(problem: Problem) -> list[str]:
    return [doubt.text for doubt in check_before_search(problem)]
