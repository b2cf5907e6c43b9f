"""The page of effects has what the code has."""

from pathlib import Path

import pytest

from vegrip.effects import BUILT_IN, effect

PAGE = (Path(__file__).parents[2] / "docs" / "effects.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", BUILT_IN)
def test_the_page_lists_every_parameter_with_its_typical_value_prior_and_bounds(name):
    row = next(line for line in PAGE.splitlines() if line.startswith(f"| [{name}]"))
    for p in effect(name).parameters:
        std = f"{100.0 * p.std:g} %" if p.transform == "log" else f"{p.std:g}"
        unit = "" if p.unit == "1" else f" {p.unit}"
        absent = "" if p.null is None else f", absent at {p.null:g}"
        assert f"`{p.symbol}` {p.default:g} ± {std}{unit} ({p.low:g} .. {p.high:g}{absent})" in row
    assert all(other in row for other in effect(name).confounded)
    assert effect(name).experiment in row


def test_the_page_is_in_the_order_in_which_effects_act():
    places = [PAGE.index(f"| [{name}]") for name in BUILT_IN]
    assert places == sorted(places)
