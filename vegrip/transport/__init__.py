"""Transport: how messages travel, one interface (:class:`Endpoint`) over CAN, ZeroMQ and in-process pairs.

Light on purpose: python-can loads this package for any user of the ``vegrip`` interface.
"""

from vegrip.transport.endpoint import Endpoint

__all__ = ["Endpoint"]
