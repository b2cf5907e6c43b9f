"""How much force a finger shall apply: the margin policy, and those that it is compared with.

A package of your own adds a policy by an entry point in the group ``vegrip.policies``; what it names is a
:class:`~vegrip.grip.policies.policy.PolicyKind`::

    [project.entry-points."vegrip.policies"]
    my_policy = "my_package.my_policy:POLICY"

A launch file chooses it with ``policy = "my_policy"`` and sets it with the table ``policy_settings``.
"""

import functools
import importlib
from importlib.metadata import entry_points

from vegrip.errors import ConfigError, first_line, suggestion
from vegrip.grip.policies.policy import GripPolicy, PolicyKind

__all__ = ["GROUP", "POLICIES", "GripPolicy", "PolicyKind", "find_policy", "policy_names"]

POLICIES: dict[str, str] = {
    # name: module:object, a PolicyKind
    "margin": "vegrip.grip.policies.margin_grip:POLICY",
    "constant": "vegrip.grip.policies.baselines:CONSTANT",
    "cone": "vegrip.grip.policies.baselines:CONE",
    "elastic": "vegrip.grip.policies.baselines:ELASTIC",
}
"""The policies that are built in."""

GROUP = "vegrip.policies"


def policy_names() -> list[str]:
    return [*POLICIES, *sorted(point.name for point in entry_points(group=GROUP))]


def find_policy(name: str) -> PolicyKind:
    """Return the kind of policy called ``name``.

    Raises:
        ConfigError: there is no such policy, or the package that adds it does not hold to the contract.

    """
    if name in POLICIES:
        module, _, attribute = POLICIES[name].partition(":")
        found: object = getattr(importlib.import_module(module), attribute)
    else:
        found = _added(name)
    if not isinstance(found, PolicyKind):
        raise ConfigError(f"the grip policy {name!r} is not a PolicyKind; its entry point must name one")
    return found


@functools.cache
def _added(name: str) -> object:
    """Return what another package offers under ``name``; kept, because a running node asks again."""
    point = next(iter(entry_points(group=GROUP, name=name)), None)
    if point is None:
        raise ConfigError(f"there is no grip policy {name!r}; {suggestion(name, policy_names())}")
    try:
        return point.load()
    except Exception as error:  # noqa: BLE001 (whatever a policy of another package raises when imported)
        what = f"the grip policy {name!r} cannot be loaded from {point.value}"
        raise ConfigError(f"{what}: {first_line(error)}") from None
