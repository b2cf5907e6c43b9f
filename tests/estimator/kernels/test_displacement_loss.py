"""What a lost displacement does to the memory, and that it does so once."""

import numpy as np


def test_with_the_displacement_goes_what_parameters_have_in_common_with_the_rest(kernels, m, P) -> None:
    learned = np.arange(kernels.LEARNED_FROM, kernels.M)
    others = np.setdiff1d(np.arange(kernels.N), learned)
    assert P[np.ix_(learned, others)].any()
    assert P[kernels.DELTA, kernels.OFFSET] != 0.0
    m[kernels.MODE_BLIND] = m[kernels.MOTION_RESTLESS] = 0.0
    kept = P.copy()
    kernels.follow_displacement_loss(m, False)
    assert np.array_equal(P, kept)
    assert m[kernels.MOTION_RESTLESS] == 0.0

    kernels.follow_displacement_loss(m, True)
    assert m[kernels.MODE_BLIND] == m[kernels.MOTION_RESTLESS] == 1.0
    for rows, columns in ((learned, others), (others, learned)):
        assert not P[np.ix_(rows, columns)].any()
    for some in (learned, others):
        assert np.array_equal(P[np.ix_(some, some)], kept[np.ix_(some, some)])


def test_what_a_radius_tells_of_parameters_since_the_displacement_was_lost_is_kept(kernels, m, P) -> None:
    kept = P.copy()
    m[kernels.MODE_BLIND] = 1.0
    kernels.follow_displacement_loss(m, True)
    assert np.array_equal(P, kept)
    kernels.follow_displacement_loss(m, False)
    assert m[kernels.MODE_BLIND] == 0.0
    assert np.array_equal(P, kept)
