"""Compiled models come from folders only that nobody else can write: what lies there is run unread."""

import importlib.util
import logging
import os
import py_compile
import threading
from pathlib import Path

import pytest

from vegrip.host import compiled_folder
from vegrip.host.folders import why_not_private, why_not_trusted
from vegrip.model import cache

TEXT = "WHO = 'me'\n"
OTHER = 12345  # a user


@pytest.fixture(autouse=True)
def anew(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    compiled_folder._warn_once.cache_clear()
    compiled_folder.substitute.cache_clear()
    monkeypatch.setenv("VEGRIP_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("VEGRIP_RUNTIME_DIR", str(tmp_path / "run"))
    caplog.set_level(logging.WARNING)


def loaded(tag: str) -> Path:
    """Load a module of its own; return the folder it came from."""
    module = cache.load(f"{TEXT}TAG = {tag!r}\n")
    assert module.WHO == "me"
    assert module.__file__ is not None
    return Path(module.__file__).parent


def poisoned(where: Path, tag: str) -> None:
    """Put compiled code of another's into the place of that of the module ``loaded(tag)`` asks for."""
    text = f"{TEXT}TAG = {tag!r}\n"
    where.mkdir(exist_ok=True)
    cache.load(text)
    name = next(path for path in where.glob("*.py") if path.read_text() == text)
    evil = where / "evil"
    evil.write_text("WHO = 'another'\n")
    compiled = importlib.util.cache_from_source(str(name))
    py_compile.compile(str(evil), compiled, invalidation_mode=py_compile.PycInvalidationMode.UNCHECKED_HASH)
    evil.unlink()


def test_a_folder_that_is_made_is_private_whatever_the_umask(tmp_path: Path) -> None:
    before = os.umask(0)
    try:
        assert loaded("umask") == tmp_path / "cache"
    finally:
        os.umask(before)
    assert (tmp_path / "cache").stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("mode", [0o777, 0o770, 0o1777])
def test_a_folder_that_others_can_write_is_not_used_and_it_is_told(
    mode: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache").chmod(mode)
    assert loaded(f"mode {mode}") == tmp_path / "run" / "models"
    assert "can be written by other users; correct that or set VEGRIP_CACHE" in caplog.text
    assert not list((tmp_path / "cache").iterdir())


def test_what_another_has_compiled_there_is_not_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    poisoned(tmp_path / "cache", "pyc")
    (tmp_path / "cache" / "__pycache__").chmod(0o777)
    monkeypatch.delitem(cache.sys.modules, _name("pyc"))
    assert loaded("pyc") == tmp_path / "run" / "models"


def _name(tag: str) -> str:
    modules = cache.sys.modules.items()
    return next(name for name, module in modules if "TAG" in vars(module) and tag == module.TAG)


@pytest.mark.skipif(os.getuid() != 0, reason="only root can give files away")
@pytest.mark.parametrize("what", ["", "__pycache__"])
def test_a_folder_of_another_user_is_not_used(
    what: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "cache" / "__pycache__").mkdir(parents=True)
    os.chown(tmp_path / "cache" / what, OTHER, OTHER)
    assert loaded(f"owner {what}") == tmp_path / "run" / "models"
    assert "belongs to another user" in caplog.text


def test_a_folder_below_one_that_others_can_write_is_not_used(tmp_path: Path) -> None:
    (tmp_path / "open").mkdir()
    (tmp_path / "open" / "cache").mkdir(mode=0o700)
    assert why_not_trusted(tmp_path / "open" / "cache") == ""
    (tmp_path / "open").chmod(0o777)
    assert "can be written" in why_not_trusted(tmp_path / "open" / "cache")
    (tmp_path / "open").chmod(0o1777)  # as /tmp: nobody can rename what is not his
    assert why_not_trusted(tmp_path / "open" / "cache") == ""


@pytest.mark.skipif(os.getuid() != 0, reason="only root can give files away")
def test_a_link_of_another_user_is_neither_private_nor_trusted(tmp_path: Path) -> None:
    (tmp_path / "home").mkdir(mode=0o700)
    (tmp_path / "link").symlink_to(tmp_path / "home")
    assert why_not_private(tmp_path / "link") == ""
    os.chown(tmp_path / "link", OTHER, OTHER, follow_symlinks=False)
    assert "symbolic link" in why_not_private(tmp_path / "link")
    assert "symbolic link" in why_not_trusted(tmp_path / "link")


def test_a_home_that_cannot_be_written_leaves_one_folder_for_all_starts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("VEGRIP_CACHE", str(tmp_path / "file" / "cache"))
    assert loaded("first") == tmp_path / "run" / "models"
    compiled_folder.substitute.cache_clear()  # the next start
    assert loaded("second") == tmp_path / "run" / "models"


def test_a_module_is_whole_for_every_thread_that_asks_for_it() -> None:
    text = "import threading\n_first = threading.Event()\n_first.wait(0.05)\nWHOLE = True\n"
    begun = threading.Barrier(8)
    seen: list[bool] = []

    def ask() -> None:
        begun.wait()
        seen.append(hasattr(cache.load(text), "WHOLE"))

    threads = [threading.Thread(target=ask) for _ in range(8)]
    for one in threads:
        one.start()
    for one in threads:
        one.join()
    assert seen == [True] * 8
