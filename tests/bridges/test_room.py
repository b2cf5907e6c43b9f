"""The room of bridges is an extra: nothing else needs it."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

from vegrip.cli import main

ROOT = Path(__file__).parents[2]
_spec = importlib.util.spec_from_file_location("folders", ROOT / "docs" / "folders.py")
folders = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(folders)


@pytest.mark.long
def test_nothing_but_the_command_line_imports_a_bridge() -> None:
    users = {name for name, targets in folders.arrows().items() if "bridges" in targets}
    assert {name for name in users if name.split("/")[0] not in folders.NOT_SHIPPED} == {"cli"}


def test_a_bridge_is_imported_by_its_own_command_alone() -> None:
    code = "import sys, vegrip.cli, vegrip.cli.topic, vegrip.cli.bridge; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert not [
        name
        for name in loaded.split()
        if name.startswith(("vegrip.bridges", "websockets", "mujoco", "cyclonedds", "pyarrow"))
    ]


@pytest.mark.parametrize(
    ("words", "extra"),
    [
        ("bridge foxglove", "foxglove"),
        ("bridge ros2", "ros2"),
        ("controllers --plant mujoco", "mujoco"),
    ],
)
def test_without_the_extra_a_sentence_says_what_to_install(
    monkeypatch, capsys, words: str, extra: str
) -> None:
    monkeypatch.setattr("vegrip.bridges.find_spec", lambda _: None)
    assert main(words.split()) == 2
    assert f"pip install 'vegrip[{extra}]'" in capsys.readouterr().err
