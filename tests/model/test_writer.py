"""Texts that are joined to one generated module keep their names apart."""

from pathlib import Path

import pytest

from vegrip.errors import ModelError
from vegrip.estimator import compiled
from vegrip.estimator.layout import layout_of
from vegrip.model import paper_model

ONE = '"""Of the first kernel."""\n\nFAR = 25.0\n\ndef reach(m):\n    return FAR\n'


@pytest.mark.parametrize(
    ("other", "name"),
    [
        ('"""Of the second."""\n\nFAR = 9.0\n', "FAR"),
        ('"""Of the second."""\n\nNEAR, FAR = 1.0, 9.0\n', "FAR"),
        ('"""Of the second."""\n\nFAR: float = 9.0\n', "FAR"),
        ('"""Of the second."""\n\ndef reach(m):\n    return 0.0\n', "reach"),
        ('"""Of the second."""\n\ndef advance(m):\n    return 0.0\n', "advance"),
    ],
)
def test_two_kernels_that_define_the_same_name_are_refused(other: str, name: str) -> None:
    with pytest.raises(ModelError, match=rf"^{name} is defined in two texts .*'Of the second\.'; rename one"):
        paper_model(8e-3).source([ONE, other])


def test_a_declaration_without_a_value_and_a_name_within_a_function_clash_with_nothing() -> None:
    other = "FAR: float\n\ndef other(m):\n    FAR = 1.0\n    return FAR\n"
    assert "def other(m):" in paper_model(8e-3).source([ONE, other])


def test_a_kernel_file_that_takes_a_name_of_another_is_refused(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    model = paper_model(8e-3)
    real = Path.read_text

    def with_a_clash(path: Path, **how: str) -> str:
        text = real(path, **how)
        return text + "\nGATE = 1.0\n" if path.name == f"{compiled.KERNELS[0]}.py" else text

    monkeypatch.setattr(Path, "read_text", with_a_clash)
    compiled._text.cache_clear()
    with pytest.raises(ModelError, match="GATE is defined in two texts"):
        compiled.text_of(model, layout_of(model))
    compiled._text.cache_clear()
