"""The demonstration of a bench as a user runs it: pads, or a wrist alone, and a gripper."""

import json
import subprocess
import sys
from types import SimpleNamespace

import pytest

from vegrip.cli import main
from vegrip.demo import command
from vegrip.demo.bench import open_bench_product
from vegrip.errors import InputError

SHORT_S = "8"


@pytest.mark.long
@pytest.mark.parametrize("bench", ["papillarray+robotiq", "wrist=bota+robotiq"])
def test_what_a_bench_holds_does_not_slide(tmp_path, bench):
    words = [
        "demo",
        "--bench",
        bench,
        "--headless",
        "--json",
        "--duration",
        SHORT_S,
        "-o",
        str(tmp_path / "run"),
    ]
    run = subprocess.run(
        [sys.executable, "-m", "vegrip", *words], capture_output=True, text=True, check=False, timeout=300
    )
    assert run.returncode == 0, run.stderr
    said = json.loads(run.stdout)["bench"]
    assert said["largest_slide"] < 1e-3
    assert said["best_by_steps"] >= 20.0  # the least that this gripper can
    assert said["force_over_best"] < 2.5  # the figure is held in simulated time, see test_bench_grip.py


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("papillarray", "name a sensor and a drive"),
        ("papillaray+robotiq", "there is no sensor 'papillaray'"),
        ("xela+robotiq", "pads of xela-uskin have values to be measured first"),
        ("papillarray+bota", "there is no drive 'bota'"),
        ("wrist=robotiq-tsf85+weiss", "there is no sensor 'robotiq-tsf85'"),  # it feels no load
    ],
)
def test_a_bench_that_cannot_be_is_refused_in_one_sentence(tmp_path, text, said):
    with pytest.raises(InputError) as refused:
        open_bench_product(text, tmp_path)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_the_drive_of_a_word_is_the_shortest_name_and_its_launch_file_is_left_to_be_read(tmp_path):
    product = open_bench_product("papillarray+robotiq", tmp_path)
    assert product.name == "contactile-papillarray + robotiq-2f85"
    assert product.fingers == ("left", "right")
    assert (tmp_path / "bench.toml").is_file()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--bench", "papillarray+robotiq", "--grasp", "hand"], "leave --grasp out"),
        (["--as", "contactile-papillarray", "--grasp", "pinch"], "leave --grasp out"),
        (["--bench", "papillarray+robotiq", "--plot"], "leave --plot out"),
        (["--web", "--headless"], "there is no page"),
        (["--web", "--json"], "there is no page"),
    ],
)
def test_an_option_that_could_do_nothing_is_refused_in_one_sentence(tmp_path, capsys, options, said):
    assert main(["demo", *options, "-o", str(tmp_path / "run")]) == 2
    told = capsys.readouterr().err
    assert said in told
    assert told.count("\n") == 1
    assert not (tmp_path / "run").exists()


def test_a_run_in_which_no_state_came_held_nothing_and_ends_so(tmp_path, capsys, monkeypatch):
    deaf = SimpleNamespace(node=SimpleNamespace(states=0), interrupted=False)
    monkeypatch.setattr(command, "_run_shown", lambda *_, **__: deaf)
    assert (
        main(["demo", "--bench", "papillarray+robotiq", "--headless", "--json", "-o", str(tmp_path / "run")])
        == 4
    )
    told = capsys.readouterr()
    assert "no state came, so nothing was gripped" in told.err
    assert "held" not in told.out + told.err


@pytest.mark.parametrize("bench", ["papillarray+dynamixel", "wrist=ati+dynamixel", "wrist=onrobot+hand-e-ur"])
def test_what_is_to_be_measured_is_taken_as_of_the_virtual_device(tmp_path, bench):
    product = open_bench_product(bench, tmp_path)
    assert product.drive.rate > 0.0
    assert product.fingers == ("left", "right")
    assert "?" not in (tmp_path / "bench.toml").read_text()
