"""Check the documents: links and pictures resolve, commands exist, examples run, words are British.

Run it with ``make docs``; it prints what is wrong with file and line, and fails.
"""

import contextlib
import doctest
import importlib
import io
import os
import pkgutil
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import english
import figures

import vegrip
from vegrip.cli import COMMANDS
from vegrip.web.report.bibtex import references

ROOT = Path(__file__).parents[1]
SHELL = os.environ | {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
COMMAND = re.compile(r"^\s*(?:\.venv/bin/)?vegrip ([a-z][\w-]*)", re.MULTILINE)
NAMED_FILE = re.compile(
    r"`((?:[\w.-]+/)*[\w-]+\.py|(?:vegrip|tests|validation|tools|benchmarks|examples|nodes|docs|proto|launch)/[\w./-]+)`"
)
MODULE = re.compile(r"python -m ((?:vegrip|validation|benchmarks|tools)(?:\.\w+)+)")
CITATION = re.compile(r"\[([A-Z][A-Za-z]+\d{4}[a-z]?)\]_")
HEADING = re.compile(r"^#+ +(.*)$", re.MULTILINE)
FENCE = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)
RUN_AS_THEY_STAND = (  # pages whose commands are run
    "docs/measured.md",
    "docs/changed.md",
    "docs/tutorials/missing-effect.md",
)
RUN_IN_ORDER = ("docs/python.md",)  # pages whose Python blocks go on from each other, and print what follows
NUMBER = re.compile(r"-?\d[\d.]*(?:e-?\d+)?")


def documents() -> list[Path]:
    """Every page of the project."""
    pages = [
        *ROOT.glob("*.md"),
        *ROOT.glob("docs/**/*.md"),
        *ROOT.glob("proto/*.md"),
        *ROOT.glob("paper/*.md"),
        *ROOT.glob("examples/**/*.md"),
    ]
    return sorted(pages)


def broken_links(page: Path, text: str) -> Iterator[str]:
    """Links to files and headings that are not there."""
    for match in LINK.finditer(text):
        file, _, heading = match[1].partition("#")
        target = page.parent / file if file else page
        if "://" in match[1]:
            continue
        place = f"{page.relative_to(ROOT)}:{line_of(text, match.start())}"
        if not target.exists():
            yield f"{place}: no such file: {match[1]}"
        elif heading and target.suffix == ".md" and heading not in headings(target):
            yield f"{place}: no such heading: {match[1]}"


@cache
def headings(page: Path) -> set[str]:
    """Return the headings of a page as links name them."""
    prose = FENCE.sub("", page.read_text(encoding="utf-8"))
    return {
        re.sub(r"[^\w\- ]", "", line).strip().lower().replace(" ", "-") for line in HEADING.findall(prose)
    }


def missing_files(page: Path, text: str) -> Iterator[str]:
    """Names of our files, whole or by their last parts, that are not there."""
    if page.name not in ("CHANGELOG.md", "export-c.md"):  # of former files, of files that a command writes
        for match in NAMED_FILE.finditer(FENCE.sub(lambda fence: re.sub(r"[^\n]", " ", fence[0]), text)):
            if f"/{match[1].rstrip('/')}" not in endings():
                yield f"{page.relative_to(ROOT)}:{line_of(text, match.start())}: no such file: {match[1]}"


@cache
def endings() -> set[str]:
    """Return the paths of the project's files and folders, and all their last parts."""
    found = set()
    for top in (ROOT, *(path for path in ROOT.iterdir() if path.is_dir() and path.name[0] != ".")):
        for path in top.glob("*") if top == ROOT else top.rglob("*"):
            parts = path.relative_to(ROOT).parts
            found |= {"/" + "/".join(parts[i:]) for i in range(len(parts))}
    return found


def unknown_commands(page: Path, text: str) -> Iterator[str]:
    """Commands shown in a page that the program does not have."""
    for fence in FENCE.finditer(text):
        if fence[1] in ("", "sh", "bash", "console"):
            for match in COMMAND.finditer(fence[2]):
                if match[1] not in COMMANDS:
                    line = line_of(text, fence.start(2) + match.start())
                    yield f"{page.relative_to(ROOT)}:{line}: no such command: vegrip {match[1]}"


def unknown_modules(page: Path, text: str) -> Iterator[str]:
    """Modules of ours that a page runs with ``python -m`` and that are not there."""
    if page.name == "CHANGELOG.md":
        return
    for match in MODULE.finditer(text):
        path = ROOT.joinpath(*match[1].split("."))
        if not path.with_suffix(".py").exists() and not (path / "__main__.py").exists():
            yield f"{page.relative_to(ROOT)}:{line_of(text, match.start())}: no such module: {match[1]}"


def failing_blocks(page: Path, text: str) -> Iterator[str]:
    """Python blocks that do not run as they stand."""
    if str(page.relative_to(ROOT)) in RUN_IN_ORDER:
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            yield from _failing_in_order(page, text)
        return
    for fence in FENCE.finditer(text):
        if fence[1] == "python":
            try:
                exec(compile(fence[2], str(page), "exec"), {"__name__": "__main__"})  # noqa: S102
            except Exception as error:  # noqa: BLE001
                line = line_of(text, fence.start())
                yield f"{page.relative_to(ROOT)}:{line}: the example fails: {error!r}"


def _failing_in_order(page: Path, text: str) -> Iterator[str]:
    """Blocks that fail after those before them, or print other words than the ``text`` block behind them.

    Numbers may differ: another machine gives another last digit.
    """
    known: dict[str, object] = {"__name__": "__main__"}
    printed, fences = "", list(FENCE.finditer(text))
    for fence in fences:
        place = f"{page.relative_to(ROOT)}:{line_of(text, fence.start())}"
        if fence[1] == "python":
            out = io.StringIO()
            try:
                with contextlib.redirect_stdout(out):
                    exec(compile(fence[2], str(page), "exec"), known)  # noqa: S102
            except Exception as error:  # noqa: BLE001
                yield f"{place}: the example fails: {error!r}"
            printed = out.getvalue()
        elif fence[1] == "text":
            said, told = (NUMBER.sub("#", " ".join(one.split())) for one in (fence[2], printed))
            if said != told:
                yield f"{place}: is not what the block above prints, which is\n{printed}"


def failing_commands(page: Path, text: str) -> Iterator[str]:
    """Commands of the pages RUN_AS_THEY_STAND that fail, or do not print what stands behind their #.

    And lines of their ``text`` blocks that no command prints.
    """
    if str(page.relative_to(ROOT)) not in RUN_AS_THEY_STAND:
        return
    printed, fences = "", list(FENCE.finditer(text))
    with tempfile.TemporaryDirectory() as folder:
        for fence in fences:
            for line in fence[2].splitlines() if fence[1] == "sh" else ():
                command, _, told = line.partition("#")
                done = subprocess.run(
                    ["/bin/bash", "-c", command],
                    cwd=folder,
                    env=SHELL,
                    capture_output=True,
                    text=True,
                    check=False,
                )
                out = " ".join(done.stdout.split())
                printed += f"{out} "
                if done.returncode or told.strip() not in out:
                    place = f"{page.relative_to(ROOT)}:{line_of(text, fence.start())}"
                    yield f"{place}: {command.strip()}: exit code {done.returncode}, {done.stdout[:200]!r}"
    for fence in fences:
        for line in fence[2].splitlines() if fence[1] == "text" else ():
            if line != "..." and " ".join(line.split()) not in printed:
                yield f"{page.relative_to(ROOT)}:{line_of(text, fence.start())}: not printed: {line}"


def english_of_page(page: Path, text: str) -> Iterator[str]:
    """Words of a page that are not in the project's English."""
    for position, complaint in english.complaints(text):
        yield f"{page.relative_to(ROOT)}:{line_of(text, position)}: {complaint}"


def english_of_code() -> Iterator[str]:
    """The same for docstrings and comments, and for the messages of what is installed."""
    for folder in (
        "vegrip",
        "nodes",
        "proto",
        "launch",
        "validation",
        "benchmarks",
        "tools",
        "examples",
        "docs",
    ):
        for source in sorted((ROOT / folder).rglob("*.py")):
            shown = english.messages_of(source) if folder in ("vegrip", "nodes", "validation") else ()
            for line, text, message in [
                *((line, text, False) for line, text in english.prose_of(source)),
                *((line, text, True) for line, text in shown),
            ]:
                for _, complaint in english.complaints(text, message=message):
                    yield f"{source.relative_to(ROOT)}:{line}: {complaint}"


def unresolved_citations() -> Iterator[str]:
    """Citation keys used in the code that docs/references.bib does not explain."""
    sources = [
        path for folder in ("vegrip", "nodes", "validation") for path in ROOT.glob(f"{folder}/**/*.py")
    ]
    for source in sorted(sources):
        for key in set(CITATION.findall(source.read_text(encoding="utf-8"))):
            if key not in references():
                yield f"{source.relative_to(ROOT)}: citation [{key}] is not in docs/references.bib"


def failing_doctests() -> Iterator[str]:
    """Examples in docstrings that do not give what they say."""
    for info in pkgutil.walk_packages(vegrip.__path__, "vegrip."):
        if ">>>" in (source_of(info.name) or ""):
            failed, _ = doctest.testmod(importlib.import_module(info.name))
            if failed:
                yield f"{info.name}: {failed} docstring examples fail"


def source_of(module: str) -> str | None:
    """The text of one of our modules, without importing it."""
    path = ROOT.joinpath(*module.split("."))
    for candidate in (path.with_suffix(".py"), path / "__init__.py"):
        if candidate.exists():
            return candidate.read_text(encoding="utf-8")
    return None


def line_of(text: str, position: int) -> int:
    """The line number of a position in a text."""
    return text.count("\n", 0, position) + 1


def main() -> int:
    """Check everything; return how many things are wrong."""
    wrong: list[str] = []
    for page in documents():
        text = page.read_text(encoding="utf-8")
        wrong += [*broken_links(page, text), *unknown_commands(page, text), *failing_blocks(page, text)]
        wrong += failing_commands(page, text)
        wrong += [*missing_files(page, text), *unknown_modules(page, text), *english_of_page(page, text)]
    wrong += [*english_of_code(), *unresolved_citations(), *failing_doctests()]
    wrong += figures.stale_figures()
    for complaint in wrong:
        print(complaint, file=sys.stderr)  # noqa: T201
    print(f"{len(documents())} pages checked, {len(wrong)} things wrong")  # noqa: T201
    return min(len(wrong), 1)


if __name__ == "__main__":
    sys.exit(main())
