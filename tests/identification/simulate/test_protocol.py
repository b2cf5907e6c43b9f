"""Protocol files: what is written comes back, and what cannot be is refused in one sentence."""

from pathlib import Path

import numpy as np
import pytest

from tests.identification.reach import greatest_depth, greatest_speed
from vegrip.errors import ConfigError
from vegrip.identification.simulate import Protocol, Segment, read_protocol, write_protocol
from vegrip.identification.simulate.protocol import standard
from vegrip.identification.simulate.run import timeline
from vegrip.model import paper_model

MODEL = paper_model(8e-3)


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "p.toml"
    path.write_text(text)
    return path


def test_what_is_written_comes_back(tmp_path) -> None:
    protocol = standard(MODEL)
    write_protocol(protocol, tmp_path / "p.toml", "a comment\nof two lines")
    again = read_protocol(tmp_path / "p.toml")
    assert again.episodes == protocol.episodes
    assert (again.name, again.pause) == (protocol.name, protocol.pause)


def test_a_speed_is_a_duration(tmp_path) -> None:
    text = "[[episode]]\nsegments = [{duration=1, depth=-1e-4}, {speed=2e-3, depth=1e-3}, {duration=2}]"
    (segments,) = read_protocol(written(tmp_path, text)).episodes
    assert segments[1] == Segment(pytest.approx(0.55), depth=1e-3)
    assert segments[2] == Segment(2.0)


@pytest.mark.parametrize(
    ("segments", "said"),
    [
        ("{duration=1, depth=1e-3, force=1}", "cannot both be imposed"),
        ("{depth=1e-3}", "either its duration"),
        ("{duration=1, speed=1e-3, depth=1e-3}", "either its duration"),
        ("{speed=1e-3}", "a depth to reach"),
        ("{speed=1e-3, depth=0.0}", "this depth already"),
        ("{duration=1, amplitude=1e-4}", "amplitude and frequency"),
        ("{duration=-1, depth=1e-3}", "must lie in"),
        ("{duration=1, depht=1e-3}", "unknown key 'depht'"),
        ("{duration=1, depth='deep'}", "must be a float in m"),
        ("3", "list of tables"),
        ("{duration=1, force=1}, {speed=1e-3, depth=0}", "one to start from"),
        ("", "needs an"),
    ],
)
def test_a_segment_that_cannot_be_is_refused_by_name(tmp_path, segments, said) -> None:
    with pytest.raises(ConfigError, match=said):
        read_protocol(written(tmp_path, f"[[episode]]\nsegments = [{segments}]"))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("name = 'x'", "no \\[\\[episode\\]\\]"),
        ("pause = -1\n[[episode]]\nsegments = [{duration=1}]", "'pause' is -1"),
        ("pauses = 1", "unknown key 'pauses'"),
        ("[[episode]]\nsegment = []", "unknown key 'segment'"),
        ("episode = 3", "list of tables"),
        ("[[episode]\n", "not valid TOML"),
    ],
)
def test_a_file_that_cannot_be_is_refused(tmp_path, text, said) -> None:
    with pytest.raises(ConfigError, match=said):
        read_protocol(written(tmp_path, text))
    with pytest.raises(ConfigError, match="no such file"):
        read_protocol(tmp_path / "absent.toml")


def test_the_timeline_has_the_times_and_levels_of_the_protocol() -> None:
    wave = Segment(1.0, amplitude=1e-4, frequency=2.0)
    episode = (Segment(0.5, depth=1e-3), Segment(0.25), wave, Segment(0.5, depth=0.0))
    protocol = Protocol("p", (episode, episode), pause=7.0)
    line = timeline(protocol, 1e-3)
    depth, force = line.imposed(np.zeros(line.t.size), np.zeros(line.t.size))
    assert np.all(np.isnan(force))
    assert line.t[2250] - line.t[2249] == pytest.approx(7.0 + 1e-3)
    assert protocol.duration == pytest.approx(2 * 2.25 + 7.0)
    assert depth[[249, 499, 749, 2249]] == pytest.approx([5e-4, 1e-3, 1e-3, 0.0])
    assert depth[750:1750].max() == pytest.approx(1.1e-3, rel=1e-4)
    assert depth[2250:] == pytest.approx(depth[:2250])


def test_extremes_count_sines() -> None:
    rising, wave = Segment(0.5, depth=1e-3), Segment(1.0, amplitude=1e-4, frequency=5.0)
    protocol = Protocol("p", ((rising, wave, Segment(0.1, force=2.0)),))
    assert greatest_depth(protocol) == pytest.approx(1.1e-3)
    assert greatest_speed(protocol) == pytest.approx(2.0 * np.pi * 5.0 * 1e-4)


def test_repetition_and_joining_keep_every_segment() -> None:
    episode = (Segment(0.5, depth=1e-3), Segment(0.5, depth=0.0))
    protocol = Protocol("p", (episode,), pause=3.0).repeated(3)
    assert protocol.duration == pytest.approx(3 * 1.0 + 2 * 3.0)
    assert sum(s.duration for s in protocol.at_rest_between()) == pytest.approx(protocol.duration)
