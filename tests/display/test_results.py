"""What results show: text, card, picture, table and JSON; of the sample recording, which hides adhesion."""

import json
import pydoc
import sys
from html.parser import HTMLParser
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

import vegrip
from vegrip.cli import load
from vegrip.display import diagnosis as shown
from vegrip.displayed import Result
from vegrip.identification.diagnosis.error_ladder import Refinement, build_ladder
from vegrip.identification.samples import recording as sample_recording
from vegrip.jsonable import jsonable

VOID = {"br", "meta", "link", "img", "input", "circle", "path", "rect"}


class Page(HTMLParser):
    """Every tag that is opened and how often, and whether all are closed in order."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open, self.seen, self.scripts = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.seen.append(tag)
        self.scripts += [name for name, value in attrs if name.startswith("on") or "//" in (value or "")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open.pop() == tag


@pytest.fixture(scope="module")
def results():
    recording = sample_recording()
    start = vegrip.fit(recording)
    found = vegrip.diagnose(recording)
    better = start.add(*found.named)
    return {
        "recording": recording,
        "fit": start,
        "better": better,
        "comparison": vegrip.compare(recording, start.model),
        "diagnosis": found,
        "ladder": vegrip.ladder([start, better]),
        "refinement": Refinement(build_ladder(found), "press", found),
        "changed": vegrip.changed(recording, sample_recording("press-later.csv")),
        "model": better.model,
        "contact": vegrip.ContactEstimate(10**9, "index", 1),
        "margin": vegrip.SlipMargin(10**9, "index", 1, vegrip.Estimate(0.5, 0.1, True, 0.0), 0.3, 0.95),
    }


NAMES = (
    "recording", "fit", "better", "comparison", "diagnosis", "ladder", "refinement",
    "changed", "model", "contact", "margin",
)  # fmt: skip
KINDS = (vegrip.Diagnosis, vegrip.Fit, vegrip.Comparison, vegrip.Ladder, vegrip.Draft)
DRAWN = NAMES[:-3]


@pytest.mark.parametrize("name", NAMES)
def test_what_is_printed_is_at_most_fifteen_lines_and_its_name_one(results, name):
    one = results[name]
    assert 1 < len(str(one).splitlines()) <= 15
    assert repr(one).startswith(f"<{type(one).__name__} ")
    assert "\n" not in repr(one)
    assert len(repr(one)) < 250


def test_what_a_fit_prints_has_units_and_says_nothing_of_what_was_not_tested(results):
    lines = [line.split() for line in str(results["fit"]).splitlines()]
    K, pull = (next(line for line in lines if line[0] == name) for name in ("K", "tangential_force"))
    assert K[3:5] == ["%", "N"]
    assert pull[3] == "N"
    assert "nan" not in str(results["fit"])  # of a pull whiteness is not tested


@pytest.mark.parametrize("name", NAMES)
def test_a_card_is_whole_has_a_drawing_and_asks_for_nothing(results, name):
    page = Page(results[name]._repr_html_())
    assert page.open == []
    assert "svg" in page.seen
    assert "script" not in page.seen
    assert page.scripts == []


@pytest.mark.parametrize("name", DRAWN)
def test_every_axis_of_a_picture_has_a_unit(results, name):
    figure = results[name].plot()
    for axis in figure.axes:
        assert "[" in axis.get_ylabel()
        assert "[" in axis.get_xlabel() or axis.get_xlabel() == "model" or not axis.get_xticklabels()
    assert figure._repr_png_().startswith(b"\x89PNG")


@pytest.mark.parametrize("name", DRAWN)
def test_a_table_has_columns_of_one_length_and_is_a_data_frame_where_pandas_is(results, name, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    columns = results[name].table()
    assert len({len(values) for values in columns.values()}) == 1
    assert all(isinstance(values, np.ndarray) for values in columns.values())
    monkeypatch.setitem(sys.modules, "pandas", SimpleNamespace(DataFrame=lambda given: ("frame", *given)))
    assert results[name].table() == ("frame", *columns)


def test_the_error_falls_to_the_noise_with_what_is_named(results):
    rungs = results["ladder"].rungs
    assert [rung.effect for rung in rungs] == [None, "adhesion"]
    assert rungs[0].error > 1.5
    assert rungs[1].error < 1.05
    assert rungs[1].error == pytest.approx(results["diagnosis"].error["after"], rel=2e-3)


@pytest.mark.long
def test_terminal_and_json_say_the_same_as_python(results, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    vegrip.sample("press")
    found = results["diagnosis"]
    runner, command = CliRunner(), load("diagnose")
    told = json.loads(runner.invoke(command, ["press", "--json"]).stdout)
    assert told.keys() == json.loads(found.to_json()).keys()
    assert told["error"] == pytest.approx(jsonable(found.error))
    monkeypatch.setattr("vegrip.identification.diagnosis.diagnose", lambda *_, **__: found)
    printed = runner.invoke(command, ["press"]).stdout
    said = [line.split() for line in printed.splitlines()]
    assert said[: len(str(found).splitlines())] == [line.split() for line in str(found).splitlines()]


def test_of_a_long_search_the_first_lines_keep_what_was_taken_and_say_how_much_is_left_out(monkeypatch):
    def one(i):
        figures = dict.fromkeys(("evidence_gain", "heldout_gain", "error_after"), 1.0)
        return {"round": i, "name": f"effect_{i}", "taken": i == 29, "outcome": "-", **figures}

    found = SimpleNamespace(rounds=[one(i) for i in range(30)])
    monkeypatch.setattr(shown, "_head", lambda _: ["head"] * 4)
    monkeypatch.setattr(shown, "_tail", lambda _: ["tail"] * 3)
    lines = shown.text(found, 15).splitlines()
    assert len(lines) == 15
    assert "effect_29" in lines[5]
    assert "and 24 more" in lines[11]
    assert len(shown.text(found).splitlines()) == 4 + 1 + 30 + 3


@pytest.mark.parametrize("kind", KINDS)
def test_help_is_a_screen_and_names_what_there_is(kind):
    lines = pydoc.render_doc(kind, renderer=pydoc.plaintext).splitlines()
    assert len(lines) <= 50
    for name in Result._calls:
        assert any(f"{name}(self" in line for line in lines)


@pytest.mark.parametrize("kind", KINDS)
def test_every_attribute_that_a_class_names_is_there(kind):
    text = kind.__doc__.partition("Attributes:")[2]
    named = [
        line.strip().partition(":")[0].removesuffix("()") for line in text.splitlines() if line[8:9].strip()
    ]
    assert named
    for name in named:
        assert hasattr(kind, name) or name in kind.__dataclass_fields__


def test_what_comes_a_thousand_times_a_second_carries_no_dictionary(results):
    assert not hasattr(results["contact"], "__dict__")
    assert not hasattr(results["margin"], "__dict__")


def test_a_channel_that_is_not_there_is_named_with_those_that_are(results):
    with pytest.raises(
        vegrip.errors.UsageError, match="no channel 'force'; it is one of normal_force, tangential"
    ):
        results["fit"].plot("force")


@pytest.mark.parametrize(("before", "explains"), [(0.99, False), (1.01, True)])
def test_what_is_named_explains_a_misfit_only_where_there_is_one(before: float, *, explains: bool) -> None:
    """With a tolerance the model without it may leave less than the noise already."""
    found = SimpleNamespace(is_unfinished=False, doubts=[], verdict="named", error={"before": before})
    assert ("explains the misfit" in shown.sentence_of(found)) is explains
