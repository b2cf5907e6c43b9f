"""The next experiment: which motion would separate what a recording cannot."""

from vegrip.identification.experiment.design import Design, Planned, design
from vegrip.identification.experiment.design_space import RigLimits
from vegrip.identification.experiment.hypotheses import NO_EFFECT, Hypotheses, hypotheses_of

__all__ = ["NO_EFFECT", "Design", "Hypotheses", "Planned", "RigLimits", "design", "hypotheses_of"]
