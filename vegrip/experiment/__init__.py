"""The next experiment: which motion would tell apart what a recording cannot tell apart."""

from vegrip.experiment.contest import NOTHING, Contest, contest_of
from vegrip.experiment.design import Design, Planned, design
from vegrip.experiment.limits import RigLimits

__all__ = ["NOTHING", "Contest", "Design", "Planned", "RigLimits", "contest_of", "design"]
