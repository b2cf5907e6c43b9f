"""A figure of the prose stands in one table, and a page that says another is found."""

import importlib.util
import re
from pathlib import Path

DOCS = Path(__file__).parents[1] / "docs"
SPEC = importlib.util.spec_from_file_location("figures", DOCS / "figures.py")
assert SPEC is not None
assert SPEC.loader is not None
figures = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(figures)


def test_every_page_says_what_was_measured():
    assert list(figures.stale_figures()) == []


def test_a_page_that_says_another_figure_is_named_with_the_command(tmp_path, monkeypatch):
    table = (DOCS / "figures.toml").read_text()
    changed = re.sub(r'(^learning = .*)"[0-9.]+"\]', r'\1"9.9"]', table, flags=re.MULTILINE)
    (tmp_path / "figures.toml").write_text(changed)
    monkeypatch.setattr(figures, "TABLE", tmp_path / "figures.toml")
    found = list(figures.stale_figures())
    assert [text.partition(":")[0] for text in found] == ["README.md", "paper/paper.md"]
    assert "9.9 times" in found[0]
    assert "vegrip controllers --grasp pinch" in found[0]


def test_measuring_writes_the_values_and_nothing_else(tmp_path, monkeypatch):
    table = tmp_path / "figures.toml"
    command = """["printf", '{\"a\": {\"b\": 2.345}}']"""
    text = f'[x]\ncommand = {command}\n[x.values]\none = ["a/b", ".1f", "9.9"]\n[x.pages]\n'
    table.write_text(text)
    monkeypatch.setattr(figures, "TABLE", table)
    figures.measure("x")
    assert table.read_text() == text.replace('"9.9"', '"2.3"')
