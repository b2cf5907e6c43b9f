"""VEGRIP_KERNEL=c runs the same kernels by C; without a compiler, or if it fails, numba does, told once."""

import logging
import math
from pathlib import Path

import numpy as np
import pytest

from vegrip.c99 import UntranslatableError, host
from vegrip.effects import Effect, hook
from vegrip.errors import UsageError
from vegrip.estimator import ContactEstimator, SensorNoise, compiled
from vegrip.estimator.layout import layout_of
from vegrip.estimator.origins import Origins
from vegrip.export import Request
from vegrip.export.estimator import simulated
from vegrip.host import compiled_folder
from vegrip.model import cache, native, paper_model
from vegrip.model.native import ModuleC

needs_compiler = pytest.mark.skipif(host.compiler() is None, reason="no C compiler")


@pytest.fixture(autouse=True)
def untold() -> None:
    native.log_once.cache_clear()


@needs_compiler
@pytest.mark.numba
def test_estimates_are_equal_to_the_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    request = Request(paper_model(8e-3), frames=200)
    monkeypatch.setenv("VEGRIP_KERNEL", "numba")
    by_numba = ContactEstimator(request.model, request.noise)
    monkeypatch.setenv("VEGRIP_KERNEL", "c")
    by_c = ContactEstimator(request.model, request.noise)
    assert isinstance(by_c._module, ModuleC)
    for state in simulated(request):
        assert repr(by_numba.update(state)) == repr(by_c.update(state))
        assert repr(by_numba.slip_margin()) == repr(by_c.slip_margin())
        assert repr(by_numba.least_force(0.2)) == repr(by_c.least_force(0.2))
    assert np.array_equal(by_numba.memory, by_c.memory, equal_nan=True)


def told(caplog: pytest.LogCaptureFixture) -> list[str]:
    return [one.message for one in caplog.records if "VEGRIP_KERNEL" in one.message]


@pytest.mark.numba
def test_without_a_compiler_numba_runs_and_it_is_told_once(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("VEGRIP_KERNEL", "c")
    monkeypatch.setattr(host, "compiler", lambda: None)
    monkeypatch.setattr(native, "libraries", {})
    with caplog.at_level(logging.WARNING):
        estimators = [ContactEstimator(paper_model(8e-3), SensorNoise()) for _ in range(2)]
    assert not any(isinstance(one._module, ModuleC) for one in estimators)
    assert told(caplog) == [
        "VEGRIP_KERNEL=c is not possible: there is no C compiler (cc, gcc or clang); numba is used, which "
        "compiles for half a minute"
    ]


@needs_compiler
def test_where_there_is_a_compiler_it_is_used_without_being_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("VEGRIP_KERNEL", raising=False)
    assert isinstance(ContactEstimator(paper_model(8e-3), SensorNoise())._module, ModuleC)


@pytest.mark.numba
def test_without_one_and_without_being_asked_numba_runs_and_nothing_is_told(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.delenv("VEGRIP_KERNEL", raising=False)
    monkeypatch.setattr(host, "compiler", lambda: None)
    with caplog.at_level(logging.WARNING):
        estimator = ContactEstimator(paper_model(8e-3), SensorNoise())
    assert not isinstance(estimator._module, ModuleC)
    assert told(caplog) == []


def test_a_compiler_that_fails_leaves_numba(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, tmp_path: Path
) -> None:
    broken = tmp_path / "cc"
    broken.write_text("#!/bin/sh\necho 'internal error: out of ideas' >&2\nexit 4\n")
    broken.chmod(0o755)
    monkeypatch.setenv("VEGRIP_KERNEL", "c")
    monkeypatch.setenv("CC", str(broken))
    monkeypatch.setattr(native, "libraries", {})
    by_numba = []
    monkeypatch.setattr(cache, "load", lambda text: by_numba.append(cache.load_plain(text)) or by_numba[-1])
    with caplog.at_level(logging.WARNING):
        estimator = ContactEstimator(paper_model(8e-3), SensorNoise())
    assert [estimator._module] == by_numba
    assert len(told(caplog)) == 1
    assert "out of ideas" in told(caplog)[0]


def falling(force: float) -> float:
    """Use what C has not."""
    return force - 0.0 * math.gamma(1.0) * float("0")


def test_an_effect_that_c_has_no_words_for_is_told_by_file_and_line() -> None:
    model = paper_model(8e-3).with_effect(Effect("falling", "", (), (hook(falling, stage="force"),)))
    text = compiled.text_of(model, layout_of(model))
    with pytest.raises(UntranslatableError, match=r"test_kernel_mode\.py:\d+: .*cannot be translated to C"):
        native.library_of(text, compiled.KINDS, Origins(model.effects).place)


def test_a_mode_that_does_not_exist_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VEGRIP_KERNEL", "fortran")
    with pytest.raises(UsageError, match="numba, c, c-float, python"):
        ContactEstimator(paper_model(8e-3), SensorNoise())


@needs_compiler
def test_a_second_start_takes_the_library_from_the_cache(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("VEGRIP_KERNEL", "c")
    monkeypatch.setattr(compiled_folder, "folder", lambda: tmp_path)
    monkeypatch.setattr(native, "libraries", {})
    ContactEstimator(paper_model(8e-3), SensorNoise())
    made = list(tmp_path.glob("vegrip_c_*.so"))
    assert len(made) == 1
    native.libraries.clear()
    monkeypatch.setattr(host, "build", None)  # would fail
    ContactEstimator(paper_model(8e-3), SensorNoise())


@needs_compiler
def test_a_library_of_another_user_is_not_loaded(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    made = compiled_folder.library("vegrip_c_test", lambda path: path.write_bytes(b"x") and None)
    made.unlink()
    monkeypatch.setattr(compiled_folder, "folder", lambda: tmp_path)
    foreign = tmp_path / "vegrip_c_test.so"
    foreign.symlink_to("/nowhere")
    place = compiled_folder.library("vegrip_c_test", lambda path: path.write_bytes(b"x") and None)
    assert place.parent != tmp_path
    place.unlink()
