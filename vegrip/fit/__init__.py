"""Fit a contact model to a recording: all channels at once, noise of displacement and force alike."""

from vegrip.fit.noise import Noise, noise_of
from vegrip.fit.recipe import fit
from vegrip.fit.result import Fit

__all__ = ["Fit", "Noise", "fit", "noise_of"]
