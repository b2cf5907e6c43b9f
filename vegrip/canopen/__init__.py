"""CANopen (CiA 301) for hands: fingertips and the grasp force node as CANopen devices.

The object dictionaries are ``proto/fingertip.eds`` and ``proto/grasp_force.eds``. SDO, NMT, heartbeat and
EMCY of a device are those of the package ``canopen``; what that package lacks is here: the heartbeat
consumer, the supervision of the sensors, and a way to serve it all from the loop of a node.
"""
