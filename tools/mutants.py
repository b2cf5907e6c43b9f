"""Change one operator, comparison, boolean or number at a time, and see whether a test fails.

A mutant is a copy of the tree with one change on disk, where kernels are read as text and compiled. The
nearest tests run first: those that import the file; then those of its folder, and others that name its
folder, until one fails or the time for a mutant is over. A test that fails counts if it passes without the
change; one that takes too long stands for a loop without end. Results are kept in ``build/mutants``, and a
further run goes on from there; ``--again`` runs what survived.
"""

import argparse
import ast
import contextlib
import hashlib
import json
import math
import os
import queue
import re
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from itertools import pairwise, zip_longest
from pathlib import Path
from typing import Any

import pytest

BEGUN = time.monotonic()
ROOT = Path(__file__).parents[1]
WORK = ROOT / "build" / "mutants"
EQUIVALENT = Path(__file__).with_name("equivalent_mutants.toml")
FOLDERS = [
    *("contact", "effects", "estimator", "grip", "transport/codec", "transport/canbus"),
    *("identification/fit", "identification/diagnosis"),
]
LEFT_OUT = {".git", ".venv", "build", "out", "recordings", "__pycache__", ".hypothesis", ".pytest_cache"}
RESULTS = WORK / "results.jsonl"
SURVIVED = "survived"
SLOWEST = 300  # [s] for one test: those that take more than about ten are marked `long`, and left out
AT_ONCE = 8  # files of tests in a process: all of a folder take long to import
SECONDS = "VEGRIP_MUTANT_SECONDS"

CHANGES = """+ -> - | - -> + | * -> / | / -> * | // -> * | % -> + | ** -> * | & -> ^ | ^ -> & | << -> >>
>> -> << | < -> <= | < -> >= | <= -> < | <= -> > | > -> >= | > -> <= | >= -> > | >= -> < | == -> != | != -> ==
is -> is not | is not -> is | in -> not in | not in -> in | and -> or | or -> and"""
OPERATORS = [tuple(change.split(" -> ")) for change in re.split(r" \| |\n", CHANGES)]


@dataclass(frozen=True)
class Mutant:
    """One change of a file: ``size`` bytes from ``start`` become ``new``."""

    path: str
    start: int
    size: int
    new: str
    line: int
    before: str
    after: str
    repeat: int  # equal lines that were changed in the same way further up

    @property
    def name(self) -> str:
        """Say what is changed, whatever else changes in the file."""
        return f"{self.path} | {self.before} | {self.after} | {self.repeat}"

    def applied(self, text: bytes) -> bytes:
        """Return the text of the file with the change."""
        return text[: self.start] + self.new.encode() + text[self.start + self.size :]

    def rank(self, seed: int) -> str:
        """Order the mutants at random, so that more of them, or another change of a file, keep the first."""
        return hashlib.sha256(f"{seed} {self.name}".encode()).hexdigest()


def mutants(path: Path) -> Iterator[Mutant]:
    """Give every change of a file. Types, messages and what decorates a function or class stay."""
    text = path.read_bytes()
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    seen: Counter[tuple[str, str]] = Counter()
    for start, size, new in sorted(_changes(ast.parse(text), text, starts)):
        number = next(i for i, begin in enumerate(starts) if begin > start)
        begin, end = starts[number - 1], starts[number]
        before = text[begin:end].decode().strip()
        after = (text[begin:start] + new.encode() + text[start + size : end]).decode().strip()
        yield Mutant(
            str(path.relative_to(ROOT)), start, size, new, number, before, after, seen[before, after]
        )
        seen[before, after] += 1


def _changes(node: ast.AST, text: bytes, starts: list[int]) -> Iterator[tuple[int, int, str]]:
    def begin(child: Any) -> int:
        return starts[int(child.lineno) - 1] + int(child.col_offset)

    def end(child: Any) -> int:
        return starts[int(child.end_lineno) - 1] + int(child.end_col_offset)

    def between(left: ast.AST, right: ast.AST) -> Iterator[tuple[int, int, str]]:
        gap = re.sub(rb"#[^\n]*|[()\\]", lambda found: b" " * len(found[0]), text[end(left) : begin(right)])
        operator = gap.strip().removesuffix(b"=" if isinstance(node, ast.AugAssign) else b"").decode()
        yield from (
            (end(left) + gap.index(old.encode()), len(old), new) for old, new in OPERATORS if old == operator
        )

    match node:
        case ast.BinOp(left=left, right=right) | ast.AugAssign(target=left, value=right):
            yield from between(left, right)
        case ast.BoolOp(values=values):
            yield from (one for pair in pairwise(values) for one in between(*pair))
        case ast.Compare(left=left, comparators=others):
            yield from (one for pair in pairwise([left, *others]) for one in between(*pair))
        case ast.UnaryOp(op=ast.Not()):
            yield begin(node), len("not"), ""
        case ast.UnaryOp(op=ast.USub()):
            yield begin(node), len("-"), "+"
        case ast.Constant(value=bool() as value):
            yield begin(node), len(str(value)), str(not value)
        case ast.Constant(value=int() | float() as value):
            new = repr(value + 1 if isinstance(value, int) and value < 10 else 2 * value or 1.0)
            yield begin(node), end(node) - begin(node), new
    for field, child in ast.iter_fields(node):
        if field in ("annotation", "returns", "decorator_list", "bases", "keywords") and isinstance(
            node, ast.arg | ast.AnnAssign | ast.FunctionDef | ast.ClassDef
        ):
            continue
        for one in child if isinstance(child, list) else [child]:
            if isinstance(one, ast.AST) and not isinstance(one, ast.JoinedStr | ast.Raise):
                yield from _changes(one, text, starts)


@cache
def texts(folder: str) -> dict[str, str]:
    """Return the text of each file below a folder of the project."""
    return {str(path.relative_to(ROOT)): path.read_text() for path in sorted((ROOT / folder).rglob("*.py"))}


def related(path: str) -> list[str]:
    """Return the tests of a file, of what imports it, of its folder, and those that name its folder.

    Among each of these, first stand those in which most of the file's names are.
    """
    package, top = ".".join(Path(path).parts[:-1]), ROOT / "tests" / Path(path).parts[1]
    body = ast.parse((ROOT / path).read_text()).body
    names = {one.name for one in body if isinstance(one, ast.FunctionDef | ast.ClassDef)}
    texts_of_users = texts("vegrip") | texts("validation")
    users = [file for file, text in texts_of_users.items() if file != path and _imports(path).search(text)]

    def distance(file: str) -> tuple[int, int]:
        shared = len(names & set(re.findall(r"\w+", texts("tests")[file])))
        if _tests(file, path):
            return 0, -shared
        if any(_tests(file, user) for user in users):
            return 1, -shared
        if (ROOT / file).is_relative_to(_mirror(path)):
            return 2, -shared
        return 3 if (ROOT / file).is_relative_to(top) or package in texts("tests")[file] else 4, -shared

    found = [file for file in texts("tests") if Path(file).name.startswith("test_") and distance(file)[0] < 4]
    return sorted(found, key=distance)


def _tests(file: str, path: str) -> bool:
    text, stem = texts("tests")[file], Path(path).stem
    named = stem in Path(file).stem or f'"{stem}"' in text
    return (named and (ROOT / file).is_relative_to(_mirror(path))) or _imports(path).search(text) is not None


@cache
def _imports(path: str) -> re.Pattern[str]:
    *folders, stem = Path(path).with_suffix("").parts
    return re.compile("\\b" + r"\.".join(folders) + rf"(\.{stem}\b| import [^\n]*\b{stem}\b)")


@cache
def _mirror(path: str) -> Path:
    mirror = ROOT / "tests" / path.removeprefix("vegrip/")
    while not mirror.is_dir():
        mirror = mirror.parent
    return mirror


class Tree:
    """A copy of the project, in which one change at a time is made and tested."""

    def __init__(self, number: int) -> None:
        self.path = WORK / f"tree-{number}"
        shutil.rmtree(self.path, ignore_errors=True)
        shutil.copytree(ROOT, self.path, ignore=lambda _, names: LEFT_OUT & set(names), symlinks=True)
        self.written = time.time()

    def write(self, path: str, text: bytes) -> None:
        """Write a file with a time of its own: compiled code counts as new for the same second and size."""
        (self.path / path).write_bytes(text)
        self.written += 2.0
        os.utime(self.path / path, (self.written, self.written))

    def tested(self, files: list[str], without: set[str], seconds: float) -> tuple[str, str]:
        """Return ``survived``, ``killed`` or ``timeout``, and the test that failed."""
        own = {
            "PYTHONPATH": f"{self.path}:{self.path / 'tools'}",
            "OPENBLAS_NUM_THREADS": "1",
            "VEGRIP_CACHE": str(WORK / "compiled"),
            "VEGRIP_DATA": os.environ.get("VEGRIP_DATA", str(ROOT.parent / "shared" / "data")),
            SECONDS: str(seconds),
        }
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "mutants", "-p", "no:cacheprovider"]
        command += ["-m", "not wheel and not long and not browser", *(f"--deselect={one}" for one in without)]
        with subprocess.Popen(
            [*command, *files],
            cwd=self.path,
            env=os.environ | own,
            start_new_session=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        ) as process:
            said = process.stdout.read() if process.stdout else ""
            code = process.wait()
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)  # what a test has left behind
        if code in (0, 5):  # 5: no test is left after those marked `long`
            return SURVIVED, ""
        failed = re.search(r"^(?:FAILED|ERROR) (\S+?\.py(?:::\w+)*)", said, re.MULTILINE)
        return "timeout" if code == -signal.SIGALRM else "killed", failed[1] if failed else ""


def pytest_configure() -> None:
    """End the process when a module takes too long to import."""
    signal.alarm(SLOWEST)


def pytest_runtest_setup() -> None:
    """Skip what does not fit into the time of a mutant; end the process when one test takes too long."""
    if time.monotonic() - BEGUN > float(os.environ[SECONDS]):
        pytest.skip("no time is left for this mutant")
    signal.alarm(SLOWEST)


class Round:
    """Runs mutants in some trees at once, and keeps what came of them."""

    def __init__(self, jobs: int, seconds: float) -> None:
        WORK.mkdir(parents=True, exist_ok=True)
        self.trees: queue.SimpleQueue[Tree] = queue.SimpleQueue()
        for number in range(jobs):
            self.trees.put(Tree(number))
        self.seconds = seconds
        self.sound: set[str] = set()
        self.unsound: set[str] = set()

    def run(self, mutant: Mutant) -> str:
        """Return what the tests make of a mutant, the nearest first, for as long as there is time."""
        begun = time.monotonic()
        tree = self.trees.get()
        try:
            result, failed = self.judged(mutant, tree)
            while failed and not self.passes(failed, tree):
                result, failed = self.judged(mutant, tree)
        finally:
            self.trees.put(tree)
        keep(RESULTS, mutant.name, result)
        change = f"{mutant.path}:{mutant.line}: {mutant.before}  ->  {mutant.after}"
        print(f"{result} in {time.monotonic() - begun:.0f} s: {change}  {failed}", flush=True)
        return result

    def judged(self, mutant: Mutant, tree: Tree) -> tuple[str, str]:
        """Return what came of a mutant, and the test that failed."""
        end = time.monotonic() + self.seconds
        text = (tree.path / mutant.path).read_bytes()
        tree.write(mutant.path, mutant.applied(text))
        result, failed = SURVIVED, ""
        files = related(mutant.path)
        while files and result == SURVIVED and time.monotonic() < end:
            result, failed = tree.tested(files[:AT_ONCE], self.unsound, end - time.monotonic())
            files = files[AT_ONCE:]
        tree.write(mutant.path, text)
        return result, failed

    def passes(self, test: str, tree: Tree) -> bool:
        """Return whether a test passes without a change."""
        if test not in self.sound | self.unsound:
            passed = tree.tested([test], set(), math.inf)[0] == SURVIVED
            (self.sound if passed else self.unsound).add(test)
            print("" if passed else f"{test} fails without a change, and is left out\n", end="", flush=True)
        return test in self.sound


def kept(file: Path) -> Iterator[tuple[str, Any]]:
    """Give what former runs have written, the last of a name last."""
    if file.exists():
        yield from (json.loads(line) for line in file.read_text().splitlines())


def keep(file: Path, name: str, value: str) -> None:
    """Add a line, whole, so that an interrupted run loses none."""
    with file.open("a") as out:
        out.write(json.dumps([name, value]) + "\n")


def sample(folders: list[str], count: int, seed: int) -> dict[str, list[Mutant]]:
    """Return the mutants of each folder: ``count`` in all, without equivalent ones."""
    no_change = tomllib.loads(EQUIVALENT.read_text())
    found: dict[str, list[Mutant]] = {}
    for folder in folders:
        place = ROOT / "vegrip" / folder
        files = sorted(place.rglob("*.py")) if place.is_dir() else [place]
        every = [one for file in files for one in mutants(file) if one.name not in no_change]
        found[folder] = sorted(every, key=lambda one: one.rank(seed))
    share = -(-count // len(folders))
    return {folder: every[:share] for folder, every in found.items()}


def main() -> int:
    """Run a round, and print the share that was caught."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100, help="mutants in all, as many of each folder")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2, help="mutants at a time")
    parser.add_argument("--seconds", type=float, default=300.0, help="of tests for a mutant")
    parser.add_argument(
        "--only", nargs="+", metavar="PATH", default=FOLDERS, help="folders or files below vegrip"
    )
    parser.add_argument("--again", action="store_true", help="run those that survived once more")
    options = parser.parse_args()
    chosen = sample(options.only, options.count, options.seed)
    results = dict(kept(RESULTS))
    left = [
        one
        for row in zip_longest(*chosen.values())  # a round that is cut short has been in every folder
        for one in row
        if one and (one.name not in results or (options.again and results[one.name] == SURVIVED))
    ]
    if left:
        the_round = Round(options.jobs, options.seconds)
        with ThreadPoolExecutor(options.jobs) as pool:
            results |= dict(zip((one.name for one in left), pool.map(the_round.run, left), strict=True))
    print("\nNo test has noticed:")
    for one in (one for every in chosen.values() for one in every if results[one.name] == SURVIVED):
        print(f"{one.path}:{one.line}: {one.before}  ->  {one.after}")
    print()
    for folder, every in {**chosen, "all": [one for some in chosen.values() for one in some]}.items():
        of = Counter(results[one.name] for one in every)
        caught = len(every) - of[SURVIVED]
        late = f"{of['timeout']} by time"
        print(f"{folder:26}{caught:4} of {len(every):3} caught, {caught / len(every):4.0%}; {late}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
