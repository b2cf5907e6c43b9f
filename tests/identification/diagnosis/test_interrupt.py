"""An interrupt ends a diagnosis with what was found until then, said to be unfinished."""

import pytest

from vegrip.identification.diagnosis import diagnose
from vegrip.identification.diagnosis.diagnosis import UNFINISHED


def interrupts_at(words: str, after: str = ""):
    seen = []

    def report(text: str) -> None:
        seen.append(text)
        if text.startswith(words) and any(one.startswith(after) for one in seen):
            raise KeyboardInterrupt

    return report


@pytest.mark.slow
def test_what_was_taken_is_a_suggestion_and_nothing_is_named(tip) -> None:
    found = diagnose(tip(4, pull=0.05), threads=1, report=interrupts_at("screens", "takes"), can_stop=True)
    assert found.is_unfinished
    assert found.unproven == UNFINISHED
    assert (found.verdict, found.named) == ("unexplained", [])
    assert found.as_dict()["effects"][0]["outcome"] == "taken, a suggestion"


@pytest.mark.slow
def test_before_anything_is_taken_the_best_so_far_is_said(tip) -> None:
    found = diagnose(tip(4, pull=0.05), threads=1, report=interrupts_at("error"), can_stop=True)
    assert found.is_unfinished
    (said,) = (doubt.text for doubt in found.doubts if doubt.text.startswith(UNFINISHED))
    assert "best so far" in said
    assert found.named == []
    assert str(found).splitlines()[0].endswith("unexplained - stopped before its end, so nothing is named")


def test_who_does_not_ask_for_it_gets_the_interrupt(tip) -> None:
    with pytest.raises(KeyboardInterrupt):
        diagnose(tip(4, pull=0.05), threads=1, report=interrupts_at("screens"))
