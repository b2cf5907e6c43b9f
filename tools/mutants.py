"""Change one operator, comparison, boolean or number at a time, and see whether a test fails.

A mutant is a copy of the tree with one change on disk, where kernels are read as text and compiled. Each file
of tests that has to do with it is traced once (``mutant_tests``), and of its tests only those run that enter
what is changed, or load a text with it: the quickest and nearest first, until one fails or the time for a
mutant is over. A test that fails counts if it passes without the change. One that takes thirty seconds more
than ten times as long as it did counts as noticed by time, if without the change it needs less than half of
that. What numba would compile with the change runs in plain Python. Results and records are kept in
``build/mutants``, and a further run goes on from there; ``--again`` runs what survived. Where time was over
before every test had run, the mutant has no answer; it counts as not caught, like one that survived.
"""

import argparse
import ast
import hashlib
import json
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
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise, zip_longest
from pathlib import Path
from threading import Lock
from typing import Any

ROOT = Path(__file__).parents[1]
WORK = ROOT / "build" / "mutants"
EQUIVALENT = Path(__file__).with_name("equivalent_mutants.toml")
FOLDERS = [
    *("contact", "effects", "estimator", "grip", "transport/codec", "transport/canbus"),
    *("identification/fit", "identification/diagnosis"),
]
LEFT_OUT = {".git", ".venv", "build", "out", "recordings", "__pycache__", ".hypothesis", ".pytest_cache"}
DRAWN = re.compile(r"vegrip/contact/paper/figures|:_?draw_")
"""How a figure looks is no behaviour: what it draws is computed elsewhere. In ``file:function``."""
HELPERS = {"vegrip/grip/kernels": "tests.grip.stages"}
"""With which tests, wherever they are, run the texts of a folder, which nothing imports."""
RESULTS = WORK / "results.jsonl"
SURVIVED, UNANSWERED = NOT_CAUGHT = "survived", "no answer"
FAR = 5
SLOWEST = 300  # [s] for what is not a test: imports and collection
SLACK, SLACK_S = 10.0, 30.0  # times as long as it took, and so much more [s], may a test take with a change
LATE_S = 120.0  # [s] the same by the clock, for what waits: other programs of the machine make it late
QUICK_S = 0.5  # [s]
COMPILE_S = 3.0  # [s] that a text takes to compile
DECLARES = re.compile(r"^    \w+: [^\n]*= parameter\(", re.MULTILINE)
DECLARED = "tests/canopen/test_eds.py"  # holds what is declared of parameters against a committed file
LOCK = Lock()
AT_ONCE = 8  # files of tests in a process: all of a folder take long to import

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


@cache
def related(path: str) -> dict[str, int]:
    """Return the files of tests that may notice a change of a file, the nearest first, and how far they are.

    They are the file's own tests and those of what it declares (0), others that import it (1), those of its
    folder (2), of what imports it (3), as all in the folder of a text that does, and those that name its
    folder (4); among each of these, first stand those with most of its names.
    """
    package, top = ".".join(Path(path).parts[:-1]), ROOT / "tests" / Path(path).parts[1]
    body = ast.parse((ROOT / path).read_text()).body
    names = {one.name for one in body if isinstance(one, ast.FunctionDef | ast.ClassDef)}
    helper = HELPERS.get(str(Path(path).parent), "no helper")
    users, declares = users_of(path), DECLARES.search((ROOT / path).read_text()) is not None
    beside = {_mirror(user) for user in users if str(Path(user).parent) in HELPERS}

    def distance(file: str) -> tuple[int, int]:
        shared = len(names & set(re.findall(r"\w+", texts("tests")[file])))
        if _is_named_after(file, path) or (file == DECLARED and declares):
            return 0, -shared
        if _imports(path).search(texts("tests")[file]) or helper in texts("tests")[file]:
            return 1, -shared
        if (ROOT / file).parent == _mirror(path):
            return 2, -shared
        if (ROOT / file).parent in beside or any(
            _is_named_after(file, user) or _imports(user).search(texts("tests")[file]) for user in users
        ):
            return 3, -shared
        return 4 if (ROOT / file).is_relative_to(top) or package in texts("tests")[file] else FAR, -shared

    far = {file: distance(file) for file in texts("tests") if Path(file).name.startswith("test_")}
    return {file: far[file][0] for file in sorted(far, key=far.__getitem__) if far[file][0] < FAR}


@cache
def users_of(path: str) -> list[str]:
    """Return the files that import a file."""
    every = texts("vegrip") | texts("validation")
    return [file for file, text in every.items() if file != path and _imports(path).search(text)]


def _is_named_after(file: str, path: str) -> bool:
    stem = Path(path).stem
    if f'"{stem}"' in texts("tests")[file]:
        return (ROOT / file).is_relative_to(_mirror(path))
    return stem in Path(file).stem and Path(file).parts[1] == Path(path).parts[1]


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


def defined(path: str) -> Iterator[tuple[str, ast.stmt]]:
    """Give what stands in a file: its functions and methods; what else, under the names that it sets."""

    def within(body: list[ast.stmt], prefix: str) -> Iterator[tuple[str, ast.stmt]]:
        for node in body:
            if isinstance(node, ast.ClassDef):
                yield from within(node.body, f"{prefix}{node.name}.")
            elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                yield f"{prefix}{node.name}", node
            elif not isinstance(node, ast.Import | ast.ImportFrom):
                stored = (one for one in ast.walk(node) if isinstance(one, ast.Name))
                yield from ((f"{prefix}{one.id}", node) for one in stored if isinstance(one.ctx, ast.Store))

    yield from within(ast.parse(texts("vegrip")[path]).body, "")


@cache
def named_in(path: str) -> list[tuple[str, bool, set[str]]]:
    """Return what stands in a file, whether it is a function, and the names in it."""
    found = []
    for name, node in defined(path):
        words = {one.id for one in ast.walk(node) if isinstance(one, ast.Name)}
        words |= {one.attr for one in ast.walk(node) if isinstance(one, ast.Attribute)}
        found.append((name, isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef), words))
    return found


def functions_with(mutant: Mutant) -> set[str]:
    """Return the functions that a change is in, or those that take what it changes, as ``file:name``."""
    found: set[str] = set()
    todo, known = [], set()
    for name, node in defined(mutant.path):
        if node.lineno <= mutant.line <= (node.end_lineno or 0):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                return {f"{mutant.path}:{name}"}
            todo += name.split(".")
    while todo:
        word = todo.pop()
        known.add(word)
        pattern = re.compile(rf"\b{word}\b")
        for file, text in texts("vegrip").items():
            if (file == mutant.path or _imports(mutant.path).search(text)) and pattern.search(text):
                for name, is_function, words in named_in(file):
                    if word in words and is_function:
                        found.add(f"{file}:{name}")
                    elif word in words and name not in known:
                        todo.append(name)
    return found


def is_in(mutant: Mutant, text: str) -> bool:
    """Return whether a generated text has what is changed: the line, or all functions of its file.

    What reaches through a dot, or stands in parentheses, is written otherwise there.
    """
    functions = _functions_of(mutant.path)
    return mutant.before in text or (bool(functions) and all(one in text for one in functions))


@cache
def _functions_of(path: str) -> list[str]:
    return re.findall(r"^def \w+\(", texts("vegrip")[path], re.MULTILINE)


@dataclass(frozen=True)
class Traced:
    """A test as it was recorded: how long it took, the functions that it enters, the texts that it loads."""

    name: str
    seconds: float
    of_processor: float  # [s]
    enters: frozenset[str]

    @property
    def limit(self) -> float:
        """How long it may take of the processor [s]: other programs of the machine do not matter."""
        return SLACK_S + SLACK * self.of_processor


class Records:
    """What the tests enter; each file of tests is traced once, and again when it changes."""

    def __init__(self, enough: float) -> None:
        self.runner, self.enough = Runner(ROOT), enough
        self.tests: dict[str, list[Traced]] = {}  # by file
        self.texts: dict[str, str] = {}

    def place(self, file: str) -> Path:
        """Return where the record of a file of tests is."""
        key = hashlib.sha256((file + texts("tests")[file]).encode()).hexdigest()
        return WORK / "records" / f"{key[:24]}.json"

    def load(self, files: Iterable[str]) -> None:
        """Trace the files that have no record, and read those that have."""
        missing = [file for file in files if file not in self.tests and not self.place(file).exists()]
        for group in (missing[i : i + AT_ONCE] for i in range(0, len(missing), AT_ONCE)):
            print(f"traces {', '.join(group)}", flush=True)
            self.trace(group)
            for file in group:  # one whose process ended leaves nothing of the others either
                if len(group) > 1 and not self.place(file).exists():
                    self.trace([file])
        for file in files:
            if file not in self.tests:
                self.tests[file] = list(self._read(self.place(file)))

    def trace(self, files: Sequence[str]) -> None:
        """Record what the tests of some files enter, in one process."""
        task = {
            "record": {file: str(self.place(file)) for file in files},
            "limit": SLOWEST,
            "enough": self.enough,
        }
        self.runner.run(files, task)

    def _read(self, place: Path) -> Iterator[Traced]:
        if not place.exists():  # none of its tests ran: they are `long`, or the process ended
            place.parent.mkdir(exist_ok=True)
            place.write_text(json.dumps({"names": [], "tests": [], "texts": {}}))
        read = json.loads(place.read_text())
        self.texts |= read["texts"]
        for name, seconds, of_processor, enters in read["tests"]:
            if enters:  # it passes
                yield Traced(name, seconds, of_processor, frozenset(read["names"][i] for i in enters))

    def choose(self, mutant: Mutant, distances: list[int]) -> list[Traced]:
        """Return the tests at some distances that run what is changed, quickest first.

        A text with the change takes seconds to compile, once for all tests with it. What is made once and
        kept was entered by the first test alone: behind these stand those that enter a file which imports it.
        """
        files = [file for file, far in related(mutant.path).items() if far in distances]
        self.load(files)
        functions = functions_with(mutant)
        functions |= {f"generated:{name.rpartition(':')[2]}" for name in functions}
        changed = {f"text:{key}" for key, text in self.texts.items() if is_in(mutant, text)}
        tests = [one for file in files for one in self.tests[file]]
        users = Counter(text for one in tests for text in one.enters & changed)
        near = {mutant.path, *users_of(mutant.path)}
        cost: dict[Traced, tuple[bool, float]] = {}
        for one in tests:
            loaded, behind = one.enters & changed, False
            if functions & {name.partition(".<locals>")[0] for name in one.enters}:
                loaded = frozenset()
            elif not loaded and functions:
                behind = True
                if 0 not in distances and not near & {name.partition(":")[0] for name in one.enters}:
                    continue
            cost[one] = behind, one.seconds + sum(COMPILE_S / users[text] for text in loaded)
        return sorted(cost, key=cost.__getitem__)

    def is_text(self, mutant: Mutant) -> bool:
        """Return whether a change is in a text that is compiled, as far as is known by now."""
        return any(is_in(mutant, text) for text in self.texts.values())


class Runner:
    """Runs pytest in forks of one process that has imported what every test needs but nothing of vegrip."""

    def __init__(self, where: Path) -> None:
        self.where = where
        self.said = WORK / f"said-{where.name}"
        self.task = WORK / f"task-{where.name}.json"
        own = {
            "PYTHONPATH": str(Path(__file__).parent),
            "OPENBLAS_NUM_THREADS": "1",
            "VEGRIP_CACHE": str(WORK / "compiled"),
            "VEGRIP_DATA": os.environ.get("VEGRIP_DATA", str(ROOT.parent / "shared" / "data")),
            "VEGRIP_MUTANT_TASK": str(self.task),
        }
        command = [
            sys.executable,
            str(Path(__file__).with_name("mutant_tests.py")),
            str(where),
            str(self.said),
        ]
        self.process = subprocess.Popen(
            command, env=os.environ | own, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def run(self, files: Iterable[str], task: dict[str, Any]) -> tuple[int, str, float]:
        """Run pytest on files of tests with a task; return code, what it said, and its processor time [s]."""
        self.task.write_text(json.dumps(task))
        arguments = ["-q", "-p", "mutant_tests", "-p", "no:cacheprovider", "-p", "no:xdist"]
        arguments += ["-m", "not wheel and not long and not browser", *([] if "record" in task else ["-x"])]
        to, answers = self.process.stdin, self.process.stdout
        assert to is not None and answers is not None  # noqa: PT018, S101 (they are pipes)
        print(json.dumps([*arguments, *files]), file=to, flush=True)
        code, seconds = json.loads(answers.readline())
        return code, self.said.read_text(errors="replace"), seconds


class Tree:
    """A copy of the project, in which one change at a time is made and tested."""

    def __init__(self, number: int) -> None:
        self.path = WORK / f"tree-{number}"
        self.running = WORK / f"running-{number}"
        kept = [(one.relative_to(self.path), one) for one in self.path.rglob("*.nb[ic]")]
        compiled = {place: (one.read_bytes(), one.stat().st_mtime_ns) for place, one in kept}
        shutil.rmtree(self.path, ignore_errors=True)
        shutil.copytree(ROOT, self.path, ignore=lambda _, names: LEFT_OUT & set(names), symlinks=True)
        for place, (content, stamp) in compiled.items():  # numba looks at time and size of the source
            (self.path / place).parent.mkdir(exist_ok=True, parents=True)
            (self.path / place).write_bytes(content)
            os.utime(self.path / place, ns=(stamp, stamp))
        self.written = time.time()
        self.runner = Runner(self.path)

    def write(self, path: str, text: bytes, stamp: float = 0.0) -> None:
        """Write a file with a time of its own: compiled code counts as new for the same second and size."""
        (self.path / path).write_bytes(text)
        self.written += 2.0
        os.utime(self.path / path, (stamp or self.written,) * 2)

    def run(self, tests: list[Traced], seconds: float, *, plain: bool) -> tuple[str, str, float]:
        """Return ``survived``, ``killed`` or ``timeout``, the test that failed, and the processor's time."""
        task = {
            "tests": [one.name for one in tests],
            "limits": {one.name: (one.limit, LATE_S + SLACK * one.seconds) for one in tests},
            "limit": SLOWEST,
            "seconds": seconds,
            "plain": plain,
            "running": str(self.running),
        }
        self.running.write_text("")
        files = dict.fromkeys(one.name.partition("::")[0] for one in tests)
        code, said, spent = self.runner.run([one for one in files if (self.path / one).exists()], task)
        if code in (0, 5):
            return SURVIVED, "", spent
        if code in (-signal.SIGALRM, -signal.SIGPROF):
            return "timeout", self.running.read_text(), spent
        if code == 3 or (code == 4 and "loading conftest" not in said):
            raise RuntimeError(f"pytest does not run:\n{said}")
        return "killed", self.running.read_text() if code == 1 else "", spent


class Round:
    """Runs mutants in some trees at once, and keeps what came of them."""

    def __init__(self, jobs: int, seconds: float, reach: int, enough: float) -> None:
        self.trees: queue.SimpleQueue[Tree] = queue.SimpleQueue()
        for number in range(jobs):
            self.trees.put(Tree(number))
        self.seconds, self.reach = seconds, reach
        self.records = Records(enough)
        self.sound: set[tuple[str, bool]] = set()
        self.unsound: set[tuple[str, bool]] = set()

    def __enter__(self) -> "Round":
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """End the processes that run pytest."""
        for runner in (self.records.runner, *(self.trees.get().runner for _ in range(self.trees.qsize()))):
            runner.process.communicate()

    def run(self, mutant: Mutant) -> str:
        """Return what the tests make of a mutant, for as long as there is time."""
        tree = self.trees.get()
        spent, result, failed, count = 0.0, SURVIVED, "", 0
        try:
            far = range(self.reach + 1)
            # what stands in a table is seen by what reads the table, wherever that is
            for distances in ([one] for one in far) if functions_with(mutant) else [list(far)]:
                with LOCK:
                    tests = self.records.choose(mutant, distances)
                    plain = self.records.is_text(mutant)
                count += len(tests)
                while tests and spent < self.seconds:
                    result, failed, more = self.judged(mutant, tree, tests, self.seconds - spent, plain=plain)
                    spent += more
                    if not failed or self.passes(failed, tree, tests, result, plain=plain):
                        break
                    result = SURVIVED
                if result != SURVIVED:
                    break
            if result == SURVIVED and spent >= self.seconds:
                result = UNANSWERED
        finally:
            self.trees.put(tree)
        keep(RESULTS, mutant.name, result)
        change = f"{mutant.path}:{mutant.line}: {mutant.before}  ->  {mutant.after}"
        of = f"{count} tests"
        print(f"{result} in {spent:.0f} s: {change}  {failed or of}", flush=True)
        return result

    def judged(
        self, mutant: Mutant, tree: Tree, tests: list[Traced], seconds: float, *, plain: bool
    ) -> tuple[str, str, float]:
        """Return what came of a mutant, the test that failed, and the time that it took of the processor."""
        text, stamp = (tree.path / mutant.path).read_bytes(), (tree.path / mutant.path).stat().st_mtime
        tree.write(mutant.path, mutant.applied(text))
        result, failed, spent = SURVIVED, "", 0.0
        left = [one for one in tests if (one.name, plain) not in self.unsound]
        while left and result == SURVIVED and spent < seconds:
            files: set[str] = set()
            some = []  # from not too many files: to import them takes long
            while left and len(files | {left[0].name.partition("::")[0]}) <= AT_ONCE:
                some.append(left.pop(0))
                files.add(some[-1].name.partition("::")[0])
            inside = [one for one in left if one.name.partition("::")[0] in files and one.seconds < QUICK_S]
            left = [one for one in left if one not in inside]
            result, failed, more = tree.run([*some, *inside], seconds - spent, plain=plain)
            spent += more
        tree.write(mutant.path, text, stamp)
        return result, failed, spent

    def passes(self, test: str, tree: Tree, tests: list[Traced], result: str, *, plain: bool) -> bool:
        """Return whether a test passes without the change, far within its time.

        The record of a quick one is proof enough, but not of how it fares in plain Python.
        """
        (one,) = (one for one in tests if one.name == test)
        if one.seconds < QUICK_S and result != "timeout" and not plain:
            return True
        key = (test, plain)
        if key not in self.sound | self.unsound:
            half = replace(one, of_processor=(one.limit / 2 - SLACK_S) / SLACK)
            passed = tree.run([half], SLOWEST, plain=plain)[0] == SURVIVED
            (self.sound if passed else self.unsound).add(key)
            print("" if passed else f"{test} fails without a change, and is left out\n", end="", flush=True)
        return key in self.sound


def kept(file: Path) -> Iterator[tuple[str, Any]]:
    """Give what former runs have written, the last of a name last."""
    if file.exists():
        yield from (json.loads(line) for line in file.read_text().splitlines())


def keep(file: Path, name: str, value: str) -> None:
    """Add a line, whole, so that an interrupted run loses none."""
    with file.open("a") as out:
        out.write(json.dumps([name, value]) + "\n")


def sample(folders: list[str], count: int, seed: int, but: Iterable[str] = ()) -> dict[str, list[Mutant]]:
    """Return the mutants of each folder: ``count`` in all, without equivalent ones and files left out."""
    no_change = tomllib.loads(EQUIVALENT.read_text())
    found: dict[str, list[Mutant]] = {}
    for folder in folders:
        place = ROOT / "vegrip" / folder
        files = sorted(place.rglob("*.py")) if place.is_dir() else [place]
        files = [file for file in files if not any(file.match(f"vegrip/{pattern}") for pattern in but)]
        every = [one for file in files for one in _of_behaviour(file) if one.name not in no_change]
        found[folder] = sorted(every, key=lambda one: one.rank(seed))
    share = -(-count // len(folders))
    return {folder: every[:share] for folder, every in found.items()}


def _of_behaviour(file: Path) -> Iterator[Mutant]:
    """Give the mutants of a file but for those of what draws."""
    path = str(file.relative_to(ROOT))
    drawn = {
        line
        for name, node in defined(path)
        if DRAWN.search(f"{path}:{name}")
        for line in range(node.lineno, (node.end_lineno or 0) + 1)
    }
    yield from (one for one in mutants(file) if one.line not in drawn)


def main() -> int:
    """Run a round, and print the share that was caught."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100, help="mutants in all, as many of each folder")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2, help="mutants at a time")
    parser.add_argument(
        "--seconds", type=float, default=60.0, help="of the processor for the tests of a mutant"
    )
    parser.add_argument("--trace", type=float, default=60.0, help="seconds for a file of tests at most")
    parser.add_argument(
        "--reach", type=int, default=2, help="how far tests may be: 0 a file's own, 2 those of its folder"
    )
    parser.add_argument(
        "--only", nargs="+", metavar="PATH", default=FOLDERS, help="folders or files below vegrip"
    )
    parser.add_argument("--but", nargs="+", metavar="PATTERN", default=[], help="files to leave out")
    parser.add_argument("--again", action="store_true", help="run those that survived once more")
    options = parser.parse_args()
    (WORK / "records").mkdir(parents=True, exist_ok=True)
    chosen = sample(options.only, options.count, options.seed, options.but)
    results = dict(kept(RESULTS))
    left = [
        one
        for row in zip_longest(*chosen.values())  # a round that is cut short has been in every folder
        for one in row
        if one and (one.name not in results or (options.again and results[one.name] in NOT_CAUGHT))
    ]
    if left:
        round_of = Round(options.jobs, options.seconds, options.reach, options.trace)
        with round_of as the_round, ThreadPoolExecutor(options.jobs) as pool:
            results |= dict(zip((one.name for one in left), pool.map(the_round.run, left), strict=True))
    for said in NOT_CAUGHT:
        print(f"\n{said}:")
        for one in (one for every in chosen.values() for one in every if results[one.name] == said):
            print(f"{one.path}:{one.line}: {one.before}  ->  {one.after}")
    print()
    for folder, every in {**chosen, "all": [one for some in chosen.values() for one in some]}.items():
        of = Counter(results[one.name] for one in every)
        caught = len(every) - sum(of[said] for said in NOT_CAUGHT)
        late = f"{of['timeout']} by time, {of[UNANSWERED]} without an answer"
        print(f"{folder:26}{caught:4} of {len(every):3} caught, {caught / len(every):4.0%}; {late}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
