"""What no contact does is said of a model, and of no effect of the catalogue."""

import pytest

from vegrip.effects import BUILT_IN, effect
from vegrip.effects.file import effect_of
from vegrip.identification.draft.grammar import LAW_PLACES, LAW_SHAPES, LAW_VARIABLES, Law
from vegrip.identification.draft.text import law_text
from vegrip.identification.fit.obeys import broken_over
from vegrip.model import BASE, paper_model

PLAIN = paper_model(8e-3)


@pytest.mark.parametrize("name", [name for name in BUILT_IN if name not in BASE])
def test_no_effect_of_the_catalogue_breaks_a_law(name: str) -> None:
    assert list(broken_over(PLAIN.with_effect(effect(name)), 1.2e-3, (3e-4, 1e-2), 20.0)) == []


def with_law(place: str, variable: str, amount: float) -> tuple[str, ...]:
    law = Law(LAW_PLACES[place], LAW_VARIABLES[variable], LAW_SHAPES["linear"], 1.0)
    made = effect_of(law_text(law, "one", {}), "the draft")
    model = PLAIN.with_effect(made).with_value("c_one", amount)
    return tuple(broken_over(model, depth=1e-3, speeds=(1e-3, 1e-2), length=20.0))


@pytest.mark.parametrize(
    ("place", "variable", "amount", "broken"),
    [
        ("elastic", "depth", 0.5, ""),
        ("elastic", "depth", -0.7, "pressing deeper takes less force"),
        ("force", "contact_time", 0.3, "grows under a constant indentation"),
        ("force", "speed", -0.1, "gives back more work"),
        ("force", "time", 5.0, "grows without bound"),
        ("sense", "time", 1.0, ""),
    ],
)
def test_a_law_that_no_contact_obeys_is_named(place: str, variable: str, amount: float, broken: str) -> None:
    told = with_law(place, variable, amount)
    assert (told == ()) if not broken else any(broken in sentence for sentence in told), told
