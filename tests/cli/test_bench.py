"""``vegrip bench`` finds the benchmarks, measures both sides and gives their ratio."""

import json
from pathlib import Path

import pytest

from benchmarks import _run
from vegrip.cli import main


def test_a_ratio_is_theirs_over_ours(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "creep_inverse", "--json"]) == 0
    results = json.loads(capsys.readouterr().out)
    row = results["creep_inverse_vs_root_solve"]
    assert row["ours_us"] > 0
    assert row["ratio"] == pytest.approx(row["theirs_us"] / row["ours_us"])


def test_an_unknown_benchmark_is_named_with_the_known_ones(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "no_such"]) == 2
    complaint = capsys.readouterr().err
    assert "no_such" in complaint
    assert "recursion" in complaint
    assert "_timing" not in complaint


def test_results_are_a_table_for_people(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "creep_inverse"]) == 0
    assert "creep_inverse_vs_root_solve" in capsys.readouterr().out


def test_every_benchmark_that_is_listed_has_something_to_run() -> None:
    from importlib import import_module

    assert len(_run.known()) >= 10
    without = [name for name, module in _run.known().items() if not hasattr(import_module(module), "run")]
    assert without == []


@pytest.mark.long
@pytest.mark.parametrize("name", _run.known())
def test_every_benchmark_runs_in_its_smallest_size(
    name: str, tmp_path: Path, runtime: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["bench", name, "--quick", "--json"]) == 0
    results = json.loads(capsys.readouterr().out)
    assert results
    for row in results.values():
        if "cores" in row:
            assert row["cores"] > 0.0
            continue
        assert row["ratio"] == pytest.approx(row["theirs_us"] / row["ours_us"])


def test_a_quick_run_leaves_the_sizes_as_they_were() -> None:
    from benchmarks import _timing, recursion

    assert main(["bench", "recursion", "--quick"]) == 0
    assert len(recursion.HISTORIES) == 3
    assert _timing.BATCHES == 5


def test_bytes_are_not_told_as_microseconds() -> None:
    row = {"ours_us": 9e3, "theirs_us": 1.44e6, "ratio": 160.0, "ours_bytes": 9e3}
    assert _run.line("memory_per_finger", row).endswith("160 bytes")


def test_a_benchmark_that_fails_costs_no_other_its_result(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import benchmarks.recursion as failing

    monkeypatch.setattr(failing, "run", lambda: 1 / 0)
    assert main(["bench", "recursion", "creep_inverse"]) == 4
    told = capsys.readouterr()
    assert "creep_inverse_vs_root_solve" in told.out
    assert "[us]" in told.out
    assert "recursion: failed (ZeroDivisionError" in told.err
