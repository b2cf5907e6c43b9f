"""The layout shows fields that are served, and says only what Foxglove's panels know."""

import json
from pathlib import Path

import pytest

from vegrip.bridges.foxglove_layout import layout
from vegrip.bridges.ros2_types import TYPES
from vegrip.cli import main
from vegrip.transport.codec.schema import Topics

HANDS = {"": ("thumb",), "left": ("thumb", "index")}


def paths(shown):
    return [path for panel in shown["configById"].values() for path in panel.get("paths", ())]


def test_every_path_is_a_field_of_a_topic_that_is_served() -> None:
    for path in paths(layout(HANDS)):
        topic, _, field = path["value"].rpartition(".")
        route = Topics("left" if topic.startswith("/left") else "").incoming(topic)
        assert field in TYPES[route.schema.cls]


def test_margin_bound_forces_friction_and_health_of_every_finger_are_shown() -> None:
    shown = {path["value"] for path in paths(layout(HANDS))}
    for hand in ("/hand/thumb", "/left/hand/thumb", "/left/hand/index"):
        wanted = ("slip_margin.margin", "slip_margin.lower_bound", "state.normal_force", "model_health.nis")
        assert {f"{hand}/{one}" for one in (*wanted, "contact.friction_coefficient")} <= shown


def test_every_panel_is_placed_once() -> None:
    def placed(tree):
        return [tree] if isinstance(tree, str) else placed(tree["first"]) + placed(tree["second"])

    shown = layout(HANDS)
    assert sorted(placed(shown["layout"])) == sorted(shown["configById"])


def test_options_of_plots_are_those_of_the_maker() -> None:
    panels = pytest.importorskip("foxglove.layouts")
    plot, series = panels.PlotConfig()._to_dict(), panels.PlotSeries(value="")._to_dict()
    for name, panel in layout(HANDS)["configById"].items():
        if name.startswith("Plot!"):
            assert panel.keys() - {"foxglovePanelTitle"} <= plot.keys()
            assert all(path.keys() <= series.keys() for path in panel["paths"])


def test_the_command_writes_the_hand_of_the_demonstration_where_none_runs(
    runtime, tmp_path: Path, capsys
) -> None:
    assert main(["bridge", "foxglove", "--layout", str(tmp_path / "hand.json")]) == 0
    assert "5 fingers" in capsys.readouterr().out
    assert len(json.loads((tmp_path / "hand.json").read_text())["configById"]) == 6
    assert main(["bridge", "foxglove", "--layout", str(tmp_path)]) == 3
