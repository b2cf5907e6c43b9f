"""Transport: how messages travel, one interface (:class:`vegrip.transport.endpoint.Endpoint`) over all wires.

Light on purpose: the process of a virtual bus loads this package, and python-can for any user of ``vegrip``.
"""
