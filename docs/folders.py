"""Rooms of docs/architecture.md, folders of docs/folders.txt: a folder imports only folders named before it.

``python docs/folders.py`` says what each is for, and which rule is broken; ``python docs/folders.py FOLDER``
what a folder imports; ``tests/test_architecture.py`` asks the same.
"""

import ast
import re
import sys
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "architecture.md"
ORDER = ROOT / "docs" / "folders.txt"
BESIDE = ("launch", "nodes", "proto")  # top-level folders, shipped as vegrip.<name>
NOT_SHIPPED = ("benchmarks", "tools", "validation")
ROOM = re.compile(
    r"^\| \*\*([\w ]+)\*\* \| [^|]+ \| ([^|]+) \|$", re.MULTILINE
)  # name and what it may import
FOLDERS = re.compile(r"^\*\*([\w ]+)\*\*: (`[^*\n]+`)$", re.MULTILINE)  # of a room, in their order
GROUND = "."  # the modules of vegrip itself: messages, clock, errors, ... which every folder may import
START = "vegrip.__main__"
FRONT_DOOR = "vegrip"  # imports nothing before a public name is asked for, see tests/test_front_door.py


def declared() -> str:
    """Return the rooms of the page and the folders of the list, as text."""
    return PAGE.read_text(encoding="utf-8") + ORDER.read_text(encoding="utf-8")


def page() -> str:
    """Return the page of the site: what each folder is for, by its room."""
    lines, last = ["# Folders", "", "A folder imports only folders before it.", ""], ""
    for room, folder in folders_of(declared()):
        lines += ["", f"## {room}", ""] if room != last else []
        lines.append(f"* `{folder}`: {purpose(folder)}")
        last = room
    return "\n".join([*lines, ""])


def sources() -> dict[str, Path]:
    """Return the file of every module, by its dotted name."""
    found = {}
    for top in ("vegrip", *BESIDE, *NOT_SHIPPED):
        for path in (ROOT / top).rglob("*.py"):
            parts = path.relative_to(ROOT).with_suffix("").parts
            name = ".".join(("vegrip", *parts) if top in BESIDE else parts)
            found[name.removesuffix(".__init__")] = path
    return found


def folder_of(path: Path) -> str:
    """Return the folder of a module as the table names it: ``estimator/kernels``, ``nodes``."""
    parts = path.parent.relative_to(ROOT).parts
    return "/".join(parts[1:] if parts[0] == "vegrip" else parts) or GROUND


def imported(name: str, modules: dict[str, Path]) -> set[str]:
    """Return the modules of the project that a module imports, at its top or inside a function."""
    return {full if full in modules else module for full, module in _imports(modules[name])} & modules.keys()


@cache
def _imports(path: Path) -> frozenset[tuple[str, str]]:
    """Return what a file imports: a name that may be a module, and the module that has it if it is none."""
    names: set[tuple[str, str]] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {(alias.name, alias.name) for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {(f"{node.module}.{alias.name}", node.module) for alias in node.names}
    return frozenset(names)


@cache
def arrows() -> dict[str, set[str]]:
    """Return, for each folder with code, the other folders that it imports."""
    modules = sources()
    found: dict[str, set[str]] = {folder_of(path): set() for path in modules.values()}
    for name, path in modules.items():
        if name not in (START, FRONT_DOOR):
            targets = {folder_of(modules[target]) for target in imported(name, modules)}
            found[folder_of(path)] |= targets - {folder_of(path)}
    return found


def circle() -> list[str]:
    """Return the modules that import each other in a circle; empty: there is none."""
    modules = sources()
    graph = {name: imported(name, modules) - {name, FRONT_DOOR} for name in modules}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def named(targets: set[str]) -> str:
    """Return folders as they stand in a sentence."""
    return ", ".join(f"`{target}`" for target in sorted(targets - {GROUND})) or "nothing"


def folders_of(text: str) -> list[tuple[str, str]]:
    """Return room and folder, in the order of the page."""
    return [
        (room, name) for room, names in FOLDERS.findall(text) for name in re.findall(r"`([\w/]+)`", names)
    ]


def purpose(folder: str) -> str:
    """Return the first line of what a folder says of itself."""
    top = folder.split("/", maxsplit=1)[0]
    place = ROOT / folder if top in (*BESIDE, *NOT_SHIPPED) else ROOT / "vegrip" / folder
    tree = ast.parse((place / "__init__.py").read_text(encoding="utf-8"))
    return (ast.get_docstring(tree) or "").partition("\n")[0]


def trespasses(text: str) -> Iterator[str]:
    """Say which folder imports a room that its own room may not import, and which room has no folder."""
    allowed = {name: set(others.split(", ")) for name, others in ROOM.findall(text)}
    rooms = {folder: room for room, folder in folders_of(text)}
    for name in sorted(allowed.keys() ^ set(rooms.values())):
        yield f"the room {name or 'without a name'} is in one of the two lists only"
    used: dict[str, set[str]] = {name: set() for name in allowed}
    for folder, targets in sorted(arrows().items()):
        room = rooms.get(folder, "")
        for target in sorted(targets & rooms.keys()):
            used.setdefault(room, set()).add(rooms[target])
            if rooms[target] not in allowed.get(room, set()) | {room}:
                yield f"{folder} imports `{target}`, which {room} may not"
    for name, others in allowed.items():
        for other in sorted(others - used[name] - {"nothing"}):
            yield f"{name} may import {other}, and does not"


def complaints(text: str) -> Iterator[str]:
    """Say in a sentence each what is wrong with the page, or with the code."""
    found, names = arrows(), [folder for _, folder in folders_of(text)]
    for name in sorted(found.keys() - {GROUND} - set(names)):
        yield f"the folder {name} is not named"
    for name in sorted(set(names)):
        if name not in found:
            yield f"there is no folder {name}"
        if names.count(name) > 1:
            yield f"the folder {name} is named {names.count(name)} times"
    if found[GROUND]:
        yield f"modules of vegrip itself import {named(found[GROUND])}; every folder stands on them"
    if round_trip := circle():
        yield f"modules import each other: {' -> '.join(round_trip)}"
    for place, name in enumerate(names):
        if below := found.get(name, set()) & set(names[place + 1 :]):
            yield f"{name} imports {named(below)}, which comes later"
    yield from trespasses(text)


def main() -> int:
    """Say what folders are for, or what they import, and what is wrong."""
    text = declared()
    for folder in sys.argv[1:]:
        print(f"{folder} imports {named(arrows().get(folder, set()))}")  # noqa: T201
    for _, folder in folders_of(text) if not sys.argv[1:] else ():
        print(f"{folder}: {purpose(folder)}")  # noqa: T201
    wrong = list(complaints(text))
    for complaint in wrong:
        print(f"docs/architecture.md: {complaint}", file=sys.stderr)  # noqa: T201
    return min(len(wrong), 1)


if __name__ == "__main__":
    sys.exit(main())
