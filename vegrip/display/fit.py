"""A fit: values with their standard errors, and what is left."""

from typing import TYPE_CHECKING, Any

from vegrip.display import card as cards
from vegrip.display import comparison
from vegrip.display.text import Part, first_rows, plain, table_of
from vegrip.identification.compare import Comparison
from vegrip.identification.compare.plot import curves
from vegrip.identification.fit import Fit
from vegrip.identification.fit.result import MISFIT
from vegrip.web.check.render import channels
from vegrip.web.markup import listed, spread, table, unit_name

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LEFT = ("parameter", "unit", "in SI", "effect")


def brief(fit: Fit) -> str:
    effects = ", ".join(one.name for one in fit.problem.model.effects)
    return f"of {fit.recording.name}: {fit.error:.3f} times the noise, with {effects}"


def parts(fit: Fit, most: int | None = None) -> list[Part]:
    """Return parameters and errors by channel, in ``most`` lines where it is given."""
    answer = fit.as_dict()
    others = 5 + len(answer["channels"])  # lines beside the rows of the parameters
    rows, more = first_rows(list(_rows(answer).values()), None if most is None else most - others)
    zeros = answer["zeros"]
    return [
        table_of(("parameter", "value", "std", "unit", "in SI", "effect"), rows, left=LEFT),
        *more,
        comparison.channel_table(answer["channels"]),
        f"all channels: {answer['error']:.3f} times the noise",
        f"zeros: displacement {zeros['displacement']:.3g} m, normal force {zeros['normal_force']:.3g} N",
    ]


def _rows(answer: dict[str, Any]) -> dict[str, tuple[str, ...]]:
    return {
        name: (
            name,
            f"{one['value']:.5g}",
            spread(one, "std"),
            one["unit"],
            f"{one['si']['value']:.3g} {one['si']['unit']}" if "si" in one else "",
            one["effect"],
        )
        for name, one in answer["parameters"].items()
    }


def text(fit: Fit, most: int | None = None) -> str:
    return plain(parts(fit, most))


def card(fit: Fit) -> str:
    answer = fit.as_dict()
    rows = [
        (
            name,
            f"{one['value']:.4g}",
            spread(one, "std"),
            unit_name(one["unit"]),
            one["effect"].replace("_", " "),
        )
        for name, one in answer["parameters"].items()
    ]
    level, name = ("ok", "fits to the noise") if fit.error <= MISFIT else ("bad", "leaves more than noise")
    content = (
        comparison.pictures({"fitted model": curves(_compared(fit))}),
        table(("symbol", "value", "standard error", "unit", "effect"), rows, numbers=(1, 2)),
        channels(answer),
        listed(fit.warnings(advise=False)),
    )
    huge = cards.times_noise(f"{fit.error:.2f}")
    return cards.verdict(f"fit of {fit.recording.name}", level, name, huge, *content)


def _compared(fit: Fit) -> Comparison:
    return Comparison(fit.problem, fit.optimum.u, fitted=True)


def figure(fit: Fit, channel: str) -> "Figure":
    return comparison.figure(_compared(fit), channel)


def columns(fit: Fit) -> dict[str, list[Any]]:
    answer = fit.as_dict()["parameters"]
    names = ("value", "std", "scale", "unit", "effect")
    return {"parameter": list(answer)} | {name: [one[name] for one in answer.values()] for name in names}


def as_json(fit: Fit) -> dict[str, Any]:
    return fit.as_dict() | {"doubts": comparison.doubts_of(fit.problem)}
