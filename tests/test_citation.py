"""What is written for reviewers agrees with the project: citation, paper, references."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
CITATION = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
PAPER = (ROOT / "paper" / "paper.md").read_text(encoding="utf-8")
BIB = (ROOT / "paper" / "paper.bib").read_text(encoding="utf-8")


def stated(key: str) -> str:
    found = re.search(rf"^{key}: (.+)$", CITATION, re.MULTILINE)
    assert found is not None, key
    return found[1]


def listed(key: str) -> list[str]:
    found = re.search(rf"^{key}:\n((?:  - .+\n)+)", CITATION, re.MULTILINE)
    assert found is not None, key
    return re.findall(r"- (.+)", found[1])


def test_the_citation_is_of_this_version_licence_and_keywords() -> None:
    assert stated("cff-version") == "1.2.0"
    assert stated("version") == PROJECT["version"]
    assert stated("license") == PROJECT["license"]
    assert listed("keywords") == PROJECT["keywords"]


def test_the_authors_are_the_same_everywhere_and_no_person_is_made_up() -> None:
    from vegrip.web.report.bibtex import AUTHOR

    assert listed("authors") == [f"name: {AUTHOR}"]
    header = PAPER.split("---")[1]
    assert re.findall(r"authors:\n  - name: (.+)\n", header) == [AUTHOR]
    assert "authors" not in PROJECT  # who adds names there, adds them here


def test_what_the_paper_cites_is_in_its_bibliography_and_nothing_else() -> None:
    cited = set(re.findall(r"@([A-Za-z]+\d{4})", PAPER))
    assert cited == set(re.findall(r"^@\w+\{(\w+),$", BIB, re.MULTILINE))
    assert BIB.count("{") == BIB.count("}")


def test_the_paper_has_the_sections_and_length_that_the_journal_asks_for() -> None:
    body = PAPER.split("---", 2)[2]
    headings = re.findall(r"^# (.+)$", body, re.MULTILINE)
    assert {"Summary", "Statement of need", "State of the field", "Acknowledgements"} <= set(headings)
    assert headings[-1] == "References"
    assert 750 <= len(body.split()) <= 1750


def test_the_paper_and_the_field_say_that_no_hand_was_tried_while_the_list_is_empty() -> None:
    rows = (ROOT / "docs" / "hardware.md").read_text(encoding="utf-8").split("## Reports")[1].split("##")[0]
    assert rows.count("\n|") == 3
    assert "| none yet |" in rows
    assert "*On a hand of yours: none yet.*" in PAPER
    assert "**none yet**" in (ROOT / "docs" / "field.md").read_text(encoding="utf-8")


def test_the_list_of_references_in_the_package_is_that_of_the_documents() -> None:
    inside = ROOT / "vegrip" / "web" / "report" / "references.bib"
    assert inside.resolve() == ROOT / "docs" / "references.bib"
