"""docs/folders.txt names every folder once, and imports point one way: to folders named before."""

import ast
import importlib.util
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
_spec = importlib.util.spec_from_file_location("folders", ROOT / "docs" / "folders.py")
folders = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(folders)

PAGE = folders.declared()


def test_the_folders_of_the_page_are_true_and_no_import_points_down() -> None:
    assert list(folders.complaints(PAGE)) == []


def test_the_page_of_the_site_says_what_every_folder_is_for() -> None:
    told = dict(re.findall(r"^\* `([\w/]+)`: (.+)$", folders.page(), re.MULTILINE))
    assert set(told) == {folder for _, folder in folders.folders_of(PAGE)}
    assert all(told.values())


def test_no_import_leads_back_to_where_it_came_from() -> None:
    arrows = {name: set(targets) for name, targets in folders.arrows().items()}
    while leaves := {name for name, targets in arrows.items() if not targets}:
        arrows = {name: targets - leaves for name, targets in arrows.items() if name not in leaves}
    assert arrows == {}, "a circle of imports"


def test_a_module_that_imports_itself_through_another_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    imports = folders.imported
    back = {"vegrip.clock": {"vegrip.types"}, "vegrip.types": {"vegrip.clock"}}
    monkeypatch.setattr(folders, "imported", lambda name, modules: back.get(name) or imports(name, modules))
    assert any("modules import each other" in said for said in folders.complaints(PAGE))


def test_what_is_installed_imports_nothing_that_is_not() -> None:
    for name, targets in folders.arrows().items():
        if name.split("/")[0] not in folders.NOT_SHIPPED:
            assert {target.split("/")[0] for target in targets}.isdisjoint(folders.NOT_SHIPPED), name


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("`host`,", "`guest`,", "the folder host is not named"),
        ("`host`,", "`effects`,", "the folder effects is named 2 times"),
        ("`host`,", "`guest`,", "there is no folder guest"),
        ("`host`,", "`cli`,", ", which comes later"),
    ],
)
def test_a_page_that_is_not_true_is_reported(old: str, new: str, complaint: str) -> None:
    assert old in PAGE
    assert any(complaint in said for said in folders.complaints(PAGE.replace(old, new, 1)))


def test_a_room_imports_no_room_that_its_row_leaves_out() -> None:
    row = next(
        line for line in PAGE.splitlines() if line.startswith("| **Pages** |") and "Instrument" in line
    )
    shut = PAGE.replace(row, row.replace(", Instrument", ""))
    assert any("which Pages may not" in said for said in folders.complaints(shut))
    wide = PAGE.replace(row, row.replace(", Instrument", ", Instrument, Simulators"))
    assert "Pages may import Simulators, and does not" in folders.complaints(wide)


def test_a_new_import_that_points_down_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    arrows = folders.arrows()
    monkeypatch.setattr(folders, "arrows", lambda: arrows | {"host": {"cli"}})
    assert any("host imports `cli`, which comes later" in said for said in folders.complaints(PAGE))


def test_modules_of_the_package_itself_import_no_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    arrows = folders.arrows()
    monkeypatch.setattr(folders, "arrows", lambda: arrows | {folders.GROUND: {"model"}})
    assert any("modules of vegrip itself import `model`" in said for said in folders.complaints(PAGE))


ACROSS = ("attack", "hidden", "install", "law", "security", "vcan", "grip/compiled")
"""Tests of what goes through several folders."""


def test_tests_stand_where_the_folder_stands_that_they_test() -> None:
    tests = ROOT / "tests"
    found = {path.parent.relative_to(tests).as_posix() for path in tests.rglob("test_*.py")}
    own = {folder for folder in found if not folder.startswith(ACROSS)}
    assert {
        folder for folder in own if not any((ROOT / at / folder).is_dir() for at in ("vegrip", "."))
    } == set()


PLACES = re.findall(r"`(vegrip/[\w/]+\.py)`: ((?:`[\w.]+`(?:, )?)+)", PAGE)


@pytest.mark.parametrize(("file", "names"), PLACES, ids=[f"{file}-{names}" for file, names in PLACES])
def test_what_the_page_says_is_in_a_file_is_there(file: str, names: str) -> None:
    tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
    for name in re.findall(r"`([\w.]+)`", names):
        place: ast.AST = tree
        for part in name.split("."):
            kinds = ast.FunctionDef | ast.ClassDef
            found = [
                one for one in ast.iter_child_nodes(place) if isinstance(one, kinds) and one.name == part
            ]
            assert found, f"{file} has no {name}"
            place = found[0]


def test_the_page_says_where_the_steps_of_a_sample_are() -> None:
    assert len(PLACES) > 12
