"""How a text file from elsewhere is encoded: UTF-16 and UTF-8 with or without a mark, else Windows-1252.

Text in Windows-1252 with letters beyond ASCII is hardly ever valid UTF-8, so UTF-8 is tried first.
"""

from typing import Final

EIGHT_BIT: Final = "cp1252"
MARKS: Final = {b"\xef\xbb\xbf": "utf-8-sig", b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
HEAD_BYTES: Final = 2**17
"""[bytes] of a file from which its encoding is found."""


def encoding_of(head: bytes, *, is_cut: bool = False) -> str:
    """Return the encoding of a text that begins with ``head``; ``is_cut``: the text goes on behind it."""
    for mark, encoding in MARKS.items():
        if head.startswith(mark):
            return encoding
    for start, encoding in ((1, "utf-16-le"), (0, "utf-16-be")):
        if len(head) >= 4 and not any(head[start:200:2]) and all(head[1 - start : 200 : 2]):
            return encoding
    try:
        head.decode()
    except UnicodeDecodeError as error:
        at_end = is_cut and error.end == len(head)
        return "utf-8-sig" if at_end or b"\0" in head else EIGHT_BIT
    return "utf-8-sig"


def decoded(content: bytes) -> str:
    """Return the text of a whole file, with lines that end with a line feed."""
    text = content.decode(encoding_of(content), errors="replace")
    return text.replace("\r\n", "\n")
