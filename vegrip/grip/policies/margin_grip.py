"""The margin grip: raise at once, lower slowly, react to slip, and do not chatter.

Let ``L`` be the least normal force for the wanted margin over the horizon, at the wanted probability, and
``c`` the command held so far.

1. Envelope of the need, fast up and slow down, not below the usual need ``U``::

       p <- max(L, F + (p - F) exp(-dt / release_time)),    F = max(L, U)

   and no release at all within ``settle_time`` of the last rise: loads come in bursts. U is the median of
   the last ``usual_time``: a sensor that errs for less than half of it can neither let the
   grip down nor keep it up. Where friction is learned, so that a slide would be noticed, a need that was
   usual within ``proven_time`` is gone back to without that wait: U is the lower of the two.
2. Felt slip lifts the envelope by ``slip_growth`` per second as long as it lasts, from wherever the command
   is: the model has just been proven wrong, so its answer is not the only one asked.
3. A play of relative width ``dead_band`` (a backlash operator) between envelope and command: noise smaller
   than the play never reaches the actuator, and the command errs on the side of more force::

       c <- p                    if p > c
       c <- p / (1 - dead_band)  if p < c (1 - dead_band)
       c                         otherwise
"""

from dataclasses import dataclass

from vegrip.config import constant, parameter
from vegrip.grip.policies.policy import PolicyKind


@dataclass(frozen=True)
class GripSettings:
    """How the margin grip trades effort against the risk of slip."""

    wanted_margin: float = parameter(0.15, unit="1", low=0.0, high=0.9, doc="slip margin whose bound is kept")
    probability: float = constant(
        0.95,
        unit="1",
        low=1e-6,
        high=1.0 - 1e-6,
        doc="that a finger keeps the margin over the horizon, where its slip would not be noticed",
    )
    known_probability: float = constant(
        0.76, unit="1", low=1e-6, high=1.0 - 1e-6, doc="the same where a slip would surely be noticed"
    )
    dead_band: float = constant(0.04, unit="1", low=0.0, high=0.9, doc="relative dead band of the command")
    release_time: float = constant(0.3, unit="s", low=1e-3, high=3600.0, doc="time constant of lowering")
    settle_time: float = constant(
        0.1, unit="s", low=0.0, high=3600.0, doc="no lowering after a rise for so long"
    )
    usual_time: float = constant(
        2.5, unit="s", low=0.0, high=3600.0, doc="the need is not believed to have fallen for half of it"
    )
    proven_time: float = constant(
        20.0, unit="s", low=1e-3, high=3600.0,
        doc="where friction is learned, a need that was usual in the last so many seconds is gone back to"
        " at once",
    )  # fmt: skip
    drive_lag: float = parameter(
        0.0, unit="s", low=0.0, high=0.2,
        doc="of the force behind its command, until it is measured; 0 = not known, measured where friction is"
        " learned",
    )  # fmt: skip
    burst_rate: float = constant(
        20.0,
        unit="1/s",
        low=0.0,
        high=1e4,
        doc="relative growth of sudden loads, held beforehand for what of a measured lag cannot be led",
    )
    slip_growth: float = constant(8.0, unit="1/s", doc="growth of grip while slip is felt")
    slide_growth: float = constant(
        40.0, unit="1/s", doc="the same where friction is learned, so that a flag is weighed before it counts"
    )


POLICY = PolicyKind(None, GripSettings)
