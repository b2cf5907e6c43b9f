"""No recording lacks or changes more than 1 % of what stands in a file without a word of it."""

import re
from pathlib import Path

import pytest

from validation.known_files import ALLOWED, log, table
from vegrip.cli import main
from vegrip.identification.recording import read_recording

SEEDS, OFTEN = 120, 40
SAID = re.compile(
    r"are left out|states were sent|suspicious|nothing( of \w+)? came|has no value|far from all"
)


@pytest.mark.parametrize("make", [table, log])
@pytest.mark.parametrize(
    "first",
    [*range(0, OFTEN, 20), *(pytest.param(one, marks=pytest.mark.long) for one in range(OFTEN, SEEDS, 20))],
)
def test_what_is_lost_or_changed_is_said(make, first, tmp_path: Path, capsys) -> None:
    for seed in range(first, first + 20):
        path, truth = make(seed, tmp_path)
        out = tmp_path / f"r{seed}"
        code = main(["import", str(path), "-o", str(out), *truth.arguments])
        captured = capsys.readouterr()
        told, what = captured.out + captured.err, f"seed {seed}: {'; '.join(truth.said)}"
        assert code in (0, 3), f"{what}: {told}"
        assert "Traceback" not in told, what
        if code == 3:
            assert not list(out.glob("**/recording.csv")), what
            assert len(captured.err.strip().splitlines()) <= 4, f"{what}: {captured.err}"
            continue
        found = read_recording(out / "thumb" if make is log else out, announce=False)
        wrong = truth.share_wrong(found.t, dict(found.columns))
        assert wrong <= ALLOWED or SAID.search(told), f"{what}: {wrong:.1%} wrong\n{told}"
