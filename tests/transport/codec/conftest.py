"""Messages of every kind for the codec tests."""

import dataclasses
import math
import struct
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import strategies as st

from vegrip.messages import (
    KNOWN,
    NAN,
    OF_NODES,
    PROBED,
    UNKNOWN,
    Channel,
    Condition,
    ContactEstimate,
    DeviceReport,
    Estimate,
    FingertipState,
    ForceCommand,
    GraspPhase,
    GraspStatus,
    LearnedParameter,
    Lifecycle,
    Message,
    ModelHealth,
    NodeStatus,
    Reason,
    SlipMargin,
)

FINGERS = ("thumb", "index", "middle", "ring", "little")


def _float32(bits: int) -> float:
    """Return the finite float32 with these bits, zero for the others (drawing floats filters too much)."""
    value: float = struct.unpack("<f", bits.to_bytes(4, "little"))[0]
    return value if math.isfinite(value) else 0.0


_stamps = st.integers(0, 2**62).map(lambda us: us // 1000 * 1000)
_sequences = st.integers(0, 2**32 - 1)
_fingers = st.sampled_from(FINGERS)
_counts = st.integers(0, 65535)
_numbers = st.integers(0, 2**32 - 1).map(_float32)
_quantities = _numbers | st.just(math.nan)
_times = _quantities | st.just(math.inf)
_spreads = _numbers.map(abs) | st.just(math.inf)


@st.composite
def _estimates(draw: st.DrawFn) -> Estimate:
    value = draw(_quantities)
    return Estimate(value, draw(_spreads), draw(st.booleans()) and not math.isnan(value), draw(_spreads))


def _builds(cls: type[Any], **fields: Any) -> st.SearchStrategy[Any]:
    owner = {} if cls in OF_NODES else {"finger": _fingers}
    return st.builds(cls, stamp=_stamps, seq=_sequences, **owner, **fields)


def _names(cls: type[Any], default: object) -> list[str]:
    return [f.name for f in dataclasses.fields(cls) if f.default is default]


def _in_order(counts: dict[str, int]) -> dict[str, int]:
    return {name: counts[name] for name in _refusals if name in counts}


_refusals = (
    "unknown_id",
    "layout",
    "length",
    "checksum",
    "version",
    "counter",
    "incomplete",
    "value",
    "other",
)

STRATEGIES: dict[type[Any], st.SearchStrategy[Any]] = {
    FingertipState: _builds(
        FingertipState,
        **dict.fromkeys(_names(FingertipState, NAN), _quantities),
    ),
    ForceCommand: _builds(
        ForceCommand,
        normal_force=_numbers,
        adjustment=_numbers,
        reason=st.sampled_from(Reason),
        expires=st.just(0),
    ).flatmap(
        # every lifetime that the wire carries exactly: 0.1 ms steps up to 0.5 s
        lambda m: st.integers(0, 5000).map(
            lambda steps: ForceCommand(
                m.stamp, m.finger, m.seq, m.normal_force, m.adjustment, m.reason, m.stamp + steps * 100_000
            )
        )
    ),
    SlipMargin: _builds(
        SlipMargin,
        margin=_estimates(),
        lower_bound=_quantities,
        confidence=_quantities,
        force_reserve=_quantities,
        time_to_slip=_times,
        earliest_slip=_times,
    ),
    ContactEstimate: _builds(
        ContactEstimate,
        in_contact=st.booleans(),
        channels=st.integers(0, 63).map(Channel),
        **dict.fromkeys(_names(ContactEstimate, UNKNOWN), _estimates()),
    ),
    ModelHealth: _builds(
        ModelHealth,
        condition=st.sampled_from(Condition),
        nis=_quantities,
        consistent=st.booleans(),
        channel=st.sampled_from(("", "normal_force", "contact_radius")),
        regime=st.sampled_from(("", "air", "loading", "hold", "unloading", "sliding")),
        suspect=st.sampled_from(("", "second_relaxation", "adhesion", "rolling")),
        rejected=_counts,
        friction=st.sampled_from(("", PROBED, KNOWN)),
    ),
    LearnedParameter: _builds(
        LearnedParameter,
        symbol=st.sampled_from(("K", "p", "mu")),
        raw=_estimates(),
        filtered=_estimates(),
        excited=_quantities,
    ),
    NodeStatus: _builds(
        NodeStatus,
        node=st.sampled_from(("grasp_force", "virtual_hand")),
        state=st.sampled_from(Lifecycle),
        deadline_misses=_counts,
        dropped=_counts,
        rejected=st.dictionaries(st.sampled_from(_refusals), st.integers(1, 65535)).map(_in_order),
        **dict.fromkeys(_names(NodeStatus, NAN), _quantities),
    ),
    DeviceReport: _builds(DeviceReport, slip_state=_quantities, friction=_quantities, grip_force=_quantities),
    GraspStatus: _builds(
        GraspStatus,
        node=st.sampled_from(("grasp_force", "left")),
        phase=st.sampled_from(GraspPhase),
        reason=st.sampled_from(("", "thumb touches nothing")),
        normal_force=_quantities,
        margin=_quantities,
    ),
}


@pytest.fixture(scope="session")
def messages() -> Callable[..., st.SearchStrategy[Message]]:
    """Give strategies for messages of one kind, or of all, that the FD layout carries exactly."""

    def of(cls: type[Any] | None = None) -> st.SearchStrategy[Message]:
        return STRATEGIES[cls] if cls is not None else st.one_of(*STRATEGIES.values())

    return of


@pytest.fixture(scope="session")
def examples() -> list[Message]:
    """Give one ordinary message of every kind."""
    known = Estimate(0.6, 0.05, True, 0.002)
    force = Estimate(4.0, 0.1, True, 0.002)
    small = Estimate(0.004, 0.0002, True, 0.002)
    second = 1_000_000_000
    return [
        FingertipState(second, "index", 7, 4.0, 0.5, -0.25, 0.002, 0.001, 31.5, 0.0, 0.001, 0.004),
        ContactEstimate(
            *(second, "index", 7, True, Channel.FORCE | Channel.TORQUE),
            *(small, force, small, Estimate(2.5, 0.1, True, 0.01), known, force, small, force),
        ),
        SlipMargin(second, "index", 7, Estimate(0.4, 0.03, True, 0.002), 0.33, 0.95, 1.2, 4.0, 2.5),
        ForceCommand(second, "index", 7, 4.2, 0.2, Reason.RAISE, second + 50_000_000),
        ModelHealth(
            second, "index", 7, Condition.DEGRADED, 1.5, True, "torque_z", "hold", "adhesion", 3, KNOWN
        ),
        LearnedParameter(second, "index", 7, "K", known, known, 12.5),
        NodeStatus(
            *(second, "grasp_force", 7, Lifecycle.ACTIVE),
            *(2500.0, 2500.0, 40.0, 90.0, 400.0, 60.0, 1, 2, {"checksum": 3}),
        ),
    ]
