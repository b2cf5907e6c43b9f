"""A contact model: its effects and values, and a press that it makes."""

from html import escape

import numpy as np

from vegrip.display import card as cards
from vegrip.display.text import first_rows, plain, table_of
from vegrip.model import ContactModel
from vegrip.web.axes import Axes, extent
from vegrip.web.markup import table, unit_name

HEAD = ("parameter", "value", "std", "unit", "effect")
PRESS_S, HOLD_S = 0.5, 1.0  # [s] of the press that is drawn
STEP_S = 0.02  # [s]


def brief(model: ContactModel) -> str:
    effects = ", ".join(one.name for one in model.effects)
    return f"of a tip of radius {1e3 * model.tip_radius:.4g} mm: {effects}"


def _rows(model: ContactModel) -> list[tuple[str, ...]]:
    def std(symbol: str, is_log: bool) -> str:
        known = model.values[symbol].std
        return "fixed" if known == 0.0 else f"{100.0 * known:.2g} %" if is_log else f"{known:.2g}"

    return [
        (
            symbol,
            f"{model.values[symbol].value:.5g}",
            std(symbol, one.transform == "log"),
            unit_name(one.unit),
            name,
        )
        for symbol, (name, one) in model.parameters.items()
    ]


def _origin(model: ContactModel) -> str:
    return ", ".join(f"{key}: {value}" for key, value in model.provenance.items())


def text(model: ContactModel, most: int | None = None) -> str:
    head = [f"tip of radius {1e3 * model.tip_radius:.4g} mm; {_origin(model)}"]
    rows, more = first_rows(_rows(model), None if most is None else most - len(head) - 1)
    return plain([*head, table_of(HEAD, rows, left=("parameter", "unit", "effect")), *more])


def card(model: ContactModel) -> str:
    content = (
        f"<p>{len(model.effects)} effects on a tip of radius {1e3 * model.tip_radius:.4g} mm</p>",
        _press(model),
        table(HEAD, _rows(model), numbers=(1, 2)),
        f'<p class="soft">{escape(_origin(model))}</p>',
    )
    return cards.verdict("contact model", "", "", "", *content)


def _press(model: ContactModel) -> str:
    """Draw force over depth: pressed to the reference depth, held, and released."""
    depth = min(model.reference_depth, model.shown.depth)
    t = np.arange(0.0, 2.0 * PRESS_S + HOLD_S + STEP_S / 2.0, STEP_S)
    x = np.interp(t, [0.0, PRESS_S, PRESS_S + HOLD_S, t[-1]], [0.0, depth, depth, 0.0])
    force = model.simulate(t, x, plain=True).normal_force  # compiled it would not be sooner
    said = f"displacement [mm]: {PRESS_S:g} s in, {HOLD_S:g} s held, {PRESS_S:g} s out"
    axes = Axes(extent((1e3 * x).tolist()), extent(force.tolist()), said, "normal force [N]", (420, 220))
    axes.line((1e3 * x).tolist(), force.tolist(), "blue")
    return f'<div style="max-width:420px">{axes.svg("force over displacement of a press")}</div>'
