"""A jump of a sensor's zero is found where and as large as it was made, and only there."""

from dataclasses import replace

import numpy as np
import pytest

from vegrip.identification.diagnosis.candidate_fit import evaluate_candidate, held_out_groups
from vegrip.identification.diagnosis.zero_jump import find_jump
from vegrip.identification.fit import fit, noise_of


def found(sample, plain):
    start = fit(sample, noise=noise_of(plain))  # else one jump of the force may pass for slow noise
    return find_jump(evaluate_candidate(start.problem, start.optimum, held_out_groups(start.problem)), 20.0)


def test_nothing_jumps_where_noise_is_left(tip) -> None:
    assert found(tip(13, pull=0.0), tip(13, pull=0.0)) is None


@pytest.mark.parametrize(("channel", "size"), [("normal_force", -0.06), ("displacement", 3e-5)])
def test_a_jump_is_found_with_its_row_and_size_and_taken_off(tip, channel: str, size: float) -> None:
    sample = tip(13, pull=0.0)
    depth = sample.columns["displacement"]
    pressed = np.flatnonzero(depth > 0.5 * depth.max())  # in the air a displacement says nothing of its zero
    row = int(pressed[pressed.size // 2])
    later = np.arange(len(sample)) >= row
    jumped = replace(sample, columns=sample.columns | {channel: sample.columns[channel] + size * later})
    jump = found(jumped, sample)
    assert jump is not None
    assert jump.channel == channel
    assert abs(jump.row - row) <= 2
    assert jump.size == pytest.approx(size, rel=0.1)
    left = jump.removed(jumped).columns[channel] - sample.columns[channel]
    assert np.abs(np.delete(left, np.arange(row - 2, row + 2))).max() < 0.1 * abs(size)
