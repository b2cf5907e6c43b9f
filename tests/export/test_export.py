"""What an exported estimator is told, saves and learns, and the command that writes it."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.export.firmware import run
from vegrip.c99 import host
from vegrip.cli import main
from vegrip.effects import effect
from vegrip.errors import InputError, UsageError
from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.export import Request, write_export
from vegrip.export.estimator import FLAGS, record, simulated
from vegrip.export.measure import deepest, stack_frames
from vegrip.export.saved import learned_model, numbers_of, read_numbers, resumed
from vegrip.model import paper_model, read_model, write_model

needs_compiler = pytest.mark.skipif(host.compiler() is None, reason="no C compiler")


def test_the_sequence_shows_every_flag_both_ways() -> None:
    told = [frame.flags for frame in record(Request(paper_model(8e-3))).frames]
    for bit, name in enumerate(FLAGS):
        assert {flags >> bit & 1 for flags in told} == {0, 1}, name


@needs_compiler
@pytest.mark.parametrize("name", ["adhesion", "relaxation_spectrum"])
def test_an_added_effect_passes_its_self_test_wherever_an_infinite_number_is_saved(
    name: str, host_alone: None, tmp_path: Path
) -> None:
    model = paper_model(8e-3).with_effect(effect(name))
    test = write_export(Request(model, frames=200), tmp_path / "firmware").measured.host_run
    assert test is not None
    assert test.passed
    assert test.equal == test.numbers


CLOCKS = """
#include "lh_estimator.h"

int main(void)
{
    static const int64_t times[] = {
        0, INT64_MAX, INT64_MIN, 1, INT64_MIN + 1, -1, INT64_MAX - 1, INT64_MAX / 2, INT64_MIN / 2, 1000000,
    };
    static lh_estimator e;
    const int32_t count = (int32_t)(sizeof times / sizeof times[0]);
    for (int32_t i = 0; i < count * count; i++) {
        lh_sample s = lh_nothing_measured();
        s.normal_force = 1.0;
        s.displacement = 4e-4;
        lh_init(&e);
        for (int32_t j = 0; j < 40; j++) { /* refused, until the clock counts as started anew */
            s.stamp_ns = j < 2 ? times[i / count] : times[i % count];
            (void)lh_update(&e, &s);
            if (!(lh_age(&e) >= 0.0)) {
                return 1;
            }
        }
    }
    return 0;
}
"""


@pytest.mark.long
@needs_compiler
def test_no_clock_overflows_whatever_it_says(sanitized: Callable[..., None], tmp_path: Path) -> None:
    (tmp_path / "clocks.c").write_text(CLOCKS)
    sanitized("estimator", tmp_path / "clocks.c")


def test_saved_numbers_go_on_where_they_were() -> None:
    request = Request(paper_model(8e-3), frames=120)
    states = list(simulated(request))
    first, second = (ContactEstimator(request.model, request.noise) for _ in range(2))
    for state in states[:80]:
        first.update(state)
    resumed(second, numbers_of(first))
    assert np.array_equal(numbers_of(second), numbers_of(first))
    before = first.value("mu")
    second.update(states[80])
    assert second.in_contact == first.in_contact
    assert second.value("mu").value == pytest.approx(before.value, rel=0.05)


def test_what_was_learned_goes_back_into_a_model(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    request = Request(paper_model(8e-3))
    estimator = ContactEstimator(request.model, request.noise)
    for state in simulated(request):
        estimator.update(state)
    raw, words = tmp_path / "finger.bin", tmp_path / "finger.txt"
    raw.write_bytes(numbers_of(estimator).astype("<f8").tobytes())
    words.write_text("\n".join(float(one).hex() for one in numbers_of(estimator)))
    for path in (raw, words):
        found = learned_model(request.model, read_numbers(path))
        assert found.values["K"].value == estimator.value("K").value
        assert found.values["mu"].std == pytest.approx(estimator.value("mu").std)
    write_model(request.model, tmp_path / "model.toml")
    command = [
        "export",
        "learned",
        str(tmp_path / "model.toml"),
        str(raw),
        "-o",
        str(tmp_path / "learned.toml"),
    ]
    assert main([*command, "--json"]) == 0
    K = read_model(tmp_path / "learned.toml").values["K"]
    assert K.value == estimator.value("K").value
    told = json.loads(capsys.readouterr().out)["parameters"]["K"]
    assert told == {"value": K.value, "std": pytest.approx(K.value * K.std)}


@pytest.mark.parametrize("damage", ["other", "short", "long", "nan", "bit", "words"])
def test_other_numbers_are_refused(damage: str, tmp_path: Path) -> None:
    estimator = ContactEstimator(paper_model(8e-3), SensorNoise())
    numbers = numbers_of(estimator)
    path = tmp_path / "finger.bin"
    if damage == "other":
        numbers[0] += 1.0
    elif damage == "short":
        numbers = numbers[:-1]
    elif damage == "long":
        numbers = np.append(numbers, 0.0)
    elif damage == "bit":
        numbers.view(np.uint64)[5] ^= 1
    elif damage == "nan":
        numbers[3] = np.nan
    path.write_bytes(b"no numbers" if damage == "words" else numbers.tobytes())
    with pytest.raises(InputError):
        resumed(estimator, read_numbers(path))


@pytest.mark.parametrize("prefix", ["", "Vg", "9x", "a-b", "int", "x" * 40, "a__b"])
def test_a_prefix_that_c_does_not_take_is_refused(prefix: str) -> None:
    with pytest.raises(UsageError, match="--prefix"):
        Request(paper_model(8e-3), prefix=prefix)


@pytest.mark.long
@needs_compiler
@pytest.mark.usefixtures("host_alone")
def test_the_command_writes_to_a_folder_named_from_here_and_does_not_replace_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_model(paper_model(8e-3), Path("m.toml"))
    command = ["export", "c", "m.toml", "-o", "fw", "--json"]
    assert main(command) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["frames"] == 500
    assert told["largest_difference"] == 0.0
    assert told["text_bytes"] > 10_000
    assert told["stack_bytes"] > 100
    assert all(Path(path).is_file() for path in told["files"])
    assert main(command) == 3
    assert "--force" in capsys.readouterr().err
    built = run("make", "-C", tmp_path / "fw", where=tmp_path)
    assert "PASS 500 frames" in built.stdout


@pytest.mark.parametrize("wrong", [["--entry", "hand"], ["--precision", "half"], ["--prefix", "1"]])
def test_what_cannot_be_exported_is_told(wrong: list[str], tmp_path: Path) -> None:
    write_model(paper_model(8e-3), tmp_path / "m.toml")
    assert main(["export", "c", str(tmp_path / "m.toml"), "-o", str(tmp_path / "fw"), *wrong]) == 2


def test_stack_is_the_deepest_way_down() -> None:
    usage = (
        "a.c:1:2:top\t16\tstatic\na.c:9:1:left.constprop.0\t48\tstatic\na.c:12:1:right\t32\tdynamic,bounded\n"
    )
    frames = stack_frames(usage)
    assert frames == {"top": 16, "left": 48, "right": 32}
    calls = {"top": frozenset({"left", "right"}), "right": frozenset({"left"})}
    assert deepest("top", calls, frames) == 16 + 32 + 48
