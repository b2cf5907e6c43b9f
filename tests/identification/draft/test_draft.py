"""A drafted law is the hidden one, or none is drafted, and the reason is said."""

import json
import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from vegrip.cli import main
from vegrip.effects import effect
from vegrip.effects.file import effect_of
from vegrip.identification.draft import Draft, draft
from vegrip.identification.draft.grammar import LAW_PLACES, LAW_SHAPES, LAW_VARIABLES, Law
from vegrip.identification.draft.search import Screened, sharpened
from vegrip.identification.draft.text import law_text
from vegrip.identification.recording import read_recording
from vegrip.model import paper_model, read_model
from vegrip.model.laws import broken_laws

from . import tip

HIDDEN = [
    pytest.param(tip.wear, "force", ["way"], id="wear"),
    pytest.param(tip.quick_when_deep, "rate", ["depth"], id="quick when deep", marks=pytest.mark.long),
]


@pytest.mark.long
def test_a_body_that_is_touched_at_a_depth_is_drafted_over_the_depth_and_bends_there(tmp_path: Path) -> None:
    """Its sign is not found: the exponent of the plain law has risen to make up for it."""
    tip.write_presses(tip.second_body, tmp_path / "presses")
    found = draft(read_recording(tmp_path / "presses"))
    assert found.taken is not None, found.reason
    assert found.taken.law.variables == ["depth"]
    assert found.taken.parameters["s"] == pytest.approx(tip.SECOND_BODY_MM, rel=0.05)
    assert found.taken.fitted.error < 0.7 * found.base.error


@pytest.mark.long
@pytest.mark.parametrize(("law", "place", "variables"), HIDDEN)
def test_a_law_that_no_catalogue_has_is_found_again(
    law: tip.Law, place: str, variables: list[str], tmp_path: Path
) -> None:
    tip.write_presses(law, tmp_path / "presses")
    found = draft(read_recording(tmp_path / "presses"))
    assert found.taken is not None, found.reason
    assert (found.taken.law.place.name, found.taken.law.variables) == (place, variables)
    assert found.taken.fitted.error < 1.05
    assert found.base.error > 1.5
    assert broken_laws(effect_of(found.text_of(found.taken, found.name), "the draft")) == []


def stand_in(variable: str, worth: float, *failed: str) -> SimpleNamespace:
    law = SimpleNamespace(variables=[variable], in_words=variable)
    return SimpleNamespace(law=law, failed=failed, worth=worth)


def test_a_rival_passes_depends_on_something_else_and_is_as_good() -> None:
    best, same = stand_in("way", 9000.0), stand_in("way", 8999.0)
    near, worse, broken = (
        stand_in("work", 8992.0),
        stand_in("load", 8900.0),
        stand_in("time", 9001.0, "little"),
    )
    found = Draft(None, None, "law", [best, same, near, worse, broken], best)
    assert found.rivals == [near]
    assert Draft(None, None, "law", [broken]).rivals == []


@pytest.mark.parametrize("hidden", [0.02, 0.4, 25.0, 290.0])
def test_a_memory_between_the_times_that_are_tried_is_found_on_the_screen(hidden: float) -> None:
    law = Law(LAW_PLACES["force"], LAW_VARIABLES["recent_contact"], LAW_SHAPES["saturating"], 1.0)

    def score(law: Law, at: dict[str, float]) -> Screened:
        return Screened(law, -abs(math.log(at["tau"] / hidden)), at, 1.0)

    screen = SimpleNamespace(score=score)
    found, looks = sharpened(screen, score(law, {"s": 0.2, "tau": 10.0}))
    assert found.at["tau"] == pytest.approx(max(hidden, 0.033), rel=0.3)
    assert found.at["s"] == 0.2
    assert looks < 20


def test_of_noise_alone_no_law_is_drafted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tip.write_presses(tip.nothing, tmp_path / "presses")
    file = tmp_path / "law.py"
    assert main(["draft", str(tmp_path / "presses"), "-o", str(file), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["verdict"], told["law"], told["file"], told["variables"]) == ("none", None, None, [])
    assert told["reason"] == "the model leaves only noise; there is no law to be found here"
    assert set(told["error"]) == {"before", "after", "noise_floor"}
    assert not file.exists()


def test_one_episode_is_no_ground_for_a_law(tmp_path: Path) -> None:
    tip.write_presses(tip.wear, tmp_path / "presses", episodes=1)
    found = draft(read_recording(tmp_path / "presses"))
    assert found.verdict == "none"
    assert "one episode" in found.reason


@pytest.mark.long
def test_a_law_under_which_a_held_force_grows_is_not_written(tmp_path: Path) -> None:
    tip.write_presses(tip.thixotropic, tmp_path / "presses")
    found = draft(read_recording(tmp_path / "presses"))
    assert found.verdict == "none"
    assert "grows under a constant indentation" in found.reason


@pytest.mark.parametrize("name", ["Law.py", "2law.py", "law.txt", "class.py", "adhesion.py"])
def test_a_file_that_cannot_name_an_effect_is_refused_before_the_work(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["draft", str(tmp_path), "-o", str(tmp_path / name)]) == 2
    assert capsys.readouterr().err.count("\n") == 1


LAWS = [
    Law(
        LAW_PLACES[variable.places[i % len(variable.places)]], variable, list(LAW_SHAPES.values())[i % 4], 1.5
    )
    for i, variable in enumerate(LAW_VARIABLES.values())
]


@pytest.mark.long
@pytest.mark.parametrize(
    "law", LAWS, ids=lambda law: f"{law.place.name}-{law.variable.name}-{law.shape.name}"
)
def test_every_sentence_of_the_grammar_is_an_effect_that_holds_to_the_laws(law: Law) -> None:
    assert broken_laws(effect_of(law_text(law, "one", {}), "the draft")) == []


def test_an_effect_in_a_file_is_added_saved_and_read_again(tmp_path: Path) -> None:
    law = Law(LAW_PLACES["elastic"], LAW_VARIABLES["depth"], LAW_SHAPES["beyond"], 1.5)
    (tmp_path / "bottom.py").write_text(law_text(law, "bottom", {}))
    model = paper_model(8e-3).with_effect(effect(str(tmp_path / "bottom.py")))
    text = "\n".join(
        ["[fingertip]", "tip_radius = 0.008"]
        + [f"[[effects]]\nname = '{one.name}'" for one in model.effects[:-1]]
        + ["[[effects]]", "name = 'bottom'", "file = 'bottom.py'"]
    )
    (tmp_path / "model.toml").write_text(text)
    again = read_model(tmp_path / "model.toml")
    t = np.linspace(0.0, 1.0, 50)
    np.testing.assert_array_equal(
        again.with_value("K", model.values["K"].value).simulate(t, 1.4e-3 * t).normal_force,
        model.simulate(t, 1.4e-3 * t).normal_force,
    )


@pytest.mark.parametrize(("name", "words"), [("presses", " over 47.5"), ("depth", " over 47.5 x_ref")])
def test_a_size_has_its_unit_and_a_number_has_none(name: str, words: str) -> None:
    law = Law(LAW_PLACES["force"], LAW_VARIABLES[name], LAW_SHAPES["saturating"], 47.5)
    assert law.scaled.endswith(words)
    assert law.scaled in law.in_words
