"""Figures as files."""

import builtins

import pytest

from vegrip.errors import InputError, UsageError
from vegrip.plotting import new_figure, save_figure

pytest.importorskip("matplotlib", reason="figures need the extra 'plot'")


def figure_of_a_line():
    figure, (upper, lower) = new_figure(2, size=(3.0, 2.0), share_x=True)
    upper.plot([0, 1], [0, 1])
    lower.plot([0, 1], [1, 0])
    return figure


@pytest.mark.parametrize("ending", ["png", "svg"])
def test_the_same_figure_gives_the_same_file_in_a_folder_that_is_made(tmp_path, ending):
    files = [tmp_path / "new" / f"{i}.{ending}" for i in range(2)]
    for file in files:
        save_figure(figure_of_a_line(), file)
    first, second = (file.read_bytes() for file in files)
    assert first.partition(b"<dc:date>")[0] == second.partition(b"<dc:date>")[0]


def test_one_panel_is_a_list_of_one():
    _, panels = new_figure(size=(3.0, 2.0))
    assert len(panels) == 1


@pytest.mark.parametrize("name", ["file/picture.png", "picture.unknown"])
def test_a_picture_that_cannot_be_written_is_refused_in_one_sentence(tmp_path, name):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="the picture cannot be written"):
        save_figure(figure_of_a_line(), tmp_path / name)


def test_without_matplotlib_the_sentence_names_the_extra(monkeypatch):
    found = builtins.__import__

    def lacking(name, *rest):
        if name.startswith("matplotlib"):
            raise ImportError(name)
        return found(name, *rest)

    monkeypatch.setattr(builtins, "__import__", lacking)
    with pytest.raises(UsageError, match=r"vegrip\[plot\]"):
        new_figure(size=(3.0, 2.0))
