"""What MkDocs asks while it builds the site: pages that are generated, and links out of ``docs/``.

Pages of ``docs/`` also serve a reader of the files: they link to sources, to ``proto/README.md`` and to the
changelog. In the site the latter two are pages, and sources are named without a link.
"""

import posixpath
import re
import sys
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))

from docs import folders  # noqa: E402
from docs.site import (  # noqa: E402
    command_pages,
    constant_pages,
    effect_pages,
    product_pages,
    python_pages,
    reference_pages,
    setting_pages,
)

COPIES = {
    "proto/README.md": "reference/protocol.md",
    "CHANGELOG.md": "reference/changelog.md",
    "CONTRIBUTING.md": "reference/contributing.md",
}
LINK = re.compile(r"(?P<picture>!?)\[(?P<text>[^\]]*)\]\((?P<target>[^)\s]+)\)")
CITATION = re.compile(r"\[([A-Z][A-Za-z]+\d{4}[a-z]?)\]_")  # of docstrings: [TiezziKao2007]_
ROLE = re.compile(
    r":(?:class|meth|func|attr|mod|data|exc):<code>~?(?:[\w.]*\.)?(\w+)</code>"
)  # :class:`~vegrip.x.Name`


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that are generated, and copies."""
    for name, text in command_pages.pages():
        files.append(File.generated(config, f"reference/commands/{name}", content=text))
    for name, text in python_pages.pages():
        files.append(File.generated(config, f"reference/python/{name}", content=text))
    for name, text in product_pages.pages():
        files.append(File.generated(config, f"reference/products/{name}", content=text))
    files.append(File.generated(config, "references.md", content=reference_pages.page()))
    files.append(File.generated(config, "reference/effects.md", content=effect_pages.page()))
    files.append(File.generated(config, "reference/settings.md", content=setting_pages.page()))
    files.append(File.generated(config, "reference/folders.md", content=folders.page()))
    files.append(File.generated(config, "reference/friction.md", content=constant_pages.page()))
    who = setting_pages.who_page(command_pages.options())
    files.append(File.generated(config, "reference/who-sets-what.md", content=who))
    for source, page in COPIES.items():
        text = (ROOT / source).read_text(encoding="utf-8")
        files.append(File.generated(config, page, content=_relinked(text, posixpath.dirname(source), page)))
    return files


def on_page_markdown(markdown: str, page: Page, **_: Any) -> str:
    """Turn links that leave ``docs/`` into pages of the site, or into names."""
    path = page.file.src_uri
    if path.startswith("reference/"):
        return markdown
    return _relinked(markdown, posixpath.dirname(f"docs/{path}"), path)


def on_page_content(html: str, page: Page, **_: Any) -> str:
    """Show the roles and citations of docstrings as names and links."""
    up = posixpath.relpath("references.html", posixpath.dirname(page.file.dest_uri) or ".")
    return CITATION.sub(rf'<a href="{up}">[\1]</a>', ROLE.sub(r"<code>\1</code>", html))


def _relinked(text: str, folder: str, page: str) -> str:
    """Return ``text`` of a file in ``folder`` of the project with the links of the site's ``page``."""

    def replaced(link: re.Match[str]) -> str:
        path, hash_, anchor = link["target"].partition("#")
        if "://" in path or not path:
            return link[0]
        target = posixpath.normpath(posixpath.join(folder, path))
        site = COPIES.get(target) or (
            target.removeprefix("docs/") if target.startswith("docs/") and not target.endswith(".py") else ""
        )
        if target == "README.md":
            site = "index.md"
        if target == "docs/references.bib":
            site = "references.md"
        if not site:
            return (
                link["text"]
                if link["text"].startswith("`")
                else f"`{target}`"
                if link["text"] == target
                else link["text"]
            )
        relative = posixpath.relpath(site, posixpath.dirname(page) or ".")
        return f"{link['picture']}[{link['text']}]({relative}{hash_}{anchor})"

    return LINK.sub(replaced, text)
