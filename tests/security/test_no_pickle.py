"""Nothing here turns bytes from outside into code."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = ("vegrip", "nodes", "benchmarks", "validation")
FILES = sorted(file for folder in FOLDERS for file in (ROOT / folder).rglob("*.py"))
MODULES = {"pickle", "cPickle", "dill", "cloudpickle", "joblib", "marshal", "shelve", "jsonpickle", "yaml"}
CALLS = {"eval", "exec", "__import__", "recv_pyobj", "send_pyobj", "load_pickle", "read_pickle"}
EXCEPTIONS = {
    ("composer.py", "exec"),  # a user's own effect, as importing it would run it
    ("program.py", "exec"),  # constants of the program's own kernels, to be written as C
    ("makers.py", "exec"),  # a maker's own package, which its user names on the command line
    ("compiled.py", "exec"),  # what is generated from a map whose every entry was checked
    ("signals.py", "exec"),  # what is generated from the database of the package
    ("file.py", "exec"),  # an effect whose every statement was checked
}


def name_of(call):
    return call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")


def dangers(tree):
    """Yield what could run code that came as data."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name.partition(".")[0] in MODULES)
        elif isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] in MODULES:
            yield str(node.module)
        elif isinstance(node, ast.Call):
            if name_of(node) in CALLS:
                yield name_of(node)
            yield from (k.arg for k in node.keywords if k.arg in ("allow_pickle", "shell"))


def test_no_module_reads_pickles_or_runs_text():
    found = {(f.name, danger) for f in FILES for danger in dangers(ast.parse(f.read_text(encoding="utf-8")))}
    assert found == EXCEPTIONS


SEEN = (
    "import pickle",
    "from pickle import loads",
    "eval(x)",
    "s.recv_pyobj()",
    "np.load(f, allow_pickle=True)",
)


@pytest.mark.parametrize("text", SEEN)
def test_the_search_is_not_blind(text):
    assert list(dangers(ast.parse(text)))


def test_the_search_sees_the_whole_of_vegrip():
    names = {file.name for file in FILES}
    assert {"msgpack_codec.py", "grasp_force.py", "hub.py", "key_files.py"} <= names
    assert len(FILES) > 200
