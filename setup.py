"""The page of the package: the README with absolute links. Everything else is in ``pyproject.toml``."""

import re
import tomllib
from pathlib import Path

from setuptools import setup

HERE = Path(__file__).parent
LINK = re.compile(r"(?P<picture>!?)\[(?P<text>[^\]]*)\]\((?P<target>[^)\s]+)\)")


def absolute(page: str, home: str) -> str:
    """Return ``page`` with links below ``home``; without a home, their text alone and no pictures."""

    def replaced(link: re.Match[str]) -> str:
        target = link["target"]
        if "://" in target or target.startswith("#"):
            return link[0]
        if home:
            return f"{link['picture']}[{link['text']}]({home.rstrip('/')}/{target})"
        return "" if link["picture"] else link["text"]

    return LINK.sub(replaced, page)


def home() -> str:
    """Return where the files of the project can be read: ``Files`` of ``[project.urls]``, if it is given."""
    project = tomllib.loads((HERE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return str(project.get("urls", {}).get("Files", ""))


if __name__ == "__main__":
    page = absolute((HERE / "README.md").read_text(encoding="utf-8"), home())
    setup(long_description=page, long_description_content_type="text/markdown")
