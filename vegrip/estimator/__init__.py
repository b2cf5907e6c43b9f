"""The online estimator: one fingertip's contact, limit surface and slip margin, each with its uncertainty."""

from vegrip.estimator.estimator import ContactEstimator
from vegrip.estimator.learning import Learned, Learner
from vegrip.estimator.settings import EstimatorSettings, SensorNoise, Sensors

__all__ = ["ContactEstimator", "EstimatorSettings", "Learned", "Learner", "SensorNoise", "Sensors"]
