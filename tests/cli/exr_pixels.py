"""Channels of a small EXR file as Etendue writes them: single part, scan lines, ZIP, float32 and uint32. Written from the
file layout that OpenEXR documents, so that tests need no library for it."""

import struct
import zlib


def _text(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def _restore(packed, size):
    """Undoes ZIP, differences and the halves of OpenEXR's ZIP compression."""
    if len(packed) == size:
        return packed
    data = bytearray(zlib.decompress(packed))
    assert len(data) == size
    for i in range(1, size):
        data[i] = (data[i - 1] + data[i] - 128) & 0xFF
    out = bytearray(size)
    half = (size + 1) // 2
    out[0::2] = data[:half]
    out[1::2] = data[half:]
    return bytes(out)


def read_exr(path):
    """Returns (width, height, {name: list of width·height numbers}, {attribute: bytes})."""
    with open(path, "rb") as file:
        data = file.read()
    assert struct.unpack_from("<II", data) == (20000630, 2), "no plain EXR file"
    at, attributes = 8, {}
    while data[at]:
        name, at = _text(data, at)
        _, at = _text(data, at)
        (size,) = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    at += 1
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    names, types, place = [], [], 0
    while attributes["channels"][place]:
        name, place = _text(attributes["channels"], place)
        names.append(name)
        types.append(struct.unpack_from("<i", attributes["channels"], place)[0])
        place += 16
    assert attributes["compression"][0] == 3 and all(kind in (0, 2) for kind in types)
    values = {name: [0.0] * (width * height) for name in names}
    for (offset,) in struct.iter_unpack("<Q", data[at:at + 8 * ((height + 15) // 16)]):
        y, size = struct.unpack_from("<ii", data, offset)
        rows = min(16, y1 + 1 - y)
        block = _restore(data[offset + 8:offset + 8 + size], rows * width * 4 * len(names))
        place = 0
        for row in range(y - y0, y - y0 + rows):
            for name, kind in zip(names, types):
                line = struct.unpack_from("<%d%s" % (width, "f" if kind == 2 else "I"), block, place)
                values[name][row * width:(row + 1) * width] = line
                place += 4 * width
    return width, height, values, attributes
