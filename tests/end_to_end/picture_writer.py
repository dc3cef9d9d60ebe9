"""Pictures for tests: PNG of 8 or 16 bits, and a JPEG."""

import base64
import struct
import zlib

# 8 x 8 pixels, grey, every one 128: libjpeg-turbo 2.1, quality 90.
GREY_JPEG = base64.b64decode(
    "/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAAMCAgMCAgMDAwMEAwMEBQgFBQQEBQoHBwYIDAoMDAsKCwsNDhIQDQ4RDg"
    "sLEBYQERMUFRUVDA8XGBYUGBIUFRT/wAALCAAIAAgBAREA/8QAFAABAAAAAAAAAAAAAAAAAAAAAP/EABQQAQAAAAAA"
    "AAAAAAAAAAAAAAD/2gAIAQEAAD8AP//Z")


def png(rows, bits=8):
    """rows: lists of pixels from the top, each a number (grey) or 2 to 4 of them, below 2^bits."""
    first = rows[0][0]
    channels = len(first) if isinstance(first, tuple) else 1
    kind = {1: 0, 2: 4, 3: 2, 4: 6}[channels]
    code = ">H" if bits == 16 else ">B"
    raw = b""
    for row in rows:
        raw += b"\0"
        for pixel in row:
            for value in pixel if isinstance(pixel, tuple) else (pixel,):
                raw += struct.pack(code, value)

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = struct.pack(">IIBBBBB", len(rows[0]), len(rows), bits, kind, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b"")
