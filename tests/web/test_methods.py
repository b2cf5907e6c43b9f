"""What a report says to be cited can be cited: every source of every effect is an entry of BibTeX."""

import html
import re
from typing import Any

import pytest

from vegrip.effects import effect, names
from vegrip.identification.diagnosis.account import effects_of
from vegrip.model import paper_model
from vegrip.web.report.bibtex import bibtex, references, software
from vegrip.web.report.methods import methods_of_model, methods_of_run

VERSIONS = {"vegrip": "0.2.0"}


@pytest.fixture
def told() -> dict[str, Any]:
    """An account of a model of four laws and one that was added."""
    model = paper_model(tip_radius=0.008).with_effect(effect("adhesion"))
    return {
        "data": {"rows": 3045, "duration": 130.44, "episodes": 6, "tip_radius": 0.008, "sha256": "a107"},
        "effects": effects_of(model),
        "diagnosis": {"noise": {"normal_force": "stated by the recording"}},
        "ladder": [{"effect": None, "error": 1.79}, {"effect": "adhesion", "error": 1.02}],
        "verdict": "named",
        "versions": VERSIONS,
    }


def entries(text: str) -> dict[str, str]:
    return dict(re.findall(r"^@\w+\{(\w+),\n(.*?)^\}", text, re.MULTILINE | re.DOTALL))


@pytest.mark.parametrize("name", names())
def test_every_source_of_every_effect_has_author_title_and_year(name: str) -> None:
    found = entries(bibtex(effect(name).cites))
    assert set(found) == set(effect(name).cites)
    for body in found.values():
        assert {"author", "title", "year"} <= set(re.findall(r"^  (\w+) = \{", body, re.MULTILINE))


def test_an_article_is_written_as_bibtex_has_it() -> None:
    assert bibtex(["TiezziKao2007"]) == (
        "@article{TiezziKao2007,\n"
        "  author = {P. Tiezzi and I. Kao},\n"
        "  title = {Modeling of viscoelastic contacts and evolution of limit surface for robotic "
        "contact interface},\n"
        "  journal = {IEEE Transactions on Robotics},\n"
        "  volume = {23},\n"
        "  number = {2},\n"
        "  pages = {206--217},\n"
        "  year = {2007},\n"
        "  doi = {10.1109/TRO.2006.889494},\n"
        "}"
    )


def test_a_book_has_its_edition_and_publisher() -> None:
    (body,) = entries(bibtex(["Fung1993"])).values()
    assert "title = {Biomechanics: Mechanical Properties of Living Tissues}" in body
    assert "edition = {2nd}" in body
    assert "publisher = {Springer}" in body


@pytest.mark.parametrize("key", references())
def test_braces_close_and_nothing_is_left_that_latex_reads_as_a_command(key: str) -> None:
    text = bibtex([key])
    assert text.count("{") == text.count("}")
    assert not re.search(r"(?<!\\)[&_%#$]", text.split("\n", 1)[1])
    assert "*" not in text


def test_the_paragraph_names_each_law_with_its_sources_once_each_in_bibtex(told: dict[str, Any]) -> None:
    text = html.unescape(methods_of_model(told))
    for one in told["effects"]:
        assert f"{one['name'].replace('_', ' ')}, {one['summary']} [{', '.join(one['cites'])}]" in text
    cited = {key for keys in re.findall(r"\[([\w, ]+)\]", text.split("<h3>")[0]) for key in keys.split(", ")}
    assert cited == set(entries(text)) - {"vegrip"}
    assert len(re.findall(r"^@", text, re.MULTILINE)) + text.count(">@") == len(cited) + 1
    for said in (
        "3045 samples over 130.4 s in 6 episodes",
        "8 mm",
        "a107",
        "from 1.79 to 1.02",
        "vegrip 0.2.0",
    ):
        assert said in text


def test_a_source_that_is_not_on_the_list_is_named_and_left_to_the_author(told: dict[str, Any]) -> None:
    told["effects"].append({"name": "mine", "summary": "<b>a law</b> of my own", "cites": ["own"]})
    text = methods_of_model(told)
    assert "the list of references lacks: own" in text
    assert "<b>" not in text
    assert "own" not in entries(html.unescape(text))


def test_a_run_says_that_it_keeps_no_model() -> None:
    fingers = {"thumb": {"duration": 12.0}, "index": {"duration": 11.0}}
    text = html.unescape(methods_of_run({"fingers": fingers}, VERSIONS))
    assert "2 fingers (thumb, index) were recorded for 12 s" in text
    assert "does not keep the model" in text
    assert {"vegrip", "TiezziKao2007", "GoyalRuinaPapadopoulos1991"} <= set(entries(text))


def test_the_entry_of_the_software_names_no_person() -> None:
    assert "author = {{The vegrip contributors}}" in software("0.2.0")
