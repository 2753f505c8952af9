"""The numbers that a report holds, beside those of `sightline dump`."""

import base64
import csv
import io
import json
import re
import struct
import subprocess
import zlib


def numbers(packed):
    """An array of the page (compiler/views/report/page/page_data.h)."""
    kind = {"u8": "B", "u16": "H", "u32": "I", "f32": "f", "f64": "d"}[packed["type"]]
    planes = zlib.decompress(base64.b64decode(packed["data"]))
    count, size = packed["count"], struct.calcsize(kind)
    assert len(planes) == count * size
    return struct.unpack(f"<{count}{kind}", bytes(planes[plane * count + i] for i in range(count) for plane in range(size)))


def dumped(sightline, map_file, what):
    command = [sightline, "dump", str(map_file), "--what", what, "--format", "csv"]
    rows = subprocess.run(command, check=True, text=True, stdout=subprocess.PIPE).stdout.splitlines()
    return list(csv.DictReader(io.StringIO("\n".join(row for row in rows if not row.startswith("#")))))


def check_numbers(sightline, map_file, page):
    data = json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page.read_text(), re.S)[1])
    sites = dumped(sightline, map_file, "sites")
    assert data["sites"]["count"] == len(sites) > 100
    for axis in "xyz":
        assert list(numbers(data["sites"][f"{axis}_m"])) == [float(site[f"p_{axis}_m"]) for site in sites]
    ranges_m = data["ranges_m"]
    chosen = numbers(data["choice"]["range_index"])
    rows = dumped(sightline, map_file, "ranges")
    assert [ranges_m[index] for index in chosen] == [float(row["range_m"]) for row in rows]
    predicted = numbers(data["predicted"]["mean_m"])
    rows = dumped(sightline, map_file, "predicted")
    by_pair = {(int(row["site"]), float(row["range_m"])): float(row["mean_error_m"]) for row in rows}
    for (site, range_m), mean_m in by_pair.items():
        found_m = predicted[site * len(ranges_m) + ranges_m.index(range_m)]
        assert abs(found_m - mean_m) <= 1e-6 * abs(mean_m), (site, range_m)
    assert sum(tile["count"] for tile in data["nds"]["tiles"]) == len(dumped(sightline, map_file, "nds"))
