"""The packed numbers of an estimator by their names."""

import math

import numpy as np
import pytest

from vegrip.estimator.initial_state import initial_memory
from vegrip.estimator.layout import REPORT, layout_of, state_names
from vegrip.estimator.memory import EstimatorMemory
from vegrip.estimator.settings import EstimatorSettings, SensorNoise
from vegrip.messages import FingertipState
from vegrip.model import paper_model


@pytest.fixture
def memory():
    model = paper_model(8e-3)
    layout = layout_of(model)
    return EstimatorMemory(layout, initial_memory(model, layout, SensorNoise(), EstimatorSettings()))


def test_every_name_finds_the_number_that_the_layout_puts_there(memory):
    memory.numbers[:] = np.arange(memory.layout.size)
    places = memory.layout.places()
    assert memory.report("SOUND") == places["REPORT"][0] + REPORT.index("SOUND")
    assert memory.reports() == [memory.report(name) for name in REPORT]
    assert memory.count("OVERFLOWS") == places["COUNTS"][0] + 1
    assert memory.friction[0] == memory.section("FRICTION")[0]
    assert memory.means.tolist() == memory.section("Y").tolist()
    n = memory.layout.n
    assert memory.covariance[1, 2] == memory.section("P")[n + 2]
    assert len(state_names(paper_model(8e-3), memory.layout)) == n


def test_what_is_read_is_a_copy_and_a_section_is_not(memory):
    memory.means[0] = memory.covariance[0, 0] = 7.0
    assert memory.section("Y")[0] != 7.0
    memory.section("Y")[0] = 7.0
    assert memory.means[0] == 7.0


def test_a_value_that_is_not_measured_leaves_what_effects_feel_as_it_was(memory):
    memory.set_exogenous(FingertipState(0, "thumb", 0, temperature=31.0, slip=1.0, slip_speed=0.2), 1.5, 2.5)
    felt = memory.section("EXOGENOUS").tolist()
    assert felt[:4] == [31.0, 1.5, 2.5, 0.2]
    memory.set_exogenous(FingertipState(1, "thumb", 1, temperature=math.nan), math.inf, math.nan)
    assert memory.section("EXOGENOUS").tolist() == felt


def test_the_noise_of_a_slip_speed_is_no_sliding_while_the_contact_sticks(memory):
    memory.set_exogenous(FingertipState(0, "thumb", 0, slip=0.0, slip_speed=0.2), 1.0, 0.0)
    assert memory.section("EXOGENOUS")[3] == 0.0


def test_it_moves_into_other_numbers_with_all_it_knows_and_is_reset_there(memory):
    memory.section("Y")[0] = 7.0
    lent = np.zeros(memory.layout.size)
    memory.move_to(lent)
    assert lent[memory.layout.places()["Y"][0]] == 7.0
    lent[memory.layout.places()["Y"][0]] = 8.0
    assert memory.means[0] == 8.0, "the kernels write there"
    memory.reset()
    assert memory.means[0] == lent[memory.layout.places()["Y"][0]] == 0.0
