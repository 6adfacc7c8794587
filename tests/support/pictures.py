"""Pictures in files, read and written by rules of their own: EXR and the frame of PNG."""

import array
import itertools
import pathlib
import struct
import sys
import zlib


class Exr:
    """An EXR file of ZIP or uncompressed scanlines with 32-bit channels: windows, attributes and pixels."""

    def __init__(self, path):
        self.bytes = pathlib.Path(path).read_bytes()
        magic, version = struct.unpack_from("<II", self.bytes)
        if magic != 20000630 or version & 0xFF != 2:
            raise ValueError(f"{path} is not an EXR file")
        at = 8
        self.attributes = {}
        while self.bytes[at] != 0:
            name, at = self._text(at)
            _, at = self._text(at)
            (size,) = struct.unpack_from("<I", self.bytes, at)
            self.attributes[name] = self.bytes[at + 4 : at + 4 + size]
            at += 4 + size
        self.data = struct.unpack("<4i", self.attributes["dataWindow"])  # first and last column and row
        self.display = struct.unpack("<4i", self.attributes["displayWindow"])
        self.width = self.data[2] - self.data[0] + 1
        self.height = self.data[3] - self.data[1] + 1
        self.rows = {}  # by y: three arrays of floats, for R, G, B
        self._read_blocks(at + 1)

    def _text(self, at):
        end = self.bytes.index(b"\0", at)
        return self.bytes[at:end].decode(), end + 1

    def _read_blocks(self, table):
        compression = self.attributes["compression"][0]
        lines = {0: 1, 2: 1, 3: 16}[compression]  # of a block, for no compression, ZIPS and ZIP
        blocks = (self.height + lines - 1) // lines
        for offset in struct.unpack_from(f"<{blocks}Q", self.bytes, table):
            y, size = struct.unpack_from("<ii", self.bytes, offset)
            packed = self.bytes[offset + 8 : offset + 8 + size]
            count = min(lines, self.data[3] + 1 - y)
            raw_size = count * 3 * 4 * self.width
            self._read_lines(y, count, packed if size == raw_size else unzip(packed))
        if len(self.rows) != self.height:
            raise ValueError("rows are missing")

    def _read_lines(self, y, count, raw):
        # A line holds its channels one after the other, in the order of their names: B, G, R.
        floats = array.array("f", raw)
        if sys.byteorder == "big":
            floats.byteswap()
        for line in range(count):
            start = line * 3 * self.width
            b, g, r = (floats[start + c * self.width : start + (c + 1) * self.width] for c in range(3))
            self.rows[y + line] = (r, g, b)

    def pixel(self, x, y):
        return tuple(channel[x - self.data[0]] for channel in self.rows[y])

    def values(self):
        """All values in a fixed order; equal pictures have equal values."""
        return [value for y in sorted(self.rows) for channel in self.rows[y] for value in channel]

    def bits(self):
        return b"".join(channel.tobytes() for y in sorted(self.rows) for channel in self.rows[y])

    def part(self, x0, y0, x1, y1):
        """The bits of a part of the picture."""
        left = self.data[0]
        return b"".join(c[x0 - left : x1 - left].tobytes() for y in range(y0, y1) for c in self.rows[y])


def unzip(packed):
    """Undoes OpenEXR's ZIP: deflate, then differences of neighbours, then even and odd bytes apart."""
    differences = zlib.decompress(packed)
    data = bytes(itertools.accumulate(differences, lambda last, d: (last + d - 128) & 0xFF))
    half = (len(data) + 1) // 2
    raw = bytearray(len(data))
    raw[0::2] = data[:half]
    raw[1::2] = data[half:]
    return bytes(raw)


def write_exr(path, width, height, pixels, names="BGR", chromaticities=None, aspect=1):
    """An uncompressed EXR; `pixels` are (r, g, b), row by row. `names` are those of b, g and r, in alphabetical order."""

    def attribute(name, kind, value):
        return f"{name}\0{kind}\0".encode() + struct.pack("<I", len(value)) + value

    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    channels = b"".join(name + b"\0" + struct.pack("<i4xii", 2, 1, 1) for name in map(str.encode, names)) + b"\0"
    header = struct.pack("<II", 20000630, 2)
    header += attribute("channels", "chlist", channels) + attribute("compression", "compression", b"\0")
    header += attribute("dataWindow", "box2i", window) + attribute("displayWindow", "box2i", window)
    header += attribute("lineOrder", "lineOrder", b"\0") + attribute("pixelAspectRatio", "float", struct.pack("<f", aspect))
    if chromaticities:
        header += attribute("chromaticities", "chromaticities", struct.pack("<8f", *chromaticities))
    header += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0))
    header += attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    size = 12 * width
    first = len(header) + 8 * height
    table = b"".join(struct.pack("<Q", first + y * (8 + size)) for y in range(height))
    lines = b""
    for y in range(height):
        row = pixels[y * width : (y + 1) * width]
        lines += struct.pack("<ii", y, size)
        lines += b"".join(struct.pack(f"<{width}f", *(pixel[c] for pixel in row)) for c in (2, 1, 0))
    pathlib.Path(path).write_bytes(header + table + lines)


def png_size(path):
    data = pathlib.Path(path).read_bytes()
    if data[:8] != b"\x89PNG\r\n\x1a\n" or data[-8:-4] != b"IEND":
        raise ValueError(f"{path} is not a whole PNG file")
    return struct.unpack_from(">II", data, 16)


def float32(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]
