"""Backlash of the drive: ``x+ = min(max(x, d - w / 2), d + w / 2)``.

The play operator ([BrokateSprekels1996]_, chapter 2): the tip rests within a gap of width w and moves only
when the drive has crossed it. It depends on the order of the reversals and not on their speed.
"""

from vegrip.effects.contract import Effect, State, hook
from vegrip.parameters import Parameter


def tip(x: float, reference_depth: float, play: float, x_p: float) -> tuple[float, float]:
    """Return the indentation behind the backlash [m], twice: it is also the memory."""
    half = 0.5 * play * reference_depth
    x_p = min(max(x_p, x - half), x + half)
    return x_p, x_p


EFFECT = Effect(
    name="displacement_backlash",
    summary="after a reversal the tip follows only when a gap is crossed",
    residual="odd in direction, after reversals, as large as the stiffness, the same at all speeds",
    cites=("BrokateSprekels1996",),
    parameters=(
        Parameter("play", "1", 0.02, 0.02, 0.0, 1.0, "width of the gap, in x_ref", null=0.0, of="x_ref"),
    ),
    states=(State("x_p", "m", "indentation behind the backlash", low="x", high="x", lasting=True),),
    hooks=(hook(tip),),
    confounded=("sensor_lag", "guide_friction"),
    experiment="reversals of equal size at 0.1 and at 5 Hz",
    kinked=True,
    min_displacement_noises=(("play", 3.0),),
    trial_sizes=(0.2, 1.0, 4.0),
)
