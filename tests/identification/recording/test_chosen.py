"""Episodes are chosen by number; what is not there is said, and nothing is chosen in silence."""

import numpy as np
import pytest

from vegrip.errors import InputError, UsageError
from vegrip.identification.recording import Recording
from vegrip.identification.recording.data import episodes_text, parse_episodes, select_episodes


@pytest.fixture
def recording() -> Recording:
    t = np.arange(12.0)
    return Recording("press", t, np.repeat([0, 1, 2, 5], 3), {"normal_force": t})


@pytest.mark.parametrize(
    ("text", "numbers"), [("", []), ("3", [3]), ("2,5..7", [2, 5, 6, 7]), (" 7 , 5..6,5", [5, 6, 7])]
)
def test_lists_and_ranges_are_read(text: str, numbers: list[int]) -> None:
    assert parse_episodes(text, "--episodes") == numbers
    assert parse_episodes(episodes_text(numbers), "--episodes") == numbers


@pytest.mark.parametrize("text", ["a", "3..", "..3", "5..2", "1-3", "0..9999999"])
def test_what_is_no_list_is_refused_with_an_example(text: str) -> None:
    with pytest.raises(UsageError, match=r"--hold-back has .*2,5\.\.7"):
        parse_episodes(text, "--hold-back")


def test_the_rows_of_the_chosen_episodes_are_left(recording: Recording) -> None:
    assert set(select_episodes(recording, only="1,5").episode) == {1, 5}
    assert set(select_episodes(recording, without="1,5").episode) == {0, 2}
    assert select_episodes(recording) is recording


def test_an_episode_that_is_not_there_is_said_with_those_that_are(recording: Recording) -> None:
    with pytest.raises(InputError, match=r"has no episode 3; its episodes are 0\.\.2,5"):
        select_episodes(recording, without="1..3")
    with pytest.raises(InputError, match="no episode of press is left"):
        select_episodes(recording, without="0..2,5")
