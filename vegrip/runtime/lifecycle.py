"""The lifecycle of a managed node, as in ROS 2: which transition leads where. Pure.

::

    unconfigured --configure--> inactive --activate--> active
         ^-------cleanup-----------'  ^---deactivate-----'
    shutdown leads from everywhere to finalized, which nothing leaves.
"""

from vegrip.errors import UsageError
from vegrip.messages import Lifecycle

TRANSITIONS: dict[str, tuple[frozenset[Lifecycle], Lifecycle]] = {
    # name: (states it may leave, state it leads to)
    "configure": (frozenset({Lifecycle.UNCONFIGURED}), Lifecycle.INACTIVE),
    "activate": (frozenset({Lifecycle.INACTIVE}), Lifecycle.ACTIVE),
    "deactivate": (frozenset({Lifecycle.ACTIVE}), Lifecycle.INACTIVE),
    "cleanup": (frozenset({Lifecycle.INACTIVE}), Lifecycle.UNCONFIGURED),
    "shutdown": (frozenset(Lifecycle) - {Lifecycle.FINALIZED}, Lifecycle.FINALIZED),
}


def state_after(state: Lifecycle, transition: str) -> Lifecycle:
    """Return the state that ``transition`` leads to from ``state``.

    Raises:
        UsageError: there is no such transition, or not from this state.

    """
    if transition not in TRANSITIONS:
        raise UsageError(f"there is no transition {transition!r}; there are {', '.join(TRANSITIONS)}")
    sources, target = TRANSITIONS[transition]
    if state not in sources:
        possible = ", ".join(allowed_transitions(state)) or "none"
        raise UsageError(f"a node that is {state.name.lower()} cannot {transition}; it can: {possible}")
    return target


def allowed_transitions(state: Lifecycle) -> list[str]:
    return [name for name, (sources, _) in TRANSITIONS.items() if state in sources]


def route(state: Lifecycle, target: Lifecycle) -> list[str]:
    """Return the shortest list of transitions from ``state`` to ``target``.

    Raises:
        UsageError: no way leads there.

    """
    routes: dict[Lifecycle, list[str]] = {state: []}
    frontier = [state]
    while target not in routes and frontier:
        here = frontier.pop(0)
        for name in allowed_transitions(here):
            there = TRANSITIONS[name][1]
            if there not in routes:
                routes[there] = [*routes[here], name]
                frontier.append(there)
    if target not in routes:
        raise UsageError(f"a node that is {state.name.lower()} cannot become {target.name.lower()}")
    return routes[target]
