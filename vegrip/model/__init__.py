"""The contact model, composed of effects and compiled."""

from vegrip.model.file import read_model, write_model
from vegrip.model.model import ContactModel, Simulation
from vegrip.model.paper import BASE, paper_model

__all__ = ["BASE", "ContactModel", "Simulation", "paper_model", "read_model", "write_model"]
