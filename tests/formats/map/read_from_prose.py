"""A reader of map files made from schemas/map_format.md alone, with nothing but the standard library.

Reads made-up maps and compares sites, predictions and ranges with what `dump` printed of them:
    read_from_prose.py WRITE_RANDOM_MAP
"""

import hashlib
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile


class Table:
    """One FlatBuffers table: https://flatbuffers.dev/internals/. Fields are numbered as declared."""

    def __init__(self, data, position):
        self.data = data
        self.position = position
        self.vtable = position - struct.unpack_from("<i", data, position)[0]
        self.vtable_size = struct.unpack_from("<H", data, self.vtable)[0]

    @classmethod
    def root(cls, data):
        return cls(data, struct.unpack_from("<I", data, 0)[0])

    def place(self, field):
        slot = 4 + 2 * field
        if slot >= self.vtable_size:
            return None
        offset = struct.unpack_from("<H", self.data, self.vtable + slot)[0]
        return self.position + offset if offset else None

    def number(self, field, code):
        place = self.place(field)
        return 0 if place is None else struct.unpack_from("<" + code, self.data, place)[0]

    def struct(self, field, code):
        return struct.unpack_from("<" + code, self.data, self.place(field))

    def vector(self, field):
        """Position of the first element, and how many there are."""
        place = self.place(field)
        start = place + struct.unpack_from("<I", self.data, place)[0]
        return start + 4, struct.unpack_from("<I", self.data, start)[0]

    def string(self, field):
        start, size = self.vector(field)
        return self.data[start:start + size].decode()

    def numbers(self, field, code):
        start, count = self.vector(field)
        return struct.unpack_from(f"<{count}{code}", self.data, start)

    def tables(self, field):
        start, count = self.vector(field)
        for i in range(count):
            place = start + 4 * i
            yield Table(self.data, place + struct.unpack_from("<I", self.data, place)[0])


class Block:
    def __init__(self, table):
        self.name = table.string(0)
        self.version = table.number(1, "I")
        self.is_required = table.number(2, "B")
        self.row_count = table.number(3, "Q")
        self.offset = table.number(4, "Q")
        self.stored_size = table.number(5, "Q")
        self.raw_size = table.number(6, "Q")
        self.codec = table.number(7, "B")
        self.raw_digest = bytes(table.struct(8, "32B"))

    def digest_parts(self):
        return [self.name.encode(), struct.pack("<I", self.version),
                struct.pack("<Q", self.row_count), self.raw_digest]


def digest(*parts):
    return hashlib.sha256(b"".join(struct.pack("<Q", len(p)) + p for p in parts)).digest()


def read_range_layer(raw, rows, ranges, limits):
    """Columns by name, each a list with one entry (or one tuple) a row."""
    columns = {}
    offset = 0
    for name, code, width in [("site", "I", 1), ("run", "I", 1), ("s_m", "d", 1), ("p_x_m", "d", 1),
                              ("p_y_m", "d", 1), ("p_z_m", "d", 1), ("range_index", "B", limits),
                              ("range_flags", "B", limits), ("mean_error_m", "d", ranges),
                              ("probability", "d", ranges * limits), ("site_flags", "B", 1),
                              ("pose", "d", 12)]:
        values = struct.unpack_from(f"<{rows * width}{code}", raw, offset)
        columns[name] = [values[i * width:(i + 1) * width] for i in range(rows)]
        offset += rows * width * struct.calcsize("<" + code)
        offset = (offset + 63) // 64 * 64
    assert offset == len(raw), "the layer has another size than its rows need"
    return columns


def read_map(data):
    """Manifest and, by site id, the row of the range layer; after every check that needs no XXH3."""
    magic, major, _, header_size = struct.unpack_from("<8sHHI", data, 0)
    assert magic == b"\x89SLM\r\n\x1a\n" and major == 1 and header_size == 128
    _, incompatible, file_size, m_offset, m_size, _, d_offset, d_size, _ = struct.unpack_from(
        "<9Q", data, 16)
    assert incompatible == 0 and file_size == len(data)
    trailer = struct.unpack_from("<3Q8s", data, len(data) - 32)
    assert trailer == (file_size, struct.unpack_from("<Q", data, 120)[0], 0, magic[::-1])
    manifest_bytes = data[m_offset:m_offset + m_size]
    manifest = Table.root(manifest_bytes)
    directory = Table.root(data[d_offset:d_offset + d_size])
    ranges_m = manifest.numbers(14, "d")
    limits_m = [promise.number(0, "d") for promise in manifest.tables(17)]
    tile_m = manifest.number(6, "d")
    sites = {}
    tile_digests = []
    previous = None
    for tile in directory.tables(1):
        key = (tile.number(0, "i"), tile.number(1, "i"))
        assert previous is None or previous < key
        previous = key
        layers = [Block(table) for table in tile.tables(3)]
        parts = [part for layer in layers if layer.is_required for part in layer.digest_parts()]
        tile_digests.append(digest(b"sightline tile", struct.pack("<2i", *key), *parts))
        assert tile_digests[-1] == bytes(tile.struct(2, "32B")), "tile digest"
        for layer in layers:
            assert layer.offset % 64 == 0 and layer.name in ("contents", "factors", "ndt", "range")
            if layer.name != "range":
                continue
            raw = data[layer.offset:layer.offset + layer.stored_size]
            assert layer.codec == 0 and hashlib.sha256(raw).digest() == layer.raw_digest
            columns = read_range_layer(raw, layer.row_count, len(ranges_m), len(limits_m))
            for row in range(layer.row_count):
                site = {name: values[row] for name, values in columns.items()}
                assert (math.floor(site["p_x_m"][0] / tile_m),
                        math.floor(site["p_y_m"][0] / tile_m)) == key
                sites[site["site"][0]] = site
    root = digest(b"sightline map", hashlib.sha256(manifest_bytes).digest(),
                  struct.pack("<Q", incompatible), struct.pack("<Q", len(tile_digests)),
                  *tile_digests)
    assert root == data[88:120], "root digest"
    assert sorted(sites) == list(range(manifest.number(13, "I")))
    return manifest, ranges_m, limits_m, sites


def check_sites(dump, manifest, sites):
    facts = dump["facts"]
    origin = (facts["origin_world_x_m"], facts["origin_world_y_m"], facts["origin_world_z_m"])
    assert manifest.struct(4, "3d") == origin
    for row in dump["rows"]:
        row = dict(zip(dump["columns"], row))
        site = sites[row["site"]]
        assert site["run"] == (row["run"],) and site["s_m"] == (row["s_m"],)
        assert [site[f"p_{axis}_m"][0] for axis in "xyz"] == [row[f"p_{axis}_m"] for axis in "xyz"]
        assert [site["pose"][i] for i in (3, 7, 11)] == [row["x_m"], row["y_m"], row["z_m"]]
        # Row-major or column-major shows in the sign of the sine.
        yaw = 2 * math.atan2(row["qz"], row["qw"])
        assert math.isclose(site["pose"][4], math.sin(yaw), abs_tol=1e-12)
    assert len(dump["rows"]) == len(sites)


def check_predictions(dump, ranges_m, limits_m, sites):
    assert len(dump["rows"]) == len(sites) * len(ranges_m)
    for row in dump["rows"]:
        (site_id, range_m, extrapolated, out_of_fold, has_history, mean_error_m,
         *probabilities) = row
        site = sites[site_id]
        index = ranges_m.index(range_m)
        assert site["mean_error_m"][index] == mean_error_m
        start = index * len(limits_m)
        assert list(site["probability"][start:start + len(limits_m)]) == probabilities
        assert site["site_flags"] == (extrapolated + 2 * out_of_fold + 4 * has_history,)


def check_ranges(dump, ranges_m, limits_m, sites):
    assert len(dump["rows"]) == len(sites) * len(limits_m)
    for site_id, limit_m, range_m, unmet, extrapolated in dump["rows"]:
        limit = limits_m.index(limit_m)
        assert ranges_m[sites[site_id]["range_index"][limit]] == range_m
        assert sites[site_id]["range_flags"][limit] == unmet + 2 * extrapolated


def main():
    write_random_map = sys.argv[1]
    for seed in range(1, 6):
        with tempfile.TemporaryDirectory() as name:
            subprocess.run([write_random_map, str(seed), name], check=True)
            folder = pathlib.Path(name)
            manifest, ranges_m, limits_m, sites = read_map((folder / "map.slmap").read_bytes())
            load = lambda what: json.loads((folder / f"{what}.json").read_text())
            check_sites(load("sites"), manifest, sites)
            check_predictions(load("predicted"), ranges_m, limits_m, sites)
            check_ranges(load("ranges"), ranges_m, limits_m, sites)
            print(f"seed {seed}: {len(sites)} sites agree")


main()
