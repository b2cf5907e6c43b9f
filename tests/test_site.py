"""The site asks for nothing beyond its folder, and the project's words are British and name who acts."""

import importlib.util
import re
import tomllib
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import ModuleType

import pytest

from vegrip.cli import COMMANDS
from vegrip.transport.maps import products
from vegrip.web.report.bibtex import references

DOCS = Path(__file__).parents[1] / "docs"


def load(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


check = load(DOCS / "site" / "check.py")
english = load(DOCS / "english.py")
product_pages = load(DOCS / "site" / "product_pages.py")
command_pages = load(DOCS / "site" / "command_pages.py")
setting_pages = load(DOCS / "site" / "setting_pages.py")
reference_pages = load(DOCS / "site" / "reference_pages.py")
constant_pages = load(DOCS / "site" / "constant_pages.py")


def said_of(folder: Path, body: str, style: str = "") -> list[str]:
    (folder / "index.html").write_text(f"<html><body id='top'>{body}</body></html>")
    (folder / "there.html").write_text("<p id='place'>there</p>")
    (folder / "site.css").write_text(style)
    check.parsed.cache_clear()
    return list(check.complaints(folder.resolve()))


@pytest.mark.parametrize(
    "body",
    [
        "<a href='https://example.org'>a reader may follow it</a>",
        "<a href='there.html#place'>there</a><a href='#top'>up</a><link rel='stylesheet' href='site.css'>",
        "<img src='data:image/png;base64,AA=='>",
        "<link rel='canonical' href='https://example.org/index.html'>",
    ],
)
def test_a_page_may_name_what_it_does_not_load(tmp_path: Path, body: str) -> None:
    assert said_of(tmp_path, body, "a { background: url(there.html) }") == []


@pytest.mark.parametrize(
    ("body", "style", "complaint"),
    [
        (
            "<script src='https://cdn.example/x.js'></script>",
            "",
            "index.html: loads https://cdn.example/x.js",
        ),
        ("<img src='//cdn.example/x.png'>", "", "index.html: loads //cdn.example/x.png"),
        (
            "<link rel='stylesheet' href='https://x.example/y.css'>",
            "",
            "index.html: loads https://x.example/y.css",
        ),
        ("", "@import 'https://x.example/y.css';", "site.css: loads https://x.example/y.css"),
        ("", "a { src: url(https://x.example/f.woff2) }", "site.css: loads https://x.example/f.woff2"),
        (
            '<pre class="mermaid">a</pre>',
            "",
            "index.html: has an element for which the theme loads a script from elsewhere",
        ),
        ("<a href='gone.html'>x</a>", "", "index.html: gone.html: no such file"),
        ("<a href='there.html#gone'>x</a>", "", "index.html: there.html#gone: no such place on that page"),
    ],
)
def test_what_a_page_loads_from_elsewhere_or_points_nowhere_is_reported(
    tmp_path: Path, body: str, style: str, complaint: str
) -> None:
    assert complaint in said_of(tmp_path, body, style)


@pytest.mark.parametrize(
    "text", ["the color of the line", "It is normalized.", "Whoever reads it", "nobody listens"]
)
def test_american_spelling_and_sentences_without_an_actor_are_reported(text: str) -> None:
    assert list(english.complaints(text))


@pytest.mark.parametrize(
    "text", ["the colour", "of size 3", "`scipy.optimize`", "finalized", "color=RED", "at least"]
)
def test_identifiers_and_british_words_pass(text: str) -> None:
    assert not list(english.complaints(text))


def test_messages_are_in_the_words_of_the_field(tmp_path: Path) -> None:
    source = tmp_path / "module.py"
    source.write_text(
        '"""A module that is told of nothing."""\n'
        'def f(x):\n    raise ValueError(f"{x} cannot be told apart")\n'
        'plot(loc="lower center right")\nKEY = "told"\n'
    )
    assert [text for _, text in english.messages_of(source)] == [" cannot be told apart"]
    assert list(english.complaints(" cannot be told apart", message=True))
    assert not list(english.complaints(" cannot be distinguished", message=True))


def test_every_command_has_its_section_in_the_reference() -> None:
    text = "".join(page for _, page in command_pages.pages())
    for name, about in COMMANDS.items():
        assert f"| [`vegrip {name}`](#vegrip-{name}) | {about} |" in text
        assert f"## vegrip {name}\n" in text
    assert "candump" in text


def test_the_literature_is_written_from_the_entries_of_bibtex() -> None:
    lines = reference_pages.page().splitlines()
    assert (
        "* **[GoyalRuinaPapadopoulos1991]** S. Goyal, A. Ruina, J. Papadopoulos. Planar sliding with dry "
        "friction. Part 1: limit surface and moment function. *Wear* 143, 307-330, 1991." in lines
    )
    assert sum(line.startswith("* **[") for line in lines) == len(references())


def test_every_constant_that_the_page_of_friction_names_is_in_the_reference() -> None:
    named = set(re.findall(r"`([A-Z][A-Z_]{3,})`", (DOCS / "friction.md").read_text("utf-8"))) - {"DEGRADED"}
    listed = set(re.findall(r"^\| `([A-Z_]+)` \| [^|]+ \| [^|]+ \|$", constant_pages.page(), re.MULTILINE))
    assert "SCATTER" in named
    assert named <= listed


def test_a_number_without_an_explanation_is_no_row(tmp_path: Path) -> None:
    source = tmp_path / "numbers.py"
    source.write_text("A1 = 2.0  # [s] why\nB1 = 3.0\nC1 = 4.0\n'''Also\nwhy.'''\nD1 = list()  # no\n")
    assert list(constant_pages.rows(source)) == ["| `A1` | 2.0 | [s] why |", "| `C1` | 4.0 | Also why. |"]


@pytest.mark.parametrize("words", ["pip install", "decimal comma", "play log", "candump"])
def test_a_newcomers_words_lead_to_a_page(words: str) -> None:
    """The search of the site takes pages that have all words."""
    pages = {page.name: page.read_text("utf-8").lower() for page in DOCS.glob("*.md")}
    found = {name for name, text in pages.items() if all(word in text for word in words.split())}
    assert found & {"install.md", "recordings.md"}


def test_each_product_has_a_page_that_says_how_far_it_is_verified() -> None:
    nav = (DOCS.parent / "mkdocs.yml").read_text()
    pages = dict(product_pages.pages())
    assert set(pages) == {"index.md", *(f"{name}.md" for name in products.names())}
    for name in products.names():
        told, page = products.about(name), pages[f"{name}.md"]
        assert f"reference/products/{name}.md" in nav
        assert f"({name}.md)" in pages["index.md"]
        assert told["source"] in page
        assert (told["checked_against"] or "from its source alone") in page
        assert "Nobody has reported yet" in page
        assert all(f"`{key}`" in page for key in told["to_measure"])
        assert "drive_" not in page


def keys_of(table: dict[str, object], prefix: str = "") -> Iterator[str]:
    for key, value in table.items():
        if isinstance(value, dict):
            yield from keys_of(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}"


def test_every_key_of_the_launch_files_in_the_box_is_in_the_reference_of_settings() -> None:
    text = setting_pages.page()
    for path in (DOCS.parent / "launch").glob("*.toml"):
        file = tomllib.loads(path.read_text(encoding="utf-8"))
        keys = {*keys_of(file.get("transport", {}))}
        for node in file["node"]:
            its_own = node.pop("parameters", {}) if node["program"] == "grasp_force" else {}
            node.pop("parameters", None)
            keys |= {*keys_of(node.pop("transport", {})), *keys_of(node), *keys_of(its_own)}
        assert [key for key in keys if f"| `{key}` |" not in text] == [], path.name


def test_a_setting_is_shown_with_unit_default_and_bounds() -> None:
    text = setting_pages.page()
    assert "| `loop.deadline` | `0.01` | 1e-05 .. 10 | a command later than" in text
    assert "| `limits.min_force` | `0.3` | 0 .. 1000 | least commanded force; keeps touch [N] |" in text
    assert '| `zero` | `"none"` | `none` or `first` or `baseline` or `contact` |' in text


def covers(key: str, said: Iterable[str]) -> list[str]:
    return [one for one in said if key == one or key.startswith(f"{one}.")]


@pytest.mark.parametrize("table", ["launch", "transport", "grip"])
def test_every_key_of_a_launch_file_has_one_reader_who_changes_it_and_a_reason(table: str) -> None:
    said = tomllib.loads((DOCS / "site" / "who_sets.toml").read_text(encoding="utf-8"))[table]
    keys = setting_pages.keys(table)
    assert [key for key in sorted(keys) if len(covers(key, said)) != 1] == []
    assert [one for one in said if not any(covers(key, [one]) for key in keys)] == []
    assert all(len(one) == 2 and all(one) for one in said.values())


def test_every_option_of_every_command_has_a_reader_and_a_purpose() -> None:
    options = [*command_pages.options()]
    assert {command.split()[1] for _, command, _, _ in options} == COMMANDS.keys()
    assert [f"{command} {option}" for _, command, option, why in options if not why] == []
    page = setting_pages.who_page(options)
    assert "| `vegrip fit` | `--json` | program that reads the answer | " in page
    assert all(f"| `{command}` | `{option}` | " in page for _, command, option, _ in options)


def test_a_hand_has_at_most_as_many_parameters_as_were_counted() -> None:
    """Who adds one asks first who changes it and why, or what it follows from."""
    assert len(setting_pages.keys("grip")) <= 49
