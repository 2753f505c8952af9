#!/usr/bin/env python3
"""Reads a compiled map (.slmap) with Python's standard library alone.

Written from schemas/map_format.md and schemas/map.fbs alone, so it is also a second opinion on what the
compiler wrote. What is packed is read where the module `zstandard` is installed: Python 3.11 has no zstd.

    sightline_map.py MAP                      what the map is
    sightline_map.py MAP X_M Y_M Z_M [LIMIT_M [LOCALIZER]]
                                              how far to look there (limit 0.10 m, localizer
                                              "searching" unless given)
    sightline_map.py MAP --check              every digest that needs no unpacking
"""

import hashlib
import math
import mmap
import struct
import sys
from typing import NamedTuple

try:
    import zstandard
except ImportError:
    zstandard = None

UNMET, EXTRAPOLATED, FAR, TIGHTER_LIMIT, STATIC, UNKNOWN_LOCALIZER, NOT_VISIBLE = 1, 2, 4, 8, 16, 32, 64
SIMULATED = 128  # no scan was ever seen here: what simulation found of the place decided
KNOWN_BLOCKS = {("ndt", 1), ("range", 2)}
REASONS = ("none", "model", "most-probable", "extrapolated", "dilation", "simulation", "no-drive", "too-short",
           "explains-nothing", "cheaper", "drives", "tighter-limit")
LOOK_UP = 1  # compatible feature bit 0
PAGE = 4096
LEVEL_M = 1.0  # a site at another height is on another level
MASK = (1 << 64) - 1


class MapError(Exception):
    """What is wrong with a file, with the stable name of the error."""

    def __init__(self, name, message):
        super().__init__(f"{name}: {message}")
        self.name = name


def demand(condition, name, message):
    if not condition:
        raise MapError(name, message)


# --- XXH3, 64 bits; of 17 to 128 bytes and of more than 240, which is all that a reader needs ------

SECRET = bytes.fromhex(
    "b8fe6c3923a44bbe7c01812cf721ad1cded46de9839097db7240a4a4b7b3671fcb79e64eccc0e578825ad07dccff7221"
    "b8084674f743248ee03590e6813a264c3c2852bb91c300cb88d0658b1b532ea371644897a20df94e3819ef46a9deacd8"
    "a8fa763fe39c343ff9dcbbc7c70b4f1d8a51e04bcdb45931c89f7ec9d9787364eac5ac8334d3ebc3c581a0fffa1363eb"
    "170ddd51b7f0da49d316552629d4689e2b16be587d47a1fc8ff8b8d17ad031ce45cb3a8f95160428afd7fbcabb4b407e")
P32 = (0x9E3779B1, 0x85EBCA77, 0xC2B2AE3D)
P64 = (0x9E3779B185EBCA87, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 0x85EBCA77C2B2AE63,
       0x27D4EB2F165667C5)


def u64(data, offset):
    return struct.unpack_from("<Q", data, offset)[0]


def folded(a, b):
    product = a * b
    return (product & MASK) ^ (product >> 64)


def avalanche(h):
    h = (h ^ (h >> 37)) * 0x165667919E3779F9 & MASK
    return h ^ (h >> 32)


def mix_16(data, offset, secret, seed):
    return folded(u64(data, offset) ^ (u64(SECRET, secret) + seed & MASK),
                  u64(data, offset + 8) ^ (u64(SECRET, secret + 8) - seed & MASK))


def xxh3_short(data, seed):
    size = len(data)
    acc = size * P64[0]
    for i in reversed(range((size - 1) // 32 + 1)):  # pairs from the middle outwards
        acc += mix_16(data, 16 * i, 32 * i, seed) + mix_16(data, size - 16 * (i + 1), 32 * i + 16, seed)
    return avalanche(acc & MASK)


def xxh3_long(data, seed):
    size = len(data)
    secret = b"".join(struct.pack("<QQ", u64(SECRET, 16 * i) + seed & MASK,
                                  u64(SECRET, 16 * i + 8) - seed & MASK) for i in range(12))
    acc = [P32[2], P64[0], P64[1], P64[2], P64[3], P32[1], P64[4], P32[0]]

    def accumulate(stripe, key_offset):
        values = struct.unpack_from("<8Q", data, stripe)
        keys = struct.unpack_from("<8Q", secret, key_offset)
        for i in range(8):
            key = values[i] ^ keys[i]
            acc[i ^ 1] = acc[i ^ 1] + values[i] & MASK
            acc[i] = acc[i] + (key & 0xFFFFFFFF) * (key >> 32) & MASK

    last_keys = struct.unpack_from("<8Q", secret, 128)
    stripes = (size - 1) // 64
    for stripe in range(stripes):
        accumulate(64 * stripe, 8 * (stripe % 16))
        if stripe % 16 == 15:  # the end of a block
            acc[:] = [((a ^ (a >> 47) ^ key) * P32[0]) & MASK for a, key in zip(acc, last_keys)]
    accumulate(size - 64, 121)
    result = size * P64[0]
    for i in range(4):
        result += folded(acc[2 * i] ^ u64(secret, 11 + 16 * i),
                         acc[2 * i + 1] ^ u64(secret, 19 + 16 * i))
    return avalanche(result & MASK)


def xxh3(data, seed=0):
    demand(16 < len(data) <= 128 or len(data) > 240, "bad-manifest", "the table is too small")
    return xxh3_short(data, seed) if len(data) <= 128 else xxh3_long(data, seed)


# --- FlatBuffers ----------------------------------------------------------------------------------


class Table:
    """A FlatBuffers table: a signed offset back to its vtable, and offsets of fields there."""

    def __init__(self, data, place):
        self.data = data
        self.place = place
        vtable = place - struct.unpack_from("<i", data, place)[0]
        size = struct.unpack_from("<H", data, vtable)[0]
        self.fields = struct.unpack_from(f"<{(size - 4) // 2}H", data, vtable + 4)

    @staticmethod
    def root(data):
        return Table(data, struct.unpack_from("<I", data, 0)[0])

    def offset(self, field):
        return self.fields[field] if field < len(self.fields) else 0

    def number(self, field, code, default=0):
        offset = self.offset(field)
        return struct.unpack_from("<" + code, self.data, self.place + offset)[0] if offset else default

    def struct(self, field, code):
        demand(self.offset(field), "bad-manifest", f"field {field} is required")
        return struct.unpack_from("<" + code, self.data, self.place + self.offset(field))

    def target(self, field):
        demand(self.offset(field), "bad-manifest", f"field {field} is required")
        place = self.place + self.offset(field)
        return place + struct.unpack_from("<I", self.data, place)[0]

    def table(self, field):
        return Table(self.data, self.target(field))

    def vector(self, field):
        start = self.target(field)
        return start + 4, struct.unpack_from("<I", self.data, start)[0]

    def string(self, field):
        start, count = self.vector(field)
        return self.data[start:start + count].decode()

    def numbers(self, field, code):
        start, count = self.vector(field)
        return struct.unpack_from(f"<{count}{code}", self.data, start)

    def tables(self, field):
        start, count = self.vector(field)
        for i in range(count):
            place = start + 4 * i
            yield Table(self.data, place + struct.unpack_from("<I", self.data, place)[0])


# --- The file -------------------------------------------------------------------------------------


class Block:
    """An entry of the directory."""

    def __init__(self, table):
        self.name = table.string(0)
        self.version = table.number(1, "I")
        self.is_required = bool(table.number(2, "B"))
        self.row_count = table.number(3, "Q")
        self.offset = table.number(4, "Q")
        self.stored_size = table.number(5, "Q")
        self.raw_size = table.number(6, "Q")
        self.codec = table.number(7, "B")
        self.raw_digest = bytes(table.struct(8, "32B"))

    def digest_parts(self):
        return [self.name.encode(), struct.pack("<I", self.version),
                struct.pack("<Q", self.row_count), self.raw_digest]


class Tile(NamedTuple):
    key: tuple
    digest: bytes
    layers: list


class Look(NamedTuple):
    """How a scan becomes the points that are matched (schemas/definitions.md, "Looks")."""

    range_m: float
    return_count: int = 0  # 0: every one
    even_beyond_m: float = 0.0
    point_count: int = 0  # 0: all that are left
    is_by_normals: bool = False
    settles: bool = False


class LookPlan(NamedTuple):
    """What a vehicle does that tracks ("Driving by a plan" there); without `second`, the first look is kept."""

    first: Look
    second: Look = None  # taken where doubt = constant + the sum of weights times signs is above doubt_above
    weights: tuple = ()
    constant: float = 0.0
    doubt_above: float = 0.0


class Answer(NamedTuple):
    range_m: float
    probability: float  # that the localization error is within the limit; NaN with UNKNOWN_LOCALIZER
    mean_error_m: float  # likewise
    distance_m: float  # to the nearest site
    flags: int
    site: int  # None far from any
    reason: int = 0  # of REASONS: why the site has this range or look; 0: no answer of a site is used


def look_from(table):
    return Look(table.number(0, "d"), table.number(1, "I"), table.number(2, "d"), table.number(3, "I"),
                table.number(4, "B") == 1, table.number(5, "B") == 1)


def digest(*parts):
    return hashlib.sha256(b"".join(struct.pack("<Q", len(p)) + p for p in parts)).digest()


def columns_of(raw, rows, layout):
    """Columns by name, each a list with one tuple a row; every column begins at a multiple of 64."""
    columns = {}
    offset = 0
    for name, code, width in layout:
        values = struct.unpack_from(f"<{rows * width}{code}", raw, offset)
        columns[name] = [values[i * width:(i + 1) * width] for i in range(rows)]
        offset = (offset + rows * width * struct.calcsize("<" + code) + 63) // 64 * 64
    demand(offset == len(raw), "bad-layer", "the size of the layer does not match its rows")
    return columns


# --- What is packed -------------------------------------------------------------------------------

NONE, ZSTD, NDS, COLUMNS = range(4)  # codecs
QUARTERS = (1.0, 1.189207115002721, 1.4142135623730951, 1.681792830507429)  # 2^(i/4)
ORDERS = ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0))
ENTRY = ((0, 1, 2), (1, 3, 4), (2, 4, 5))  # of a symmetric matrix in xx, xy, xz, yy, yz, zz


def is_readable(block):
    return block.codec == NONE or zstandard is not None


def unpacked_frame(frame):
    demand(zstandard is not None, "bad-layer", "a block is packed, and the module zstandard is not installed")
    return zstandard.ZstdDecompressor().decompress(frame)


def from_planes(planes, rows, per_row, width):
    """The array whose differences from row to row these are, byte by byte of each number of a row."""
    array = bytearray(rows * per_row * width)
    modulus = 1 << (8 * width)
    for number in range(per_row):
        value, begin = 0, number * width * rows
        for row in range(rows):
            value += sum(planes[begin + i * rows + row] << (8 * i) for i in range(width))
            value %= modulus
            place = (row * per_row + number) * width
            array[place:place + width] = value.to_bytes(width, "little")
    return bytes(array)


def padded(column):
    return column + bytes(-len(column) % 64)


def raw_of_columns(packed, rows):
    count = struct.unpack_from("<I", packed)[0]
    raw, place = b"", 4 + 8 * count
    for i in range(count):
        per_row, width = struct.unpack_from("<II", packed, 4 + 8 * i)
        size = rows * per_row * width
        raw += padded(from_planes(packed[place:place + size], rows, per_row, width))
        place += size
    demand(place == len(packed), "bad-layer", "the columns do not fill the frame")
    return raw


def small_nd(half_step, numbers):
    """(point count, mean in units of the layer, covariance) of eleven numbers of a byte."""
    c, *means, order, d0, d1, d2, l10, l20, l21 = (n - 256 if i > 4 and n > 127 else n for i, n in enumerate(numbers))
    d0, d1, d2 = (math.ldexp(QUARTERS[d & 3], d >> 2) for d in (d0, d1, d2))
    l10, l20, l21 = l10 / 127, l20 / 127, l21 / 127
    a, b, c_axis = ORDERS[order]
    covariance = [0.0] * 6
    for (i, j), value in {(a, a): d0, (a, b): l10 * d0, (a, c_axis): l20 * d0, (b, b): l10 * l10 * d0 + d1,
                          (b, c_axis): l20 * l10 * d0 + l21 * d1,
                          (c_axis, c_axis): l20 * l20 * d0 + l21 * l21 * d1 + d2}.items():
        covariance[ENTRY[i][j]] = value
    c = min(c, 123)
    count = c if c < 8 else (4 + c % 4) << (c // 4 - 1)
    return count, [(2 * m - 255) * half_step for m in means], covariance


def raw_of_nds(packed, rows):
    half_step = struct.unpack_from("<i", packed)[0]
    keys = [from_planes(packed[4 + 4 * rows * axis:4 + 4 * rows * (axis + 1)], rows, 1, 4) for axis in range(3)]
    begin = 4 + 12 * rows
    demand(len(packed) == begin + 11 * rows, "bad-layer", "the NDs do not fill the frame")
    nds = [small_nd(half_step, [packed[begin + i * rows + row] for i in range(11)]) for row in range(rows)]
    columns = [*keys, struct.pack(f"<{rows}I", *(nd[0] for nd in nds))]
    columns += [struct.pack(f"<{rows}i", *(nd[1][axis] for nd in nds)) for axis in range(3)]
    columns += [struct.pack(f"<{rows}f", *(nd[2][entry] for nd in nds)) for entry in range(6)]
    return b"".join(padded(column) for column in columns)


class SightlineMap:
    """A map for a vehicle that localizes with `localizer` ("searching", or "searching/3" for that version
    of its definition alone). Probabilities are unknown for one whose errors were not measured."""

    def __init__(self, path, localizer=""):
        with open(path, "rb") as file:
            self.data = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        self._read_header()
        manifest_bytes = self._checked(self.manifest_place, "manifest")
        self.manifest = manifest = Table.root(manifest_bytes)
        self.manifest_digest = hashlib.sha256(manifest_bytes).digest()
        self.map_id, self.version = manifest.string(0), manifest.string(1)
        self.release, self.writer = manifest.number(2, "Q"), manifest.string(3)
        self.origin_world_m = manifest.struct(4, "3d")
        self.is_small = manifest.number(35, "B") == 1
        self.world = manifest.string(32) if manifest.offset(32) else "local"
        # Of exported clouds: a vehicle that localizes in one asks at its position plus this.
        self.export_origin_world_m = tuple(
            math.floor(o / 1e5) * 1e5 if abs(o) >= 1e5 else 0.0 for o in self.origin_world_m[:2]) + (0.0,)
        self.cell_m, self.tile_m = manifest.number(5, "d"), manifest.number(6, "d")
        self.reach_m = manifest.number(8, "d")
        self.nd_count, self.site_count = manifest.number(9, "Q"), manifest.number(13, "I")
        self.ranges_m = manifest.numbers(14, "d")
        self.looks = [look_from(each) for each in (manifest.tables(27) if manifest.offset(27) else ())]
        self._read_plan()
        self.promises = [self._promise(table) for table in manifest.tables(17)]
        self.limits_m = [promise["limit_m"] for promise in self.promises]
        profile = manifest.table(22).table(4)
        self.localizer, self.localizer_version = profile.string(0), profile.number(1, "I")
        self.localizer_parameters = {fact.string(0): fact.string(1) for fact in profile.tables(2)}
        self.is_for_caller = localizer != "" and localizer in (
            self.localizer, f"{self.localizer}/{self.localizer_version}")
        self._directory = self._tracking = None
        demand(self.compatible & LOOK_UP, "bad-layer", "the section look-up is missing")
        self._look_up = LookUp(self)

    def _read_plan(self):
        self.plan, self.plan_limit_m = None, math.inf
        if self.manifest.offset(30):
            table = self.manifest.table(30)
            self.plan_limit_m = table.number(0, "d")
            self.plan = LookPlan(look_from(table.table(1)), look_from(table.table(5)),
                                 tuple(table.numbers(2, "d")), table.number(3, "d"), table.number(4, "d"))

    def _read_header(self):
        data = self.data
        demand(data[:8] == b"\x89SLM\r\n\x1a\n", "bad-magic", "the file is not a compiled map")
        demand(len(data) >= 160, "truncated-file", "the file is too short for header and trailer")
        demand(xxh3(data[:120]) == u64(data, 120), "checksum-mismatch", "header")
        self.major, self.minor = struct.unpack_from("<HH", data, 8)
        (self.compatible, incompatible, file_size, m_offset, m_size, m_sum, d_offset, d_size,
         d_sum) = struct.unpack_from("<9Q", data, 16)
        demand(file_size <= len(data), "truncated-file", f"{len(data)} bytes of {file_size}")
        demand(file_size == len(data), "out-of-bounds", f"{len(data)} bytes of {file_size}")
        trailer = struct.pack("<3Q", file_size, u64(data, 120), 0) + data[:8][::-1]
        demand(data[-32:] == trailer, "checksum-mismatch", "trailer")
        demand(self.major == 1, "future-version" if self.major > 1 else "old-version",
               f"format {self.major}.{self.minor}, this program reads 1.0. Compile again, or use that version")
        demand(incompatible == 0, "unknown-required-feature", f"bits {incompatible:x}")
        self.manifest_place = (m_offset, m_size, m_sum)
        self.directory_place = (d_offset, d_size, d_sum)
        self.root_digest = data[88:120]

    @staticmethod
    def _promise(table):
        """A promise is about the next drive: coverage is 0 without one."""
        is_of_next_drive = table.number(12, "B") == 1
        is_earned = table.number(5, "B") == 1 and is_of_next_drive
        return {"limit_m": table.number(0, "d"), "is_earned": is_earned,
                "coverage": 1.0 - table.number(2, "d") if is_earned else 0.0,
                "is_of_next_drive": is_of_next_drive, "place_count": table.number(10, "I"),
                "drive_count": table.number(11, "I"), "statement": table.string(8)}

    def _checked(self, place, what):
        offset, size, checksum = place
        demand(offset % 64 == 0 and 128 <= offset <= len(self.data) - 32 - size, "out-of-bounds", what)
        content = self.data[offset:offset + size]
        demand(xxh3(content) == checksum, "checksum-mismatch", what)
        return content

    @property
    def directory(self):
        if self._directory is None:
            self._directory = Table.root(self._checked(self.directory_place, "directory"))
        return self._directory

    def tiles(self):
        for tile in self.directory.tables(1):
            layers = [Block(table) for table in tile.tables(3)]
            for layer in layers:
                self._check_known(layer)
            yield Tile((tile.number(0, "i"), tile.number(1, "i")), bytes(tile.struct(2, "32B")), layers)

    def sections(self):
        return [self._check_known(Block(table)) for table in self.directory.tables(2)]

    @staticmethod
    def _check_known(block):
        known = (block.name, block.version) in KNOWN_BLOCKS
        demand(known or not block.is_required, "unknown-required-feature",
               f"block {block.name} of version {block.version}")
        return block

    def raw(self, block):
        """The bytes of a block as they were before it was packed, after their digest."""
        demand(block.offset % 64 == 0 and block.offset + block.stored_size <= self.directory_place[0],
               "out-of-bounds", block.name)
        raw = self.data[block.offset:block.offset + block.stored_size]
        if block.codec != NONE:
            demand(block.codec <= COLUMNS, "unknown-required-feature", f"codec {block.codec} of {block.name}")
            raw = unpacked_frame(raw)
        if block.codec == NDS:
            raw = raw_of_nds(raw, block.row_count)
        if block.codec == COLUMNS:
            raw = raw_of_columns(raw, block.row_count)
        demand(hashlib.sha256(raw).digest() == block.raw_digest, "digest-mismatch", block.name)
        return raw

    def sites(self):
        """The answers of the range layers by site id, as dictionaries of tuples."""
        ranges, limits, looks = len(self.ranges_m), len(self.limits_m), len(self.looks)
        layout = [("site", "I", 1), ("run", "I", 1), ("s_m", "d", 1), ("p_x_m", "d", 1),
                  ("p_y_m", "d", 1), ("p_z_m", "d", 1), ("range_index", "B", limits),
                  ("range_flags", "B", limits), ("mean_error_m", "d", ranges),
                  ("probability", "d", ranges * limits), ("site_flags", "B", 1), ("extrapolated", "B", ranges),
                  ("pose", "d", 12), ("look_index", "B", limits if looks else 0),
                  ("look_flags", "B", limits if looks else 0), ("look_mean_error_m", "d", looks),
                  ("look_probability", "d", looks * limits), ("look_extrapolated", "B", looks),
                  ("range_reason", "B", limits), ("look_reason", "B", limits if looks else 0)]
        sites = {}
        for tile in self.tiles():
            for layer in tile.layers:
                if layer.name != "range":
                    continue
                columns = columns_of(self.raw(layer), layer.row_count, layout)
                for row in range(layer.row_count):
                    site = {name: values[row] for name, values in columns.items()}
                    place = (site["p_x_m"][0], site["p_y_m"][0])
                    demand(tuple(math.floor(p / self.tile_m) for p in place) == tile.key, "bad-order",
                           "a site is in another tile")
                    sites[site["site"][0]] = site
        demand(sorted(sites) == list(range(self.site_count)), "bad-order", "sites are missing")
        return sites

    def nds(self):
        """(key, point count, mean in m, covariance in m^2) of each ND that can be unpacked."""
        names = [("key", "i")] * 3 + [("count", "I")] + [("mean", "i")] * 3 + [("covariance", "f")] * 6
        layout = [(f"{name}{i}", code, 1) for i, (name, code) in enumerate(names)]
        for tile in self.tiles():
            for layer in tile.layers:
                if layer.name != "ndt" or not is_readable(layer):
                    continue
                columns = list(columns_of(self.raw(layer), layer.row_count, layout).values())
                for row in range(layer.row_count):
                    values = [column[row][0] for column in columns]
                    mean_m = [(key + 0.5) * self.cell_m + units * 2.0**-24
                              for key, units in zip(values[:3], values[4:7])]
                    yield tuple(values[:3]), values[3], mean_m, values[7:]

    def check(self):
        """Digests of tiles, of the map and of all that can be unpacked; how many blocks could not."""
        tile_digests = []
        packed = 0
        keys = []
        for tile in self.tiles():
            for layer in tile.layers:
                packed += not is_readable(layer)
                if is_readable(layer):
                    self.raw(layer)
            parts = [part for layer in tile.layers if layer.is_required for part in layer.digest_parts()]
            keys.append(tile.key)
            tile_digests.append(digest(b"sightline tile", struct.pack("<2i", *tile.key), *parts))
            demand(tile_digests[-1] == tile.digest, "digest-mismatch", f"tile {tile.key}")
        demand(all(a < b for a, b in zip(keys, keys[1:])), "bad-order", "tiles")
        for section in self.sections():
            packed += not is_readable(section)
            if is_readable(section):
                self.raw(section)
        root = digest(b"sightline map", self.manifest_digest, struct.pack("<Q", 0),
                      struct.pack("<Q", len(tile_digests)), *tile_digests)
        demand(root == self.root_digest, "digest-mismatch", "the map")
        if zstandard is not None or not self.is_small:
            self.sites()
        return packed

    def observation_range(self, position_world_m, limit_m):
        p_m = [a - b for a, b in zip(position_world_m, self.origin_world_m)]
        demand(all(math.isfinite(p) for p in p_m) and 0 < limit_m < math.inf, "bad-argument",
               "a position must be finite, and a limit finite and above 0")
        limit = sum(each <= limit_m for each in self.limits_m) - 1
        flags = TIGHTER_LIMIT if limit < 0 else 0
        row = self._look_up.nearest(p_m)
        if not self.is_for_caller:
            distance_m, site = row[:2] if row else (math.inf, None)
            flags |= UNKNOWN_LOCALIZER | (0 if row else FAR)
            return Answer(self.ranges_m[-1], math.nan, math.nan, distance_m, flags, site)
        if row is None:
            return Answer(self.ranges_m[-1], 0.0, math.inf, math.inf, flags | FAR, None)
        distance_m, site, longest_error_m, choices, _ = row
        if limit < 0:
            return Answer(self.ranges_m[-1], 0.0, longest_error_m, distance_m, flags, site)
        index, site_flags, probability, mean_error_m, reason = choices[limit]
        demand(index < len(self.ranges_m), "bad-layer", f"site {site}")
        return Answer(self.ranges_m[index], probability, mean_error_m, distance_m,
                      flags | site_flags, site, reason)

    def look(self, position_world_m, limit_m, visible_m=math.inf):
        """(Look, Answer): the cheapest look for a sensor that now sees visible_m far, and its numbers."""
        demand(visible_m > 0, "bad-argument", "the visible distance must be above 0 m")
        answer = self.observation_range(position_world_m, limit_m)
        p_m = [a - b for a, b in zip(position_world_m, self.origin_world_m)]
        limit = sum(each <= limit_m for each in self.limits_m) - 1
        row = self._look_up.nearest(p_m) if self.looks and self.is_for_caller and limit >= 0 else None
        if row:
            index, site_flags, probability, mean_error_m, reason = row[4][limit]
            demand(index < len(self.looks), "bad-layer", f"site {row[1]}")
            look = self.looks[index]
            if look.range_m <= visible_m:
                return look, Answer(look.range_m, probability, mean_error_m, row[0], site_flags, row[1],
                                    reason)
        if answer.range_m <= visible_m:
            return Look(answer.range_m), answer
        probability = 0.0 if self.is_for_caller else math.nan
        answer = answer._replace(range_m=self.ranges_m[-1], probability=probability,
                                 flags=answer.flags | NOT_VISIBLE, reason=0)
        return Look(answer.range_m), answer

    def tracking_looks(self):
        """[limit]: (number of the look, probability) of each site for tracking starts; [] where the map has none."""
        if self._tracking is not None:
            return self._tracking
        steps = {table.string(0): table.numbers(3, "f") for table in
                 (self.manifest.tables(33) if self.manifest.offset(33) else ()) if table.offset(3)}
        sections = {block.name: block for block in self.sections()} if "tracking_look_0" in steps else {}
        columns = []
        for limit in range(len(self.limits_m)):
            names = [f"tracking_look_{limit}", f"tracking_probability_{limit}"]
            if names[0] not in steps:
                columns = []
                break
            raw = [self.raw(sections["column." + name]) for name in names]
            demand(all(len(each) == self.site_count for each in raw), "bad-layer", names[0])
            columns.append([tuple(steps[name][each[site]] for name, each in zip(names, raw))
                            for site in range(self.site_count)])
        self._tracking = columns
        return columns

    def _tracking_look(self, look, answer, limit_m, visible_m):
        """The answer for tracking starts instead of that for acquiring starts, where there is one."""
        limit = sum(each <= limit_m for each in self.limits_m) - 1
        if limit < 0 or answer.flags & (FAR | TIGHTER_LIMIT | UNKNOWN_LOCALIZER) or not self.tracking_looks():
            return look, answer
        number, probability = self.tracking_looks()[limit][answer.site]
        index = int(number if number >= 0 else -1 - number)
        demand(index < len(self.looks), "bad-layer", f"site {answer.site}")
        if self.looks[index].range_m > visible_m:
            return look, answer
        flags = answer.flags & ~UNMET | (UNMET if number < 0 else 0)
        return self.looks[index], answer._replace(range_m=self.looks[index].range_m, probability=probability,
                                                  mean_error_m=math.nan, flags=flags)

    def look_plan(self, position_world_m, limit_m, is_tracking, visible_m=math.inf):
        """(LookPlan, Answer): what to do there; each number is None where a second look may follow."""
        look, answer = self.look(position_world_m, limit_m, visible_m)
        tracking = self._tracking_look(look, answer, limit_m, visible_m) if is_tracking else (look, answer)
        plan = self.plan
        by_plan = (is_tracking and plan and limit_m >= self.plan_limit_m and
                   not answer.flags & (FAR | TIGHTER_LIMIT | UNKNOWN_LOCALIZER) and
                   max(plan.first.range_m, plan.second.range_m) <= visible_m)
        if not by_plan:
            return LookPlan(tracking[0]), tracking[1]
        is_cheaper = (0 < look.return_count <= plan.first.return_count and
                      0 < look.point_count < plan.first.point_count)
        first = (look if is_cheaper else plan.first)._replace(settles=True)
        return plan._replace(first=first), answer._replace(probability=None, mean_error_m=None,
                                                             flags=tracking[1].flags)


class LookUp:
    """The section "look-up": pages of slots, pages of rows, the info page right before the directory."""

    def __init__(self, owner):
        self.map = owner
        self.limits = len(owner.limits_m)
        self.seed = u64(owner.root_digest, 0)
        end = owner.directory_place[0]
        info = owner.data[end - PAGE:end]
        demand(info[:8] == b"\x89SLU\r\n\x1a\n", "bad-layer", "look-up")
        (version, page_size, pages, self.cell_m, self.slots, self.rows, limits,
         text_size, looks, is_small) = struct.unpack_from("<IIQdQQIIII", info, 8)
        demand(version == 2 and page_size == PAGE, "unknown-required-feature", "look-up")
        self.begin = end - PAGE * pages
        self.checked = set()
        self.page(pages - 1)
        for line in info[64:64 + text_size].decode().splitlines():
            name, number = line.split(" ")
            demand((name, int(number)) in KNOWN_BLOCKS, "unknown-required-feature", "block " + line)
        self.look_limits = self.limits if looks else 0
        self.is_small = is_small == 1
        answers = self.limits + self.look_limits
        self.row_size = -(-(20 + 7 * answers) // 4) * 4 if self.is_small else -(-(40 + 19 * answers) // 8) * 8
        self.rows_per_page = 4080 // self.row_size
        self.slot_pages = -(-self.slots // 255)
        demand(limits == self.limits and looks == len(owner.looks) and self.rows == owner.site_count and
               self.is_small == owner.is_small and
               pages == self.slot_pages - (-self.rows // self.rows_per_page) + 1, "bad-layer",
               "look-up")

    def page(self, number):
        page = self.map.data[self.begin + PAGE * number:self.begin + PAGE * (number + 1)]
        if number not in self.checked:
            demand(struct.unpack_from("<QQ", page, 4080) == (number, xxh3(page[:4088], self.seed)),
                   "checksum-mismatch", f"page {number} of look-up")
            self.checked.add(number)
        return page

    def cell(self, x, y):
        """First row and number of rows of a cell."""
        key = ((x & 0xFFFFFFFF) << 32) + (y & 0xFFFFFFFF)
        slot = ((key * 0x9E3779B97F4A7C15 & MASK) >> 32) * self.slots >> 32
        for _ in range(self.slots):
            slot_x, slot_y, first, count = struct.unpack_from("<iiII", self.page(slot // 255),
                                                              slot % 255 * 16)
            if count == 0 or (slot_x, slot_y) == (x, y):
                return first, count
            slot = (slot + 1) % self.slots
        return 0, 0

    def site_at(self, page, place):
        """Number and position of the site of a row."""
        if not self.is_small:
            return struct.unpack_from("<I", page, place + 32)[0], struct.unpack_from("<3d", page, place)
        x, y, z, site = struct.unpack_from("<3i4xI", page, place)
        return site, (x / 1024, y / 1024, z / 1024)

    def row_values(self, page, place):
        n, m = self.limits, self.look_limits
        code = "H" if self.is_small else "d"
        head, start = ("<H6x", 12) if self.is_small else ("<d8x", 24)
        answers = f"{n}{code}{n}{code}{m}{code}{m}{code}{n}B{n}B{m}B{m}B{n}B{m}B"
        values = struct.unpack_from(head + answers, page, place + start)
        if not self.is_small:
            return values
        units = [1 / 1024] + [1 / 256] * n + [1 / 1024] * n + [1 / 256] * m + [1 / 1024] * m
        return [value * unit for value, unit in zip(values, units)] + list(values[len(units):])

    def nearest(self, p_m):
        best = None
        low = [math.floor((p - self.map.reach_m) / self.cell_m) for p in p_m[:2]]
        high = [math.floor((p + self.map.reach_m) / self.cell_m) for p in p_m[:2]]
        for x in range(low[0], high[0] + 1):
            for y in range(low[1], high[1] + 1):
                first, count = self.cell(x, y)
                demand(first + count <= self.rows, "bad-layer", "look-up")
                for row in range(first, first + count):
                    page = self.page(self.slot_pages + row // self.rows_per_page)
                    place = row % self.rows_per_page * self.row_size
                    site, site_m = self.site_at(page, place)
                    distance_m = math.dist(p_m, site_m)
                    if abs(p_m[2] - site_m[2]) >= LEVEL_M or distance_m > self.map.reach_m:
                        continue
                    if not best or (distance_m, site) < best[:2]:
                        best = (distance_m, site, page, place)
        if best is None:
            return None
        distance_m, site, page, place = best
        n, m = self.limits, self.look_limits
        values = self.row_values(page, place)
        index = 1 + 2 * n + 2 * m
        reason = index + 2 * n + 2 * m
        choices = [(values[index + i], values[index + n + i], values[1 + i], values[1 + n + i],
                    values[reason + i]) for i in range(n)]
        index += 2 * n
        looks = [(values[index + i], values[index + m + i], values[1 + 2 * n + i],
                  values[1 + 2 * n + m + i], values[reason + n + i]) for i in range(m)]
        return distance_m, site, values[0], choices, looks


def main(arguments):
    if not arguments or len(arguments) not in (1, 2, 4, 5, 6):
        print(__doc__, file=sys.stderr)
        return 64
    try:
        opened = SightlineMap(arguments[0], arguments[5] if len(arguments) == 6 else "searching")
        if arguments[1:] == ["--check"]:
            packed = opened.check()
            print(f"every digest holds; {packed} blocks are packed and were not unpacked")
        elif len(arguments) >= 4:
            limit_m = float(arguments[4]) if len(arguments) >= 5 else 0.10
            print(opened.observation_range([float(text) for text in arguments[1:4]], limit_m))
        else:
            print(f"map {opened.map_id}, version {opened.version}, release {opened.release}, format "
                  f"{opened.major}.{opened.minor}\n{opened.site_count} sites, {opened.nd_count} NDs, "
                  f"ranges {opened.ranges_m} m, limits {opened.limits_m} m\n"
                  f"errors of localizer {opened.localizer} v{opened.localizer_version} "
                  f"{opened.localizer_parameters}\n"
                  f"root digest {opened.root_digest.hex()}")
    except (MapError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
