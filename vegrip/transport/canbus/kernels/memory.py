"""Where what lies in the memory of a bus without errors: whole numbers ``t``, bytes ``d``.

Members have slots in the order in which they have joined. The first request of a slot's queue is the one on
the bus while the slot is ``CURRENT``.
"""

from collections.abc import MutableSequence
from typing import Final

Wholes = MutableSequence[int]
Bytes = bytearray

NO_SLOT: Final = -1
NO_PATIENCE: Final = -1
MOST_SLOTS: Final = 24  # members
QUEUE_PLACES: Final = 512  # of a member; the bus reads none whose queue has TRANSMIT_QUEUE
MOST_PAIRS: Final = 1024  # of identifier and mask, of all members
MOST_PACKETS: Final = 128  # to be sent

REQUEST_HEAD: Final = 14  # bytes, see vegrip.transport.canbus.hub_wire
REQUEST_IDENTIFIER: Final = 8
DELIVERY_HEAD: Final = 28
DELIVERY_IDENTIFIER: Final = 22
FRAME_FLAGS: Final = 4  # of a frame as it stands in both: identifier, flags, code, data
FRAME_CODE: Final = 5
FRAME_DATA: Final = 6
FRAME_BYTES: Final = 72

# Whole numbers: of the bus
BITRATE, DATA_BITRATE, BUSY, FREE, CURRENT, START, END, QUEUED, MEMBERS = range(9)
DUE: Final = 9  # [ns] when the first of what is gathered is to be handed out
SENT, PACKETS, BYTES_TO_SEND = 10, 11, 12  # packets that were sent, that are to be, and their bytes
DOOR, WHO, LENGTH = 13, 14, 15  # of the loop: descriptor for newcomers; whose packet is for Python, its bytes
SLOTS: Final = 16
# of a member, from SLOTS + slot * SLOT on
NODE, DESCRIPTOR, HEARS_ITSELF, LISTENS_ONLY, PATIENCE, NUMBER, GATHERED, GATHERED_DUE = range(8)
FIRST, WAITING, PAIRS, FIRST_PAIR = range(8, 12)
SLOT: Final = 12
# of a request, from REQUESTS + (slot * QUEUE_PLACES + place) * REQUEST_WHOLES on
REQUESTS: Final = SLOTS + MOST_SLOTS * SLOT
TIME, KEY = range(2)
REQUEST_WHOLES: Final = 2
FILTERS: Final = REQUESTS + MOST_SLOTS * QUEUE_PLACES * REQUEST_WHOLES  # pairs of identifier and mask
TO_SEND: Final = FILTERS + 2 * MOST_PAIRS
TO_SLOT, TO_SEND_AT, TO_SEND_BYTES = range(3)
PACKET_ENTRY: Final = 3
MEMORY_WHOLES: Final = TO_SEND + MOST_PACKETS * PACKET_ENTRY

# Bytes
RECEIVED: Final = 0  # a packet that a member has sent
LONGEST_PACKET: Final = 4112  # filters, see vegrip.transport.canbus.acceptance
GATHERED_BYTES: Final = 2048  # at most, see vegrip.transport.canbus.hub_wire
GATHERINGS: Final = LONGEST_PACKET
FRAMES: Final = GATHERINGS + MOST_SLOTS * GATHERED_BYTES
OUTBOX: Final = FRAMES + MOST_SLOTS * QUEUE_PLACES * FRAME_BYTES
OUTBOX_BYTES: Final = 4 * MOST_SLOTS * GATHERED_BYTES
MEMORY_BYTES: Final = OUTBOX + OUTBOX_BYTES
