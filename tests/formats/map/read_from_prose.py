"""The reader of examples/vehicle_reader/sightline_map.py, written from schemas/map_format.md alone, against what
`dump` prints of made-up maps, and against damage.

usage: read_from_prose.py WRITE_RANDOM_MAP FOLDER_OF_SIGHTLINE_MAP
"""

import json
import math
import pathlib
import random
import struct
import subprocess
import sys
import tempfile

sys.path.insert(0, sys.argv[2])
from sightline_map import FAR, NOT_VISIBLE, REASONS, UNKNOWN_LOCALIZER, LookPlan, MapError, SightlineMap, xxh3, zstandard  # noqa: E402


def check_sites(dump, opened, sites):
    facts = dump["facts"]
    origin = (facts["origin_world_x_m"], facts["origin_world_y_m"], facts["origin_world_z_m"])
    assert opened.origin_world_m == origin
    for row in dump["rows"]:
        row = dict(zip(dump["columns"], row))
        site = sites[row["site"]]
        assert site["run"] == (row["run"],) and site["s_m"] == (row["s_m"],)
        assert [site[f"p_{axis}_m"][0] for axis in "xyz"] == [row[f"p_{axis}_m"] for axis in "xyz"]
        assert [site["pose"][i] for i in (3, 7, 11)] == [row["x_m"], row["y_m"], row["z_m"]]
        # Row-major or column-major shows in the sign of the sine.
        yaw = 2 * math.atan2(row["qz"], row["qw"])
        assert math.isclose(site["pose"][4], math.sin(yaw), abs_tol=1e-6 if opened.is_small else 1e-12)
    assert len(dump["rows"]) == len(sites)


def text_of(look):
    """As a dump names it."""
    text = f"{look.range_m:g} m, {look.return_count} returns"
    text += f", evenly spaced beyond {look.even_beyond_m:g} m" if look.even_beyond_m else ""
    text += f", {look.point_count} points" if look.point_count else ""
    return text + " by normals" * look.is_by_normals + ", settle" * look.settles


def check_predictions(dump, opened, sites):
    """Of the ranges, then of the looks that take a sample."""
    ranges = [f"{range_m:g} m" for range_m in opened.ranges_m]
    looks, limits = [text_of(look) for look in opened.looks], len(opened.limits_m)
    assert len(dump["rows"]) == len(sites) * (len(ranges) + len(looks))
    for i, row in enumerate(dump["rows"]):
        (site_id, _, name, extrapolated, out_of_fold, has_history, mean_error_m,
         *probabilities) = row
        site = sites[site_id]
        prefix, names = ("", ranges) if i < len(sites) * len(ranges) else ("look_", looks)
        index = names.index(name)
        assert site[prefix + "mean_error_m"][index] == mean_error_m
        start = index * limits
        assert list(site[prefix + "probability"][start:start + limits]) == probabilities
        assert site[prefix + "extrapolated"][index] == extrapolated
        assert site["site_flags"] == (2 * out_of_fold + 4 * has_history,)


def check_promises(dump, opened):
    for promise in opened.promises:
        fact = {name: dump["facts"][f"limit_{promise['limit_m']:g}_m_{name}"]
                for name in ("is_earned", "alpha", "scope", "place_count", "drive_count", "statement")}
        assert promise["is_of_next_drive"] == (fact["scope"] == "next-drive")
        assert promise["is_earned"] == (fact["is_earned"] == 1)
        assert promise["coverage"] == (1.0 - fact["alpha"] if promise["is_earned"] else 0.0)
        for name in ("place_count", "drive_count", "statement"):
            assert promise[name] == fact[name], (name, promise, fact)


def check_ranges(dump, opened, sites):
    check_promises(dump, opened)
    half = len(sites) * len(opened.limits_m)
    assert len(dump["rows"]) == half * (2 if opened.looks else 1)
    for i, (site_id, limit_m, range_m, name, unmet, extrapolated, is_static, reason) in enumerate(dump["rows"]):
        limit, site = opened.limits_m.index(limit_m), sites[site_id]
        flags = unmet + 2 * extrapolated + 16 * is_static
        if i < half:
            assert opened.ranges_m[site["range_index"][limit]] == range_m
            assert site["range_flags"][limit] == flags
            assert REASONS[site["range_reason"][limit]] == reason
        else:
            assert text_of(opened.looks[site["look_index"][limit]]) == name
            assert site["look_flags"][limit] == flags
            assert REASONS[site["look_reason"][limit]] == reason


def check_nds(dump, opened):
    """Those that lie unpacked, which in these maps are all."""
    rows = {tuple(row[:3]): dict(zip(dump["columns"], row)) for row in dump["rows"]}
    assert len(rows) == opened.nd_count
    count = 0
    for key, points, mean_m, covariance_m2 in opened.nds():
        row = rows[key]
        assert points == row["point_count"]
        assert mean_m == [row[f"mean_{axis}_m"] for axis in "xyz"]
        assert covariance_m2 == [row[f"cov_{pair}_m2"] for pair in ("xx", "xy", "xz", "yy", "yz", "zz")]
        count += 1
    return count


class EverySite:
    """The definition of a look-up: no index, every site of the range layers."""

    def __init__(self, opened):
        self.reach_m, self.limits, self.sites = opened.reach_m, len(opened.limits_m), opened.sites()

    def nearest(self, p_m):
        best = None
        for number, site in sorted(self.sites.items()):
            distance_m = math.dist(p_m, [site[f"p_{axis}_m"][0] for axis in "xyz"])
            if abs(p_m[2] - site["p_z_m"][0]) >= 1.0 or distance_m > self.reach_m or (best and distance_m >= best[0]):
                continue
            def of(prefix, chosen):
                return [(index, site[chosen + "_flags"][i],
                         site[prefix + "probability"][index * self.limits + i],
                         site[prefix + "mean_error_m"][index], site[chosen + "_reason"][i])
                        for i, index in enumerate(site[chosen + "_index"])]

            best = (distance_m, number, site["mean_error_m"][-1], of("", "range"), of("look_", "look"))
        return best


def check_look_up(opened):
    """The section says what a search through every site says."""
    near = 0
    look_up, every_site = opened._look_up, EverySite(opened)
    for _ in range(200):
        position = [o + random.uniform(-110, 110) for o in opened.origin_world_m[:2]]
        position.append(opened.origin_world_m[2] + random.uniform(-3, 3))
        limit_m = random.uniform(0.05, 0.4)
        visible_m = random.choice((5.0, 30.0, 90.0, math.inf))
        answer = opened.observation_range(position, limit_m)
        look = opened.look(position, limit_m, visible_m)
        is_tracking = random.random() < 0.8
        plan = opened.look_plan(position, limit_m, is_tracking, visible_m)
        assert is_tracking or plan == (LookPlan(look[0]), look[1])
        assert look[0].range_m <= visible_m or look[1].flags & NOT_VISIBLE
        opened._look_up = every_site
        assert opened.observation_range(position, limit_m) == answer
        assert opened.look(position, limit_m, visible_m) == look
        assert opened.look_plan(position, limit_m, is_tracking, visible_m) == plan
        opened._look_up = look_up
        near += not answer.flags & FAR
    return near


def check_localizer(folder, opened):
    """Nothing is known for a localizer whose errors were not measured."""
    assert (opened.localizer, opened.localizer_version) == ("annealed", 3)
    assert opened.localizer_parameters == {"coarse_cells": "2", "leaf_m": "0.5"}
    place = [o + p for o, p in zip(opened.origin_world_m, opened.sites()[0]["pose"][3::4])]
    for localizer in ("", "pcl-ndt", "annealed/2"):
        answer = SightlineMap(folder / "map.slmap", localizer).observation_range(place, 0.25)
        assert answer.flags & UNKNOWN_LOCALIZER and answer.range_m == opened.ranges_m[-1]
        assert math.isnan(answer.probability) and math.isnan(answer.mean_error_m)


def check_damage(file, folder):
    """A flipped bit is refused or changes no answer."""
    whole = SightlineMap(folder / "map.slmap", "annealed")
    place = [o + p for o, p in zip(whole.origin_world_m, (1.0, 2.0, 0.0))]
    expected = whole.observation_range(place, 0.25)
    refused = 0
    for i in random.sample(range(len(file)), 150):
        damaged = bytearray(file)
        damaged[i] ^= 1 << i % 8
        (folder / "damaged.slmap").write_bytes(damaged)
        try:
            assert SightlineMap(folder / "damaged.slmap", "annealed").observation_range(place, 0.25) == expected
        except MapError:
            refused += 1
    assert refused > 0
    (folder / "damaged.slmap").write_bytes(file[:-1])
    try:
        SightlineMap(folder / "damaged.slmap")
        raise AssertionError("a cut file was read")
    except MapError as error:
        assert error.name == "truncated-file"


def check_versions(file, folder):
    """Every minor of the reader's own major is read, another major is refused by name."""
    for major, minor, name in ((1, 7, None), (2, 0, "future-version"), (0, 9, "old-version")):
        other = bytearray(file)
        struct.pack_into("<HH", other, 8, major, minor)
        struct.pack_into("<Q", other, 120, xxh3(bytes(other[:120])))
        other[-24:-16] = other[120:128]
        (folder / "other.slmap").write_bytes(other)
        try:
            SightlineMap(folder / "other.slmap")
            assert name is None
        except MapError as error:
            assert error.name == name and f"format {major}.{minor}, this program reads 1.0" in str(error)


def main():
    random.seed(1)
    nds = near = 0
    kinds = ["plain"] * 4 + ["small-plain"] * 2 + ["small"] * (2 if zstandard else 0)
    for seed, kind in enumerate(kinds, 1):
        with tempfile.TemporaryDirectory() as name:
            subprocess.run([sys.argv[1], str(seed), name, kind], check=True)
            folder = pathlib.Path(name)
            opened = SightlineMap(folder / "map.slmap", "annealed/3")
            assert opened.is_small == (kind != "plain")
            unreadable = opened.check()
            assert not unreadable or not zstandard
            check_localizer(folder, opened)
            sites = opened.sites()
            load = lambda what: json.loads((folder / f"{what}.json").read_text())
            check_sites(load("sites"), opened, sites)
            check_predictions(load("predicted"), opened, sites)
            check_ranges(load("ranges"), opened, sites)
            nds += check_nds(load("nds"), opened)
            near += check_look_up(opened)
            check_damage((folder / "map.slmap").read_bytes(), folder)
            check_versions((folder / "map.slmap").read_bytes(), folder)
            print(f"seed {seed}, {kind}: {len(sites)} sites agree")
    print(f"{nds} NDs agree, {near} places near a site")
    assert nds > 0 and near > 100
    if not zstandard:
        print("packed small maps were not read: the module zstandard is not installed")


main()
