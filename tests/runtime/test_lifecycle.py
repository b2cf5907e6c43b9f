"""Laws of the lifecycle."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip.errors import UsageError
from vegrip.messages import Lifecycle
from vegrip.runtime.lifecycle import TRANSITIONS, after, allowed, route

states = st.sampled_from(list(Lifecycle))


@given(states, st.sampled_from(list(TRANSITIONS)))
def test_a_transition_is_made_or_refused_never_ignored(state, transition):
    if transition in allowed(state):
        assert after(state, transition) is TRANSITIONS[transition][1]
    else:
        with pytest.raises(UsageError, match=state.name.lower()):
            after(state, transition)


def test_nothing_leaves_finalized():
    assert allowed(Lifecycle.FINALIZED) == []


def test_only_an_inactive_node_becomes_active():
    assert [state for state in Lifecycle if "activate" in allowed(state)] == [Lifecycle.INACTIVE]


@given(states, states)
def test_a_route_leads_where_it_says(start, target):
    if start is Lifecycle.FINALIZED and target is not start:
        with pytest.raises(UsageError):
            route(start, target)
        return
    state = start
    for transition in route(start, target):
        state = after(state, transition)
    assert state is target


def test_an_unknown_transition_names_the_known_ones():
    with pytest.raises(UsageError, match="configure, activate, deactivate, cleanup, shutdown"):
        after(Lifecycle.ACTIVE, "explode")
