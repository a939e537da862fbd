"""Reads and writes EXR pictures like those of Etendue (docs/image_files.md): one part, scan lines, float or uint channels."""
import struct
import zlib

import numpy as np

# Compression in the header -> scan lines in a block.
LINES_PER_BLOCK = {0: 1, 2: 1, 3: 16}
PIXEL_TYPES = {0: np.dtype("<u4"), 1: np.dtype("<f2"), 2: np.dtype("<f4")}


def _text(data, at):
    """A zero-terminated string and where the next thing begins."""
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def _header(data):
    """The attributes as raw bytes, and where the table of offsets begins."""
    if data[:4] != b"\x76\x2f\x31\x01":
        raise ValueError("not an EXR file")
    attributes, at = {}, 8
    while data[at] != 0:
        name, at = _text(data, at)
        _, at = _text(data, at)
        (size,) = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    return attributes, at + 1


def _channels(raw):
    """Names and types in the order in which the file stores them."""
    channels, at = [], 0
    while raw[at] != 0:
        name, at = _text(raw, at)
        (kind,) = struct.unpack_from("<i", raw, at)
        channels.append((name, PIXEL_TYPES[kind]))
        at += 16
    return channels


def _unzip(packed, size):
    """Undoes zlib, the differences of neighbours and the parting of odd and even bytes."""
    if len(packed) == size:
        return packed
    steps = np.frombuffer(zlib.decompress(packed), np.uint8).copy()
    steps[1:] -= 128
    halves = np.cumsum(steps, dtype=np.uint8)
    out = np.empty(size, np.uint8)
    out[0::2] = halves[:(size + 1) // 2]
    out[1::2] = halves[(size + 1) // 2:]
    return out.tobytes()


def read(path):
    """Every channel as an array [height, width] by its name."""
    with open(path, "rb") as file:
        data = file.read()
    attributes, at = _header(data)
    left, top, right, bottom = struct.unpack("<4i", attributes["dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    channels = _channels(attributes["channels"])
    compression = attributes["compression"][0]
    lines = LINES_PER_BLOCK[compression]
    blocks = -(-height // lines)
    planes = {name: np.empty((height, width), kind) for name, kind in channels}
    for offset in struct.unpack_from(f"<{blocks}Q", data, at):
        y, size = struct.unpack_from("<ii", data, offset)
        rows = min(lines, bottom - y + 1)
        raw_size = rows * width * sum(kind.itemsize for _, kind in channels)
        raw = data[offset + 8:offset + 8 + size]
        raw = raw if compression == 0 else _unzip(raw, raw_size)
        place = 0
        for row in range(y - top, y - top + rows):
            for name, kind in channels:
                planes[name][row] = np.frombuffer(raw, kind, width, place)
                place += width * kind.itemsize
    return planes


def rgb(path):
    """The picture as float64 [height, width, 3], and its standard error likewise."""
    planes = read(path)

    def stack(prefix):
        return np.stack([planes[prefix + c].astype(np.float64) for c in "RGB"], axis=-1)

    return stack(""), stack("StdErr.")


def _attribute(name, kind, value):
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value


def write(path, planes):
    """Arrays [height, width] of uint32 or float32 by the names of their channels, not compressed."""
    names = sorted(planes)  # as the format asks for
    height, width = planes[names[0]].shape
    kinds = {kind: number for number, kind in PIXEL_TYPES.items()}
    channels = b"".join(name.encode() + b"\0" + struct.pack("<iBxxxii", kinds[planes[name].dtype.newbyteorder("<")], 0, 1, 1)
                        for name in names)
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = b"\x76\x2f\x31\x01" + struct.pack("<i", 2)
    header += _attribute("channels", "chlist", channels + b"\0") + _attribute("compression", "compression", b"\0")
    header += _attribute("dataWindow", "box2i", window) + _attribute("displayWindow", "box2i", window)
    header += _attribute("lineOrder", "lineOrder", b"\0") + _attribute("pixelAspectRatio", "float", struct.pack("<f", 1.0))
    header += _attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0))
    header += _attribute("screenWindowWidth", "float", struct.pack("<f", 1.0)) + b"\0"
    size = 4 * width * len(names)
    first = len(header) + 8 * height
    with open(path, "wb") as file:
        file.write(header + struct.pack(f"<{height}Q", *(first + y * (8 + size) for y in range(height))))
        for y in range(height):
            file.write(struct.pack("<ii", y, size) + b"".join(planes[name][y].tobytes() for name in names))
