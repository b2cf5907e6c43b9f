"""BibTeX of what a report cites, out of the project's one list of references (``references.md``). Pure."""

import re
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

LIST = Path(__file__).parent / "references.md"  # docs/references.md
ENTRY = re.compile(r"^\* \*\*\[(\w+)\]\*\* (.*?)(?=^\* \*\*\[|\Z)", re.MULTILINE | re.DOTALL)
# authors end with the first full stop behind a word of three letters, initials do not
AUTHORS = re.compile(r"(?P<author>.+?(?:[^\W\d_]{3,}|:\d{4}|\(ed\.\)))\. (?P<rest>.+)")
ARTICLE = re.compile(
    r"(?P<title>.+?)[.?] \*(?P<journal>[^*]+)\* (?P<volume>\d+)(?:\((?P<number>\d+)\))?, "
    r"(?P<pages>[\d, -]+), (?P<year>\d{4})\.(?: doi:(?P<doi>\S+))?"
)
PAPER = re.compile(r"(?P<title>.+?)\. \*(?P<booktitle>[^*]+)\*, (?P<pages>[\d-]+), (?P<year>\d{4})\.")
BOOK = re.compile(
    r"\*(?P<title>[^*]+)\*(?:, (?P<edition>\w+) edition[^.]*)?\. (?P<publisher>.+), (?P<year>\d{4})[.;].*"
)
KINDS = {"article": ARTICLE, "inproceedings": PAPER, "book": BOOK}
AUTHOR = "The vegrip contributors"  # as in CITATION.cff


@cache
def references() -> Mapping[str, str]:
    """Return the text of every reference by its citation key."""
    return {key: " ".join(text.split()) for key, text in ENTRY.findall(LIST.read_text(encoding="utf-8"))}


def bibtex(keys: Iterable[str]) -> str:
    """Return the entries of ``keys`` in their order; keys that the list does not have are left out."""
    known = references()
    return "\n\n".join(_entry(key, known[key]) for key in dict.fromkeys(keys) if key in known)


def software(version: str) -> str:
    """Return the entry of vegrip itself."""
    title = "vegrip: contact estimation and grip control for robot hands with soft fingertips"
    entry = {"author": f"{{{AUTHOR}}}", "title": title, "version": version, "license": "Apache-2.0"}
    return _written("software", "vegrip", entry)


def _entry(key: str, text: str) -> str:
    if parts := AUTHORS.fullmatch(text):
        for kind, form in KINDS.items():
            if found := form.fullmatch(parts["rest"]):
                return _written(kind, key, {"author": _authors(parts["author"])} | found.groupdict(""))
    return _written("misc", key, {"note": text.replace("*", "")})


def _authors(text: str) -> str:
    """Return names as BibTeX separates them; an organisation has no comma and no initial."""
    names = text.removesuffix(" (ed.)")
    return " and ".join(names.split(", ")) if re.search(r"\b[^\W\d_]{1,2}\. ", names) else f"{{{names}}}"


def _written(kind: str, key: str, fields: Mapping[str, str]) -> str:
    entry = {name: re.sub(r"[&_%#$]", r"\\\g<0>", value) for name, value in fields.items() if value}
    if "pages" in entry:
        entry["pages"] = entry["pages"].replace("-", "--")
    return "\n".join(
        (f"@{kind}{{{key},", *(f"  {name} = {{{value}}}," for name, value in entry.items()), "}")
    )
