"""The distribution holds all of the project's packages, and only one of them is on top."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
SETUP = PROJECT["tool"]["setuptools"]
EXTRAS = set(PROJECT["project"]["optional-dependencies"])


def test_every_package_folder_is_shipped() -> None:
    mapped = {name: folder for name, folder in SETUP["package-dir"].items() if name != "vegrip"}
    ours = {".".join(init.parent.relative_to(ROOT).parts) for init in (ROOT / "vegrip").rglob("__init__.py")}
    for name, folder in mapped.items():
        for init in (ROOT / folder).rglob("__init__.py"):
            ours.add(".".join((name, *init.parent.relative_to(ROOT / folder).parts)))
    assert sorted(SETUP["packages"]) == sorted(ours)


def test_the_import_name_is_vegrip_alone() -> None:
    assert {name.split(".")[0] for name in SETUP["packages"]} == {"vegrip"}


def test_every_file_of_a_package_folder_is_shipped() -> None:
    """The wheel itself is looked at by ``make wheel-test``."""
    tops = [ROOT / folder for folder in SETUP["package-dir"].values()]
    packages = {init.parent for top in tops for init in top.rglob("__init__.py")}
    shipped = {
        path for one in packages for pattern in SETUP["package-data"]["*"] for path in one.glob(pattern)
    }
    files = {
        path
        for top in tops
        for path in top.rglob("*")
        if path.is_file() and path.parent.name != "__pycache__"
    }
    assert sorted(path for path in files - shipped if path.suffix != ".py") == []


def test_the_page_on_installing_explains_every_extra() -> None:
    page = (ROOT / "docs" / "install.md").read_text(encoding="utf-8")
    assert set(re.findall(r"^\* `(\w+)`: ", page, re.MULTILINE)) == EXTRAS


NAMED = re.compile(r"""(?:pip install '[^'\[]*\[|extra_library\([^()]*(?:extra=)?")([\w,]+)(?:\]'|"\))""")


def test_every_extra_that_a_message_or_page_names_exists() -> None:
    texts = [*(ROOT / "vegrip").rglob("*.py"), ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    named = {
        extra
        for path in texts
        for extras in NAMED.findall(path.read_text(encoding="utf-8"))
        for extra in extras.split(",")
    }
    assert named >= {"web", "plot", "hdf5"}
    assert named <= EXTRAS


REGISTRIES = ("pypi" + ".org", "python" + "hosted.org", "ana" + "conda.org", "npm" + "js.", "crates" + ".io")


def test_no_file_names_the_host_of_a_package_registry() -> None:
    """Where packages come from is the business of the machine's own settings."""
    hidden = {".git", ".venv", "build", "out", "recordings", "__pycache__", ".hypothesis"}
    named = []
    for path in ROOT.rglob("*"):
        inside = path.relative_to(ROOT).parts
        if hidden & set(inside) or any(part.startswith(".") and "cache" in part for part in inside):
            continue
        if path.is_file() and path.suffix in {"", ".py", ".md", ".toml", ".txt", ".sh", ".in"}:
            text = path.read_text(encoding="utf-8", errors="replace")
            named += [f"{path.relative_to(ROOT)}: {host}" for host in REGISTRIES if host in text]
    assert not named
