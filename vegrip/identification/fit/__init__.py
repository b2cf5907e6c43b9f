"""Fit a contact model to a recording: all channels at once, noise of displacement and force alike."""

from vegrip.identification.fit.excerpt import excerpt
from vegrip.identification.fit.fitting import fit
from vegrip.identification.fit.noise import Noise, noise_of
from vegrip.identification.fit.result import Fit

__all__ = ["Fit", "Noise", "excerpt", "fit", "noise_of"]
