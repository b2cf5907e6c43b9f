"""Which measured radii count in a fit: those of a firm contact."""

import numpy as np
import pytest

from vegrip.identification.fit.fitting import fit
from vegrip.identification.recording import Recording


@pytest.mark.slow
def test_a_radius_counts_where_the_force_is_five_standard_deviations_or_more(bench) -> None:
    plain = bench()
    radius = np.sqrt(2.0 * 0.01 * np.maximum(plain.columns["displacement"], 0.0))
    columns = {**plain.columns, "contact_radius": radius}
    recording = Recording(
        "seen", plain.t, plain.episode, columns, plain.fingertip, {**plain.sensors, "contact_radius": 2e-5}
    )
    problem = fit(recording).problem
    rows = problem.measured.seen
    counts = np.isfinite(problem.radius_std)
    stds = problem.measured.force[rows] / problem.force_std[rows]
    assert counts.any()
    assert stds[counts].min() > 4.5  # but for the zero of the force
    assert np.any(stds[counts] < 9.0)
