"""EXR files as other programs write them: several parts, windows, half, float and uint pixels."""

import struct


def constant(width, height, value):
    return [[value] * width for _ in range(height)]


class Part:
    """channels: {name: rows of numbers}, as many as the data window has pixels. Windows are (left,
    top, right, bottom), both ends inside; without them the channels' size at (0, 0)."""

    def __init__(self, channels, data=None, display=None, kind="float", name=""):
        rows = next(iter(channels.values()))
        whole = (0, 0, len(rows[0]) - 1, len(rows) - 1)
        self.channels, self.name, self.kind = dict(sorted(channels.items())), name, kind
        self.data = data or whole
        self.display = display or self.data


PIXELS = {"uint": (0, "I"), "half": (1, "e"), "float": (2, "f")}


def attribute(name, kind, value):
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value


def header(part, several):
    code = PIXELS[part.kind][0]
    channels = b"".join(name.encode() + b"\0" + struct.pack("<iB3xii", code, 0, 1, 1)
                        for name in part.channels) + b"\0"
    text = attribute("channels", "chlist", channels)
    text += attribute("compression", "compression", b"\0")
    text += attribute("dataWindow", "box2i", struct.pack("<4i", *part.data))
    text += attribute("displayWindow", "box2i", struct.pack("<4i", *part.display))
    text += attribute("lineOrder", "lineOrder", b"\0")
    text += attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    text += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0))
    text += attribute("screenWindowWidth", "float", struct.pack("<f", 1))
    if several:
        lines = part.data[3] - part.data[1] + 1
        text += attribute("name", "string", part.name.encode())
        text += attribute("type", "string", b"scanlineimage")
        text += attribute("chunkCount", "int", struct.pack("<i", lines))
    return text + b"\0"


def exr_bytes(*parts):
    """The parts, uncompressed."""
    several = len(parts) > 1
    start = struct.pack("<II", 20000630, 2 | (0x1000 if several else 0))
    start += b"".join(header(p, several) for p in parts) + (b"\0" if several else b"")
    chunks, counts = [], []
    for k, part in enumerate(parts):
        code = PIXELS[part.kind][1]
        rows = list(zip(*part.channels.values()))
        counts.append(len(rows))
        for y, row in enumerate(rows):
            pixels = b"".join(struct.pack(f"<{len(values)}{code}", *values) for values in row)
            chunks.append((struct.pack("<i", k) if several else b"") +
                          struct.pack("<ii", part.data[1] + y, len(pixels)) + pixels)
    at = len(start) + 8 * len(chunks)
    table = b""
    for chunk in chunks:
        table += struct.pack("<Q", at)
        at += len(chunk)
    return start + table + b"".join(chunks)


def header_only(data):
    """A file of one channel that promises a data window and has no pixels."""
    part = Part({"R": [[0]], "G": [[0]], "B": [[0]]}, data=data, display=data)
    return struct.pack("<II", 20000630, 2) + header(part, False)


def grey(rows):
    return {"R": rows, "G": rows, "B": rows}
