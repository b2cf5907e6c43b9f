"""The protocol for a model when none is given: presses, creep, triangles, sines, pulls and twists."""

from dataclasses import replace

from vegrip.identification.simulate.protocol import Protocol, Segment
from vegrip.model import ContactModel
from vegrip.virtual.bench.protocol import Episode, standard_protocol
from vegrip.virtual.settings import FingertipSettings

CLEARANCE = 0.1  # [x_ref] between tip and object before and after
AIR = 0.3  # [s]


def clear(model: ContactModel) -> Segment:
    """Return a stretch out of contact, long enough to tell the zeros of the sensors."""
    return Segment(AIR, depth=-CLEARANCE * model.reference_depth)


def standard(model: ContactModel, size: float = 0.8) -> Protocol:
    """Return 20 episodes scaled to the fingertip; the deepest press reaches ``size`` x 20 % of its radius."""
    tip = FingertipSettings(
        radius=model.tip_radius,
        reference_indentation=model.reference_depth,
        reference_force=model.values["K"].value if "K" in model.values else 1.0,
        exponent=min(max(model.values["p"].value if "p" in model.values else 1.5, 1.0), 3.0),
    )
    episodes = tuple(_in_air(episode, clear(model)) for episode in standard_protocol(tip, size=size))
    return Protocol("standard", episodes, 20.0)


def _in_air(episode: Episode, air: Segment) -> Episode:
    """Return the episode with clear air before and after it, and contacts that end clear of the surface."""
    away = [replace(s, depth=air.depth) if s.depth == 0.0 else s for s in episode]
    return (air, *away[1:], air)
