"""What a check keeps: the ladder, where one stands on it, and all of it over a restart."""

import re
from pathlib import Path

import pytest

from vegrip.errors import InputError, UsageError
from vegrip.web.check.render import body, verdict
from vegrip.web.check.session import CHECK_FILE, Rung, Session, load, save
from vegrip.web.job_page import progress


@pytest.fixture
def session() -> Session:
    session = Session("/data/press")
    session.add(Rung("0-start.toml", None, None, 1.79))
    session.add(Rung("1-adhesion.toml", "adhesion", 0, 1.02))
    return session


def test_undo_goes_back_and_keeps_the_model(session: Session) -> None:
    session.undo()
    assert session.effects == []
    assert [rung.effect for rung in session.rungs] == [None, "adhesion"]


def test_the_start_cannot_be_undone(session: Session) -> None:
    session.undo()
    with pytest.raises(UsageError, match="there is no step to undo"):
        session.undo()


def test_after_undo_another_effect_begins_another_branch(session: Session) -> None:
    session.undo()
    assert session.next_file("guide_friction") == "2-guide_friction.toml"  # no file is written over
    session.add(Rung("2-guide_friction.toml", "guide_friction", session.current, 1.7))
    assert session.effects == ["guide_friction"]
    session.current = 1
    assert session.effects == ["adhesion"]


def test_a_refit_with_episodes_held_back_is_a_model_of_its_own(session: Session) -> None:
    assert session.next_file(None) == "2-refit.toml"
    session.add(Rung("2-refit.toml", None, 1, 1.05, held_back="1,3", held_out={"error": 1.2, "curves": {}}))
    assert session.effects == ["adhesion"]
    assert session.rungs[2].is_refit
    assert not session.rungs[0].is_refit
    assert "which the fit has not seen" in body(session, is_busy=False)


def test_a_check_goes_on_where_it_was(session: Session, tmp_path: Path) -> None:
    session.undo()
    save(session, tmp_path)
    assert load(tmp_path, "/data/press") == session


def test_the_check_of_another_recording_is_refused(session: Session, tmp_path: Path) -> None:
    save(session, tmp_path)
    with pytest.raises(InputError, match="is the check of /data/press"):
        load(tmp_path, "/data/other")


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", '{"recording": "/data/press", "rungs": [{}], "current": 0}']
)
def test_a_damaged_check_is_one_sentence(tmp_path: Path, text: str) -> None:
    (tmp_path / CHECK_FILE).write_text(text)
    with pytest.raises(InputError, match="cannot be read"):
        load(tmp_path, "/data/press")


def test_a_model_that_leaves_more_than_noise_is_a_misfit_until_it_is_diagnosed(session: Session) -> None:
    assert verdict(session.rungs[0])[1] == "unexplained misfit"
    session.rungs[0].diagnosis = {"verdict": "named"}
    assert verdict(session.rungs[0])[1] == "an effect is missing"


def test_while_something_runs_nothing_else_can_be_pressed(session: Session) -> None:
    shown = body(session, is_busy=True)
    pressable = re.findall(r"<(?:button|input|select)[^>]*>", shown)
    assert len(pressable) > 9
    assert all("disabled" in one for one in pressable)
    assert "disabled" not in body(session, is_busy=False)


def test_names_from_files_cannot_become_markup(session: Session) -> None:
    session.add(
        Rung("<script>.toml", "<script>", 1, 1.0, parameters={"<script>": {"value": 1.0, "unit": "<b>"}})
    )
    shown = body(session, is_busy=False) + progress("<script>", 1.0, ["<script>"])
    assert "<script" not in shown
    assert "<b>N" not in shown


LAW = "N *= 1 + c q; q: the way"
ROWS = {"q": [0.0, 1.0], "left": [0.0, -0.1], "law": [0.0, -0.1], "low": [0.0, -0.2], "high": [0.0, 0.0]}
DRAFTED = {
    "law": LAW,
    "reason": "",
    "place": "force law",
    "error": {"before": 4.9, "after": 1.01},
    "rivals": ["the work"],
    "experiment": "a hundred presses",
    "file": "check/law_0.py",
    "rival": "check/rival_0.py",
    "curve": {"title": LAW, "label": "q: the way", "columns": ROWS},
}


def unexplained(draft: dict[str, object] | None) -> str:
    diagnosis = {
        "verdict": "unexplained", "effects": [], "named": [], "indistinguishable": [], "unexplained": None,
        "experiment": None, "doubts": [],
    }  # fmt: skip
    session = Session("/data/tired")
    session.add(Rung("0-start.toml", None, None, 4.9, diagnosis=diagnosis, draft=draft))
    return body(session, is_busy=False)


def test_where_no_effect_explains_the_misfit_a_law_can_be_drafted_seen_and_added() -> None:
    before = unexplained(None)
    assert 'data-do="draft"' in before
    assert "add-law" not in before
    after = unexplained(DRAFTED)
    assert LAW in after
    assert 'data-effect="check/law_0.py"' in after
    assert 'value="check/law_0.py,check/rival_0.py"' in after  # what an experiment is to distinguish
    assert after.count("<circle") >= 4
    assert "as good: the work" in after


def test_where_no_law_is_worth_writing_the_page_says_why() -> None:
    none = unexplained({**DRAFTED, "law": None, "reason": "there is one episode only", "file": None})
    assert "none: there is one episode only" in none
    assert "add-law" not in none
