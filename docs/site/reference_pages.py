"""The page of the literature, from ``docs/references.bib``."""

import re

from vegrip.web.report.bibtex import references

FIELD = re.compile(r"^  (\w+) = \{(.*)\},$", re.MULTILINE)


def page() -> str:
    """Return the page as Markdown."""
    lines = ["# References", "", "Citation keys as they stand in the code, `[Key]_`.", ""]
    lines += [f"* **[{key}]** {described(entry)}" for key, entry in references().items()]
    return "\n".join([*lines, ""])


def described(entry: str) -> str:
    """Return an entry of BibTeX as a sentence: authors, title, where, year."""
    of = {name: re.sub(r"[{}\\]", "", text).replace("--", "-") for name, text in FIELD.findall(entry)}
    place = f"*{of['journal']}*" if "journal" in of else of.get("booktitle", of.get("publisher", ""))
    number = f"({of['number']})" if "number" in of else ""
    place += f" {of['volume']}{number}" if "volume" in of else ""
    edition = f"{of['edition']} edition" if "edition" in of else ""
    where = [one for one in (place, edition, of.get("howpublished"), of.get("pages"), of["year"]) if one]
    about = [of["author"].replace(" and ", ", "), of["title"], ", ".join(where)]
    about += [of["note"]] if "note" in of else []
    about += [f"doi:{of['doi']}"] if "doi" in of else []
    return "".join(f"{text.removesuffix('.')}. " for text in about).rstrip()
