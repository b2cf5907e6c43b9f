"""An estimator of another make within the finger step: what it knows is written where the step reads it."""

import math
from typing import Final, NamedTuple

from vegrip.estimator.elapsed import step_time
from vegrip.estimator.layout import Layout, layout_of
from vegrip.estimator.memory import SLIPS
from vegrip.estimator.settings import SensorNoise
from vegrip.grip.confirmed_load import confirm_load
from vegrip.grip.drive_lag import follow_drive
from vegrip.grip.estimator_protocol import Estimator
from vegrip.grip.grasp_memory import GraspMemory
from vegrip.grip.load_lead import lead_load
from vegrip.messages import FingertipState
from vegrip.model import ContactModel, paper_model
from vegrip.types import NamedNumbers

USUAL_NOISE: Final = SensorNoise()
"""Of the sensors of a finger whose estimator does not have it."""
LOADING: Final = 0b1110
"""Tangential forces and torque, bit by bit (:data:`vegrip.estimator.memory.CHANNELS`): one that was lost is
not zero, so without it the margin is not valid."""


class _StandIn(NamedTuple):
    """The model of a step whose own estimate is not used."""

    model: ContactModel
    layout: Layout


STAND_IN: Final = _StandIn(paper_model(8e-3), layout_of(paper_model(8e-3)))


class OwnEstimate:
    """What the step gets of the contact of one finger."""

    def __init__(self, estimator: Estimator, memory: NamedNumbers, shared: GraspMemory, number: int) -> None:
        self._estimator, self._memory, self._shared, self._number = estimator, memory, shared, number

    def take(self, state: FingertipState, wanted: tuple[float, float], *, asks: bool) -> None:
        """Take in an accepted state, and set the demand; ``asks`` for the least force.

        Margin and confidence are those ``wanted``: an estimator of another make shares no friction.
        """
        estimator, memory = self._estimator, self._memory
        estimator.assimilate(state)
        touches = estimator.in_contact
        memory["SAMPLE_BEGUN"], memory["REP_CONTACT"] = 1, float(touches)
        if not memory["TURN_HAS_MARGIN"]:
            memory["TAKEN_BOUND"], memory["TURN_HAS_MARGIN"] = estimator.slip_margin().lower_bound, 1
        if not memory["TURN_STARTED"]:
            memory["REP_FORCE"] = estimator.normal_force.value
        if not memory["TURN_SEEN"]:
            memory["REP_RADIUS"] = estimator.contact_estimate().contact_radius.value
        x, y = state.tangential_force_x, state.tangential_force_y
        memory["DEMAND_LOAD"], memory["DEMAND_TORQUE"] = math.sqrt(x * x + y * y), abs(state.torque_z)
        memory["NEED_SLIPPING"], memory["NEED_IN_CONTACT"] = state.slip >= SLIPS, touches
        if not touches:
            memory["DEMAND_LEAST"], memory["DEMAND_BOUND"] = 0.0, math.nan
            memory["NEED_TRUSTED"] = estimator.normal_force.valid
            return
        is_asked = asks and not memory["INPUT_LOST"] & LOADING
        least = self._least_force(state, wanted) if is_asked else math.nan
        memory["DEMAND_LEAST"], memory["DEMAND_BOUND"] = least, memory["TAKEN_BOUND"]
        memory["NEED_TRUSTED"] = not math.isnan(least)  # infinite: no force suffices, so the largest is best

    def _least_force(self, state: FingertipState, wanted: tuple[float, float]) -> float:
        memory, g, i = self._memory, self._shared, self._number
        x, y, torque = state.tangential_force_x, state.tangential_force_y, state.torque_z
        noise = getattr(self._estimator, "noise", USUAL_NOISE)
        known = memory.section("CONFIRMED")
        x, y, torque = confirm_load(known, 0, x, y, torque, noise.tangential_force, noise.torque_z)
        if not memory["SETUP_LEADS"]:
            return self._estimator.least_force(*wanted, (math.sqrt(x * x + y * y), torque))
        dt = step_time(state.stamp, memory["TURN_LED"])
        memory["TURN_LED"] = state.stamp
        is_following = memory["TURN_STARTED"] and not (
            memory["GRIP_ELAPSED"] >= 0.0 or memory["INPUT_DOUBTFUL"]
        )
        follow_drive(g, i, dt, memory["GRIP_HELD"] if is_following else math.nan, state.normal_force)
        return self._estimator.least_force(*wanted, lead_load(g, i, dt, x, y, torque))
