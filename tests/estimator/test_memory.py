"""The numbers of an estimator by their names, alone and in the memory of a finger."""

import math

import pytest

from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise
from vegrip.estimator.friction_prior import COULOMB
from vegrip.estimator.initial_state import initial_memory
from vegrip.estimator.layout import FRICTION, PER_CHANNEL, SETTINGS, layout_of
from vegrip.estimator.memory import FingerMemory
from vegrip.grip.layout import FingerLayout
from vegrip.messages import FingertipState
from vegrip.model import paper_model


@pytest.fixture
def estimator():
    return ContactEstimator(paper_model(8e-3), SensorNoise())


@pytest.fixture
def memory(estimator):
    return FingerMemory(FingerLayout(estimator.layout, estimator.settings.late, history=5, is_shared=True))


def test_every_number_has_one_name(memory):
    layout = memory.layout
    for places, first, end in (
        (layout.reals, layout.filter.size, layout.n_reals),
        (layout.wholes, 0, layout.n_wholes),
    ):
        named = [place for name, place in places.items() if not name.endswith("0")]
        assert len(named) == len(set(named))
        assert min(named) >= first
        assert max(places.values()) < end


def test_a_value_that_is_not_measured_leaves_what_effects_feel_as_it_was(estimator):
    felt = estimator.named.section("EXOGENOUS")
    estimator.update(
        FingertipState(0, "thumb", 0, 1.0, 1.5, 0.0, 2.5, temperature=31.0, slip=1.0, slip_speed=0.2)
    )
    assert felt.tolist()[:4] == [31.0, 1.5, 2.5, 0.2]
    before = felt.tolist()
    estimator.update(FingertipState(1, "thumb", 1, 1.0, math.inf, math.nan, math.nan, temperature=math.nan))
    assert felt.tolist() == [*before[:4], math.inf if math.isinf(felt[4]) else before[4], before[5]]


def test_the_noise_of_a_slip_speed_is_no_sliding_while_the_contact_sticks(estimator):
    estimator.update(FingertipState(0, "thumb", 0, 1.0, 1.0, slip=0.0, slip_speed=0.2))
    assert estimator.named.section("EXOGENOUS")[3] == 0.0


def test_what_it_knows_moves_with_it_and_is_reset_where_it_lies(estimator, memory):
    estimator.update(FingertipState(10**9, "thumb", 0, 1.0, displacement=1e-3))
    before, known = estimator.memory.tobytes(), repr(estimator.contact_estimate())
    memory["STATE_DISPLACEMENT"] = 7.0
    estimator.mount(memory, "thumb")
    assert memory["STATE_DISPLACEMENT"] == 7.0, "the state of the finger stays"
    assert (estimator.memory.tobytes(), repr(estimator.contact_estimate())) == (before, known)
    assert memory.section("ESTIMATOR").tobytes() == before
    estimator.reset()
    assert memory.section("ESTIMATOR").tobytes() != before
    assert memory["SAMPLE_SEQ"] == 0
    assert memory["CLOCK_RECOVERY"] == estimator.settings.recovery


@pytest.mark.parametrize(("hold", "stiffness"), [("position", math.inf), ("force", 0.0), ("mixed", 700.0)])
def test_at_first_nothing_is_known_but_what_model_noise_and_settings_say(hold, stiffness):
    model, noise, R = paper_model(8e-3), SensorNoise(0.02, 1e-5, 0.03, 2e-4, 6e-5), 8e-3
    settings = EstimatorSettings(
        offset=0.003, force_bias=4.0, agility=2.0, hold=hold, hold_stiffness=700.0, confidence=0.9,
        horizon=0.7, longest_gap=0.3, regrasp=0.07, friction_drift=0.04, friction_scatter=0.08,
        health_time=3.0, learning_rest=9.0, friction=COULOMB,
    )  # fmt: skip
    layout = layout_of(model)
    m = initial_memory(model, layout, noise, settings)
    of = {name: m[slice(*place)].tolist() for name, place in layout.places().items()}
    mu, states, nothing = model.values["mu"], layout.n_states, [0.0, 0.0]
    learned = [model.values[list(model.parameters)[place]] for place in layout.learned]
    assert dict(zip(SETTINGS, of["SET"], strict=True)) == pytest.approx({
        "ACCELERATION": R**2 * 8.0, "R_FORCE": 4e-4, "R_DISPLACEMENT": 1e-10, "R_RADIUS": 3.6e-9,
        "S_TANGENTIAL": 0.03, "S_TORQUE": 2e-4, "LONGEST_GAP": 0.3, "TIP_RADIUS": R,
        "DEPTH": model.reference_depth, "QUANTILE": 1.2815515655446004, "HORIZON": 0.7, "HOLD": stiffness,
        "SCATTER": 0.08, "MU_DRIFT": 0.04, "REGRASP": 0.07, "MU_PRIOR_VAR": mu.std**2, "HEALTH_TIME": 3.0,
        "LEARNING_REST": 9.0,
    }, rel=1e-12, abs=0.0)  # fmt: skip
    variances = [(0.3 * R) ** 2, (2.0 * R) ** 2, *[0.0] * states, *(one.std**2 for one in learned)]
    assert of["PRIOR"] == pytest.approx([*variances, (0.003 * R) ** 2, 0.08**2], rel=1e-12, abs=0.0)
    assert of["Y"] == of["START"]
    assert of["Y"][:2] == of["Y"][-2:] == of["DRIFT"][:2] == nothing
    assert of["DRIFT"][2 : 2 + states] == [0.0] * states
    free = layout.learned_from
    assert of["LOW"][:free] + of["LOW"][-2:] == [-math.inf] * (free + 2)
    assert of["HIGH"][:free] + of["HIGH"][-2:] == [math.inf] * (free + 2)
    assert all(low < y < high for low, y, high in zip(of["LOW"], of["Y"], of["HIGH"], strict=True))
    friction = dict(zip(FRICTION, of["FRICTION"], strict=True))
    ln_mu = math.log(mu.value)
    told = {"LN_MU": ln_mu, "BASE_LN": ln_mu, "VAR": mu.std**2, "BASE_VAR": mu.std**2}
    told |= {"UNCONFIRMED": math.inf, "SCATTER_VAR": 0.08**2}
    assert friction == pytest.approx(dict.fromkeys(FRICTION, 0.0) | told, rel=1e-12, abs=0.0)
    assert of["CONSIDER"][-1] == pytest.approx(mu.std**2)
    assert of["EXOGENOUS"] == [model.reference_temperature, *[0.0] * 5]
    assert of["CHANNEL"] == [math.inf if name == "AGE" else 0.0 for name in PER_CHANNEL] * 3


def test_zeros_walk_in_a_moment_as_far_as_disturbances_of_their_spread_and_time_constant():
    """The variance that a stationary disturbance changes by within dt is 2 s^2 (1 - exp(-dt / tau))."""
    noise = SensorNoise(normal_force=0.02, displacement=1e-5)
    times = {"displacement_drift_time": 4.0, "force_drift_time": 7.0}
    settings = EstimatorSettings(displacement_drift=0.3, force_drift=0.2, **times)
    estimator = ContactEstimator(paper_model(8e-3), noise, settings)
    first, last = estimator.layout.places()["DRIFT"]
    walks = estimator.memory[first:last].tolist()[-2:]
    for rate, spread, time in zip(walks, (0.3 * 1e-5, 0.2 * 0.02), times.values(), strict=True):
        moment = 1e-6 * time
        grown = -2.0 * spread**2 * math.expm1(-moment / time)
        assert rate * moment == pytest.approx(grown, rel=1e-5, abs=0.0)
