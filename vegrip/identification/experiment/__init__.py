"""The next experiment: which motion would tell apart what a recording cannot tell apart."""

from vegrip.identification.experiment.design import Design, Planned, design
from vegrip.identification.experiment.hypotheses import NOTHING, Contest, contest_of
from vegrip.identification.experiment.limits import RigLimits

__all__ = ["NOTHING", "Contest", "Design", "Planned", "RigLimits", "contest_of", "design"]
