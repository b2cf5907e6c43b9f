"""The contact model, composed of effects and compiled."""

from vegrip.model.channels import Predictor, predict
from vegrip.model.file import read_model, write_model
from vegrip.model.model import BASE, ContactModel, Shown, Simulation, material_model, paper_model

__all__ = [
    "BASE",
    "ContactModel",
    "Predictor",
    "Shown",
    "Simulation",
    "material_model",
    "paper_model",
    "predict",
    "read_model",
    "write_model",
]
