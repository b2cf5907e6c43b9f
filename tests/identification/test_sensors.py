"""What is promised of a set of sensors is what the estimator gives for it."""

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise
from vegrip.estimator.friction_prior import COULOMB
from vegrip.identification.recording import Recording
from vegrip.identification.samples import SAMPLE_RADIUS_M, recording
from vegrip.identification.sensors import (
    TANGENTIAL_CHANNELS,
    answers,
    lacking,
    share_of,
    with_load,
)
from vegrip.messages import FingertipState
from vegrip.model import paper_model

CHANNELS = ("normal_force", "displacement", "tangential_force_x", "tangential_force_y", "torque_z")
SUBSETS = [
    frozenset(name for name, has in zip(CHANNELS, chosen, strict=True) if has)
    for chosen in product((False, True), repeat=len(CHANNELS))
]
MARGIN = "slip margin, time to slip, grip command"
STIFFNESS = "stiffness and relaxation learned"
CONTACT = "contact radius, pressure exponent, limit force"


@pytest.fixture(scope="module")
def press() -> list[FingertipState]:
    """The first two seconds of the sample, in contact at the end, with every channel."""
    states = [state for state in recording().states("thumb") if state.stamp < 2_000_000_000]
    return [replace(state, tangential_force_y=0.0, torque_z=0.0) for state in states]


@pytest.mark.parametrize("channels", SUBSETS, ids=lambda one: "+".join(sorted(one)) or "nothing")
def test_the_estimator_gives_what_is_promised_and_no_more(
    channels: frozenset[str], press: list[FingertipState]
) -> None:
    noise, settings = SensorNoise(normal_force=0.01, displacement=5e-6), EstimatorSettings(friction=COULOMB)
    finger = ContactEstimator(paper_model(SAMPLE_RADIUS_M), noise, settings)
    missing = dict.fromkeys(("slip", "slip_speed", *(set(CHANNELS) - channels)), math.nan)
    for state in press:
        contact = finger.update(replace(state, **missing))
    promised = answers(channels)
    assert contact.contact_radius.valid == promised[CONTACT]
    assert math.isfinite(finger.slip_margin().lower_bound) == promised[MARGIN]
    assert math.isfinite(finger.least_force(0.15)) == promised[MARGIN]
    assert (
        bool([text for text in lacking(channels) if "no slip margin" in text or "no estimate" in text])
        != (promised[MARGIN])
    )
    if promised[CONTACT]:
        assert any("stiffness" in text for text in lacking(channels)) != promised[STIFFNESS]


def test_what_is_lacking_is_told_with_what_it_costs_and_nothing_where_all_is_there() -> None:
    assert lacking((*CHANNELS, "slip")) == []
    assert lacking(()) == ["no estimate at all: neither normal_force nor displacement is measured"]
    assert lacking(("normal_force", *TANGENTIAL_CHANNELS, "torque_z", "slip_speed")) == [
        "stiffness and relaxation stay as in the model file: displacement is not measured beside normal_force"
    ]
    assert lacking(CHANNELS) == [
        "friction stays as in the model file unless a slip shows in the forces: "
        "neither slip nor slip_speed is measured"
    ]
    margin = lacking(("normal_force", "displacement", "tangential_force_x"), "state the load")
    assert margin == [
        "no slip margin and no grip command: tangential_force_y is not measured; state the load"
    ]
    for channels in SUBSETS:
        for sentence in lacking(channels):
            cost, _, cause = sentence.partition(": ")
            assert cost
            assert "measured" in sentence
            assert cause


def test_a_stated_load_gives_a_margin_where_none_is_measured() -> None:
    t = np.arange(200) * 1e-2
    force = {"normal_force": np.full(200, 2.0)}
    stated = with_load(Recording("r", t, np.zeros(200, dtype=np.int64), force), share_of(0.1, 2))
    noise, settings = SensorNoise(normal_force=0.01, displacement=5e-6), EstimatorSettings(friction=COULOMB)
    finger = ContactEstimator(paper_model(SAMPLE_RADIUS_M), noise, settings)
    for state in stated.states("thumb"):
        finger.update(state)
    expected = 1.0 - 0.1 * 9.81 / 2 / (paper_model(SAMPLE_RADIUS_M).values["mu"].value * 2.0)
    assert finger.slip_margin().margin.value == pytest.approx(expected, abs=0.02)


def test_a_measured_load_is_not_replaced_by_a_stated_one() -> None:
    t = np.arange(3) * 1e-2
    measured = {name: np.ones(3) for name in ("normal_force", *TANGENTIAL_CHANNELS)}
    one = Recording("r", t, np.zeros(3, dtype=np.int64), measured)
    assert with_load(one, 5.0) is one
