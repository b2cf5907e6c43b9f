"""Check the built site: no page asks for anything beyond its own folder, and every local link has its target.

``python docs/site/check.py FOLDER`` prints what is wrong with page and address, and fails.
"""

import re
import sys
from collections.abc import Iterator
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADED = {"src", "srcset", "poster", "data", "xlink:href"}  # attributes that a browser fetches by itself
LINKED = {"link", "use", "image"}  # elements whose href is fetched, not followed
NAMES = {"canonical", "next", "prev"}  # relations of <link> that only name a page
IN_STYLE = re.compile(r"(?:url\(\s*|@import\s+)['\"]?((?:https?:)?//[^'\")\s]+)")
TRIGGERS = re.compile(
    r'class="[^"]*\bmermaid\b|data-md-component="source"'
)  # the theme's script would load a library


class Page(HTMLParser):
    """What one page loads, where it leads, and the names of its places."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.loads: list[str] = []
        self.leads: list[str] = []
        self.places: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Sort the addresses of one element."""
        given = {name: value or "" for name, value in attrs}
        self.places |= {given[name] for name in ("id", "name") if name in given}
        self.loads += [given[name] for name in LOADED & set(given) if given[name]]
        if "href" in given and tag == "a":
            self.leads.append(given["href"])
        elif "href" in given and tag in LINKED and not NAMES & set(given.get("rel", "").split()):
            self.loads.append(given["href"])
        self.loads += IN_STYLE.findall(given.get("style", ""))


def complaints(folder: Path) -> Iterator[str]:
    """Yield what is wrong with the site in ``folder``."""
    for path in sorted(folder.rglob("*.html")):
        name = path.relative_to(folder)
        page = parsed(path)
        yield from (f"{name}: loads {address}" for address in page.loads if is_beyond(address))
        if TRIGGERS.search(path.read_text(encoding="utf-8")):
            yield f"{name}: has an element for which the theme loads a script from elsewhere"
        for address in [*page.loads, *page.leads]:
            if not is_beyond(address) and name.name != "404.html":
                yield from (f"{name}: {address}: {why}" for why in missing(path, address))
    for path in sorted(folder.rglob("*.css")):
        text = path.read_text(encoding="utf-8")
        yield from (f"{path.relative_to(folder)}: loads {address}" for address in IN_STYLE.findall(text))


def is_beyond(address: str) -> bool:
    """Tell whether an address is not in the site's own folder."""
    parts = urlsplit(address)
    return bool(parts.netloc) or parts.scheme in ("http", "https", "mailto")


def missing(path: Path, address: str) -> Iterator[str]:
    """Yield why a local address of the page at ``path`` leads nowhere."""
    parts = urlsplit(address)
    if parts.scheme:  # data:, javascript:
        return
    target = path if not parts.path else (path.parent / unquote(parts.path)).resolve()
    if target.is_dir():
        target /= "index.html"
    if not target.exists():
        yield "no such file"
    elif parts.fragment and target.suffix == ".html" and unquote(parts.fragment) not in parsed(target).places:
        yield "no such place on that page"


@cache
def parsed(path: Path) -> Page:
    """Return the page at ``path``."""
    return Page(path.read_text(encoding="utf-8"))


def main() -> int:
    """Check the folder given as argument; return 1 if anything is wrong."""
    folder = Path(sys.argv[1]).resolve()
    wrong = list(complaints(folder))
    for complaint in wrong:
        print(complaint, file=sys.stderr)  # noqa: T201
    print(f"{len(list(folder.rglob('*.html')))} pages of the site checked, {len(wrong)} things wrong")  # noqa: T201
    return min(len(wrong), 1)


if __name__ == "__main__":
    sys.exit(main())
