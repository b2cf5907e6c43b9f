"""When a part of the load that was gone at once is doubted no more."""

import pytest

LASTING = 1.1  # [s]


@pytest.fixture
def doubted(kernels, m):
    """Return the memory of a contact that held a torque of 1 mN m, which has just gone."""
    at = kernels.PART0 + kernels.PART_SIZE * kernels.PART_OF_TORQUE
    for name in ("AVERAGE", "LEAST", "BEFORE", "LAST"):
        m[at + getattr(kernels, f"PART_{name}")] = 1e-3
    m[at + kernels.PART_LOST] = kernels.LASTING
    return m


def test_a_doubt_is_over_at_the_moment_at_which_its_time_is(kernels, doubted) -> None:
    at = kernels.PART0 + kernels.PART_SIZE * kernels.PART_OF_TORQUE
    kernels.wait_for_part(doubted, at, 0.5 * LASTING, 0.0)
    assert kernels.is_load_doubted(doubted)
    kernels.wait_for_part(doubted, at, 0.5 * LASTING, 0.0)
    assert not kernels.is_load_doubted(doubted)
    assert not doubted[at : at + kernels.PART_SIZE].any()  # nothing is known of it


def test_a_part_that_is_doubted_does_not_stay(kernels, doubted) -> None:
    at = kernels.PART0 + kernels.PART_SIZE * kernels.PART_OF_TORQUE
    for lost, stays in ((0.5, False), (0.0, True)):
        doubted[at + kernels.PART_LOST] = lost
        assert kernels.does_part_stay(doubted, kernels.PART_OF_TORQUE, 1e-3, 1e-5) == stays


@pytest.mark.parametrize("dt", [0.002, 0.05])
@pytest.mark.parametrize("name", ["FORCE", "TORQUE"])
def test_an_average_approaches_a_steady_value_by_the_same_share_each_sample(kernels, m, dt, name) -> None:
    """By dt / (0.1 s + dt), whatever else is known of the part; the other part stays as it is."""
    part = getattr(kernels, f"PART_OF_{name}")
    at, other = (kernels.PART0 + kernels.PART_SIZE * one for one in (part, 1 - part))
    m[kernels.PART0 : kernels.PART0 + 2 * kernels.PART_SIZE] = 0.375
    m[at + kernels.PART_AVERAGE], m[at + kernels.PART_BLOCK] = 0.5, 0.0
    for n in range(1, 6):
        kernels.note_part(m, at, dt, 2.0)
        left = (1.0 - dt / (0.1 + dt)) ** n
        assert m[at + kernels.PART_AVERAGE] == pytest.approx(2.0 - 1.5 * left, rel=1e-12)
    assert m[at + kernels.PART_LAST] == 2.0
    assert (m[other : other + kernels.PART_SIZE] == 0.375).all()
