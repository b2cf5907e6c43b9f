"""The distribution holds all of the project's packages, and only one of them is on top."""

import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
SETUP = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]


def test_every_package_folder_is_shipped() -> None:
    mapped = {name: folder for name, folder in SETUP["package-dir"].items() if name != "vegrip"}
    ours = {".".join(init.parent.relative_to(ROOT).parts) for init in (ROOT / "vegrip").rglob("__init__.py")}
    for name, folder in mapped.items():
        for init in (ROOT / folder).rglob("__init__.py"):
            ours.add(".".join((name, *init.parent.relative_to(ROOT / folder).parts)))
    assert sorted(SETUP["packages"]) == sorted(ours)


def test_the_import_name_is_vegrip_alone() -> None:
    assert {name.split(".")[0] for name in SETUP["packages"]} == {"vegrip"}
