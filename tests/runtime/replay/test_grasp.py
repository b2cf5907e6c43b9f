"""The node that a recording is played to knows what the recording knows, unless it is told otherwise."""

import math
from pathlib import Path

import numpy as np
import pytest

from vegrip.errors import ConfigError
from vegrip.identification.recording import Fingertip, Recording
from vegrip.runtime.replay.run import read_settings, with_recording


def press(radius: float) -> Recording:
    sensors = {"normal_force": 0.02, "slip_speed": 1e-3}
    columns = {"normal_force": np.zeros(1)}
    return Recording("p", np.zeros(1), np.zeros(1, int), columns, Fingertip(radius), sensors)


def test_radius_and_noise_come_from_the_recording() -> None:
    settings = with_recording({}, {"index": press(0.008)})
    assert settings == {"noise": {"normal_force": 0.02}, "tips": {"index": {"radius": 0.008}}}


@pytest.mark.parametrize(
    "said",
    [
        {"tip": {"radius": 0.01}},
        {"tip": {"model": "m.toml"}},
        {"tips": {"index": {"radius": 0.01}}},
        {"tips": {"index": {"model": "m.toml"}}},
    ],
)
def test_a_radius_in_the_settings_stands(said: dict[str, object]) -> None:
    settings = with_recording(said, {"index": press(0.008)})
    assert {key: settings[key] for key in said} == said


def test_noise_in_the_settings_stands() -> None:
    settings = with_recording({"noise": {"normal_force": 1.0}}, {"index": press(math.nan)})
    assert settings == {"noise": {"normal_force": 1.0}, "tips": {}}


def test_a_model_file_is_looked_for_beside_the_settings(tmp_path: Path) -> None:
    (tmp_path / "node.toml").write_text('[tip]\nmodel = "model.toml"\n')
    assert read_settings(tmp_path / "node.toml") == {"tip": {"model": str(tmp_path / "model.toml")}}
    assert read_settings(None) == {}
    with pytest.raises(ConfigError, match="no such file"):
        read_settings(tmp_path / "absent.toml")
