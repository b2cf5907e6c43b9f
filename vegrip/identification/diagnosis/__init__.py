"""The diagnosis of a model that lacks something: which effect of the catalogue explains what it leaves."""

from vegrip.identification.diagnosis.diagnosis import Diagnosis, diagnose

__all__ = ["Diagnosis", "diagnose"]
