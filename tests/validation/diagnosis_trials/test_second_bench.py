"""The second bench against closed forms, and the pairs that it is asked about."""

import numpy as np
import pytest

from validation.diagnosis_trials import pairs, second_bench
from validation.diagnosis_trials.pairs import Said
from validation.diagnosis_trials.second_bench import Laws, Move, Tip

TIP = Tip(radius=8e-3, force=1.2, exponent=1.5, share=0.3, rate=3.1, friction=0.7)
DEPTH = 1e-3


def simulated(moves, dt=1e-3, **hidden):
    laws = Laws(hidden)
    return second_bench.simulate(TIP, laws, [[Move(0.01, depth=0.0), *moves]], dt)


def test_a_step_that_is_held_relaxes_as_one_branch() -> None:
    true = simulated([Move(1e-3, depth=DEPTH), Move(1.0)])
    since = true["t"] - 0.011
    held = since > 2e-3
    expected = TIP.force * (1.0 - TIP.share * -np.expm1(-TIP.rate * since[held]))
    assert true["N"][held] == pytest.approx(expected, rel=2e-3)


def test_a_surface_that_is_left_recovers_before_it_is_touched_again() -> None:
    """A free surface has N = 0: z decays with (1 - c) nu, and N returns where N_e exceeds c z."""
    true = simulated([Move(1e-3, depth=DEPTH), Move(2.0), Move(1e-3, depth=0.0), Move(0.2, depth=DEPTH)])
    back = true["t"] > 2.0125
    first = np.argmax(back & (true["N"] > 0.0))
    z = TIP.force * np.exp(-TIP.rate * (1.0 - TIP.share) * (true["t"][first] - 2.012))
    assert TIP.force * (1e3 * true["x"][first]) ** 1.5 == pytest.approx(TIP.share * z, rel=0.03)


def test_a_hertzian_contact_is_twisted_at_three_sixteenths_of_pi() -> None:
    assert second_bench.twist_of(np.array([2.0, 3.0])) == pytest.approx(
        [3 * np.pi / 16, 0.620245007], rel=1e-8
    )
    true = simulated([Move(1e-3, depth=DEPTH), Move(0.3, spin=5.0)])
    q, N, a = (true[name][true["slip"] > 0.0] for name in ("q", "N", "a"))
    arm = q / N / a / TIP.friction
    assert arm == pytest.approx(np.full(arm.size, 3 * np.pi / 16), rel=2e-3)


def test_static_friction_grows_with_the_rest_and_is_gone_after_its_distance() -> None:
    ageing = {"growth": 0.05, "time": 0.1, "distance": 1e-5}
    true = simulated([Move(1e-3, depth=DEPTH), Move(3.0), Move(0.5, pull=1e-3)], friction_ageing=ageing)
    mu = (true["f"] / np.maximum(true["N"], 1e-9))[true["slip"] > 0.0]
    assert mu[0] == pytest.approx(0.7 * (1.0 + 0.05 * np.log1p(3.0 / 0.1)), rel=5e-3)
    assert mu[-1] == pytest.approx(0.7 * (1.0 + 0.05 * np.log1p(0.01 / 0.1)), rel=5e-3)


def test_softening_heals_in_the_pauses_and_not_in_contact() -> None:
    laws = Laws({"healing_softening": {"loss": 0.2, "width": 3e-4, "rate": 0.1}})
    laws.close(DEPTH, 1.0)
    laws.close(0.5 * DEPTH, 5.0)
    assert laws.deepest == DEPTH
    laws.close(-1.0, 5.0)
    assert laws.deepest == pytest.approx(DEPTH * np.exp(-0.5))


def test_slip_is_felt_where_the_share_of_the_area_has_slipped() -> None:
    """Half of the area has slipped at half of the way: f = mu N (1 - (1/2)^1.5)."""
    kick = {"distance": 2e-4, "felt": 0.5, "speed_at_once": 0.0}
    true = simulated([Move(1e-3, depth=DEPTH), Move(1.0, pull=1e-3)], presliding=kick)
    felt = np.argmax(true["slip"] > 0.0)
    assert true["f"][felt] / true["N"][felt] == pytest.approx(0.7 * (1.0 - 0.5**1.5), rel=0.01)
    assert true["speed"][felt] == 0.0
    assert true["f"][-1] / true["N"][-1] == pytest.approx(0.7)


def said(named=(), sets=(), hidden="adhesion") -> Said:
    return Said(hidden, "jkr_adhesion", "use", 0, "named", named, sets)


@pytest.mark.parametrize(
    ("one", "right", "false"),
    [
        (said(("adhesion",)), True, False),
        (said(("jkr_adhesion",)), False, True),
        (said(("adhesion", "inertia")), False, True),
        (said((), (("adhesion", "jkr_adhesion"),)), True, False),
        (said((), (("inertia", "jkr_adhesion"),)), False, True),
        (said(), False, False),
    ],
)
def test_right_is_a_name_or_a_set_that_holds_what_is_hidden(one, right, false) -> None:
    assert (one.is_right, one.is_false) == (right, false)


def test_every_pair_is_there_in_both_directions() -> None:
    assert set(pairs.PAIRS) == {(b, a) for a, b in pairs.PAIRS}
    assert all(a != b for a, b in pairs.PAIRS)


def test_a_matrix_has_the_shares_of_each_answer() -> None:
    both = ("adhesion", "jkr_adhesion")
    rows, columns, shares = pairs.matrix_of(
        [said(("adhesion",)), said((), (both,)), said(hidden="jkr_adhesion")]
    )
    assert rows == ["adhesion", "jkr_adhesion"]
    assert columns == [*rows, pairs.NOTHING]
    assert shares == pytest.approx(np.array([[0.75, 0.25, 0.0], [0.0, 0.0, 1.0]]))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("hidden", "rival", "style"),
    [
        ("layer_over_core", "saturation", "short"),  # was exponential_stiffness, for sure
        ("presliding", "friction_ageing", "short"),  # was rate_dependent_friction, for sure
        *(
            pytest.param(*others, "short", marks=pytest.mark.long)
            for others in (
                ("friction_ageing", "wet_contact"),
                ("healing_softening", "mullins_softening"),
                ("wet_contact", "rate_dependent_friction"),
            )
        ),
    ],
)
def test_of_two_that_resemble_each_other_the_wrong_one_is_not_named(hidden, rival, style) -> None:
    one = pairs.judge(hidden, rival, style, 0)
    assert one.is_right, one
