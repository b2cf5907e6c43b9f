"""BibTeX of what a report cites, out of the project's one list of references (``references.bib``). Pure."""

import re
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

LIST = Path(__file__).parent / "references.bib"  # docs/references.bib
ENTRY = re.compile(r"^@\w+\{(\w+),\n.*?^\}$", re.MULTILINE | re.DOTALL)
AUTHOR = "The vegrip contributors"  # as in CITATION.cff


@cache
def references() -> Mapping[str, str]:
    """Return every entry by its citation key."""
    return {found[1]: found[0] for found in ENTRY.finditer(LIST.read_text(encoding="utf-8"))}


def bibtex(keys: Iterable[str]) -> str:
    """Return the entries of ``keys`` in their order; keys that the list does not have are left out."""
    known = references()
    return "\n\n".join(known[key] for key in dict.fromkeys(keys) if key in known)


def software(version: str) -> str:
    """Return the entry of vegrip itself."""
    return (
        "@software{vegrip,\n"
        f"  author = {{{{{AUTHOR}}}}},\n"
        "  title = {vegrip: contact estimation and grip control for robot hands with soft fingertips},\n"
        f"  version = {{{version}}},\n"
        "  license = {Apache-2.0},\n"
        "}"
    )
