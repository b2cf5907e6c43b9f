"""The end-to-end protection of AUTOSAR, profiles 4 and 5, written from the standard, without a library."""


def protected_p04(payload: bytes, data_id: int, counter: int) -> bytes:
    """Return the header of profile 4 and ``payload``: length, counter, Data ID, CRC, high bytes first."""
    head = (12 + len(payload)).to_bytes(2, "big") + counter.to_bytes(2, "big") + data_id.to_bytes(4, "big")
    return head + crc32_p4(head + payload).to_bytes(4, "big") + payload


def is_sound_p04(data: bytes, data_id: int) -> bool:
    """Whether length, Data ID and CRC are right."""
    counter = int.from_bytes(data[2:4], "big")
    return len(data) >= 12 and data == protected_p04(data[12:], data_id, counter)


def protected_p05(data: bytes, data_id: int) -> bytes:
    """Return ``data`` with the CRC of profile 5 in its first two bytes; the counter stands in byte 2."""
    crc = crc16_ccitt(data[2:] + data_id.to_bytes(2, "little"))
    return crc.to_bytes(2, "little") + data[2:]


def is_sound_p05(data: bytes, data_id: int) -> bool:
    """Whether the CRC is right."""
    return data == protected_p05(data, data_id)


def _reflected(polynomial: int) -> tuple[int, ...]:
    table = []
    for byte in range(256):
        crc = byte
        for _ in range(8):
            crc = crc >> 1 ^ (polynomial if crc & 1 else 0)
        table.append(crc)
    return tuple(table)


def _plain(polynomial: int) -> tuple[int, ...]:
    table = []
    for byte in range(256):
        crc = byte << 8
        for _ in range(8):
            crc = crc << 1 ^ (polynomial if crc & 0x8000 else 0)
        table.append(crc & 0xFFFF)
    return tuple(table)


P4 = _reflected(0xC8DF352F)  # 0xF4ACFB13, reflected
CCITT = _plain(0x1021)


def crc32_p4(data: bytes) -> int:
    """CRC-32/AUTOSAR: polynomial 0xF4ACFB13, reflected, start and final XOR 0xFFFFFFFF."""
    crc = 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ P4[(crc ^ byte) & 0xFF]
    return crc ^ 0xFFFFFFFF


def crc16_ccitt(data: bytes) -> int:
    """CRC-16/CCITT-FALSE: polynomial 0x1021, start 0xFFFF, no final XOR."""
    crc = 0xFFFF
    for byte in data:
        crc = crc << 8 & 0xFFFF ^ CCITT[crc >> 8 ^ byte]
    return crc
