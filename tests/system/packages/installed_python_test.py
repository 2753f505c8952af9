"""The installed Python package against the reader that was written from the format's prose alone, with NumPy and without.

usage: installed_python_test.py FOLDER_OF_SIGHTLINE_MAP MAP SCAN X_M Y_M Z_M YAW_DEG

The last four are about where the scan was taken.
"""

import array
import ctypes
import math
import os
import shutil
import struct
import subprocess
import tempfile
import sys
import threading
import unittest

PROSE, MAP, SCAN = sys.argv[1:4]
GUESS = [float(text) for text in sys.argv[4:8]]
sys.path.append(PROSE)
WITHOUT_NUMPY = "--without-numpy" in sys.argv
if WITHOUT_NUMPY:
    sys.modules["numpy"] = None  # an import fails, as where it is not installed

import sightline  # noqa: E402
from sightline import _interface as interface  # noqa: E402
import sightline_map  # noqa: E402

try:
    import numpy
except ImportError:
    numpy = None


def scan_rows():
    with open(SCAN, "rb") as file:
        header, body = file.read().split(b"DATA binary\n", 1)
    count = int(next(line for line in header.decode().splitlines() if line.startswith("POINTS")).split()[1])
    return memoryview(body).cast("f", (count, 4))


class Interface(unittest.TestCase):
    def test_structures_are_as_long_as_those_of_c(self):
        structures = {"range": sightline.Range, "look": sightline.Look, "look_plan": sightline.LookPlan,
                      "site": sightline.Site, "info": interface.MapInfo, "promise": interface.Promise,
                      "column": sightline.Column,
                      "localizer_options": interface.LocalizerOptions, "points": interface.Points,
                      "match": sightline.Match, "nd": interface.Nd, "localizer_info": interface.LocalizerInfo}
        lines = [f'printf("%zu\\n", sizeof(sightline_{name}));' for name in structures]
        program = ("#include \"formats/reader/sightline_reader.h\"\n#include \"passes/vehicle/sightline_localizer.h\"\n#include <stdio.h>\n"
                   "int main(void) {\n" + "\n".join(lines) + "\nreturn 0;\n}\n")
        flags = subprocess.run(["pkg-config", "--cflags", "sightline-reader", "sightline-localizer"], check=True,
                               capture_output=True, text=True).stdout.split()
        with tempfile.TemporaryDirectory() as folder:
            built = os.path.join(folder, "sizes")
            subprocess.run(["cc", "-xc", "-", *flags, "-o", built], input=program, text=True, check=True)
            sizes = subprocess.run([built], check=True, capture_output=True, text=True).stdout.split()
        for (name, structure), size in zip(structures.items(), sizes, strict=True):
            self.assertEqual(ctypes.sizeof(structure), int(size), name)


class Map(unittest.TestCase):
    def setUp(self):
        self.map = sightline.Map(MAP)
        self.prose = sightline_map.SightlineMap(MAP, "searching")

    def test_tells_the_same_facts(self):
        self.assertEqual(self.map.map_id, self.prose.map_id)
        self.assertEqual(self.map.site_count, self.prose.site_count)
        self.assertEqual(self.map.ranges_m, tuple(self.prose.ranges_m))
        self.assertEqual(self.map.limits_m, tuple(self.prose.limits_m))
        self.assertEqual(self.map.localizer, "searching")
        self.assertTrue(self.map.is_for_caller)
        self.assertTrue(self.map.promise(0).statement)
        self.assertEqual(self.map.world, "local")
        self.assertEqual(self.map.export_origin_world_m, (0.0, 0.0, 0.0))

    def test_answers_alike_at_and_beside_every_site(self):
        for limit, limit_m in enumerate(self.map.limits_m):
            for site in self.map.sites(limit):
                for off_m in (0.0, 1.5, 400.0):
                    p_m = [site["position_world_m"][i] if numpy else site.position_world_m[i] for i in range(3)]
                    p_m[0] += off_m
                    expected = self.prose.observation_range(p_m, limit_m)
                    found = self.map.observation_range(p_m, limit_m)
                    self.assertEqual((found.range_m, found.probability, found.mean_error_m, found.flags),
                                     (expected.range_m, expected.probability, expected.mean_error_m,
                                      expected.flags))
                    self.assertEqual(self.map.reasons(p_m, limit_m).range,
                                     sightline_map.REASONS[expected.reason])
                    look = self.map.look(p_m, limit_m)
                    self.assertEqual(tuple(self.prose.look(p_m, limit_m)[0])[:4],
                                     (look.range_m, look.return_count, look.even_beyond_m, look.point_count))
                    plan = self.map.look_plan(p_m, limit_m, True)
                    self.assertEqual(plan.first.range_m, self.prose.look_plan(p_m, limit_m, True)[0].first.range_m)

    def test_sites_are_those_of_the_map(self):
        expected = self.prose.sites()
        for limit in range(len(self.map.limits_m)):
            sites = self.map.sites(limit)
            self.assertEqual(len(sites), len(expected))
            for number, site in enumerate(sites):
                row = expected[number]
                if not numpy:
                    site = {name: getattr(site, name) for name, _ in sightline.Site._fields_}
                self.assertEqual(site["site"], number)
                self.assertEqual(site["range_m"], self.map.ranges_m[row["range_index"][limit]])
                for axis, name in enumerate(("p_x_m", "p_y_m", "p_z_m")):
                    self.assertEqual(site["position_world_m"][axis],
                                     row[name][0] + self.map.origin_world_m[axis])

    def test_in_memory_outlives_its_file(self):
        with tempfile.TemporaryDirectory() as folder:
            path = shutil.copy(MAP, folder)
            copied = sightline.Map(path, in_memory=True)
            os.truncate(path, 0)
            self.assertEqual(copied.map_id, self.map.map_id)
            self.assertEqual(list(copied.sites(0)["range_m"]) if numpy else [site.range_m for site in copied.sites(0)],
                             list(self.map.sites(0)["range_m"]) if numpy else [site.range_m for site in self.map.sites(0)])

    def test_refuses_with_the_name_of_the_error(self):
        with self.assertRaises(sightline.Error) as caught:
            sightline.Map(MAP + ".none")
        self.assertEqual((caught.exception.name, caught.exception.code), ("file-not-found", 2001))
        with self.assertRaises(sightline.Error):
            self.map.observation_range((math.nan, 0, 0), 0.1)
        with self.assertRaises(ValueError):
            self.map.look((0, 0), 0.1)
        self.map.close()
        with self.assertRaises(ValueError):
            self.map.look((0, 0, 0), 0.1)

    def test_errors_are_those_of_the_columns(self):
        names = ("longitudinal_m", "lateral_m", "yaw_rad", "kept_longitudinal")
        for is_sample, prefix in ((False, "tracking_"), (True, "tracking_sample_")):
            columns = {name: self.map.column(prefix + name).values for name in names}
            for site in range(self.map.site_count):
                errors = self.map.errors(site, is_sample)
                for name, column in columns.items():
                    self.assertEqual(getattr(errors, name), column[site], (site, name))

    def test_bounds_errors_before_any_match(self):
        kinds = self.map.column("place_kind").values
        bounds = self.map.protection(3)
        self.assertEqual(bounds.place_kind, kinds[3])
        self.assertTrue(all(0 < level < 10 for level in bounds.protection_m), list(bounds.protection_m))
        self.assertTrue(math.isinf(self.map.protection(3, risk=1e-6).protection_m[0]))

    def test_names_the_flags_of_an_answer(self):
        far = self.map.observation_range((1e5, 0, 0), 0.1)
        self.assertEqual(far.flag_names, ["far"])
        self.assertTrue(repr(far).startswith("Range(range_m="), repr(far))
        self.assertTrue(repr(far).endswith(", flags=far)"), repr(far))

    def test_may_be_closed_while_other_threads_read(self):
        def read_all(opened):
            try:
                while True:
                    opened.sites(0)
                    opened.columns()
            except ValueError:
                pass  # closed

        for _ in range(20):
            opened = sightline.Map(MAP)
            threads = [threading.Thread(target=read_all, args=(opened,)) for _ in range(4)]
            for thread in threads:
                thread.start()
            opened.close()
            for thread in threads:
                thread.join()


class Localizer(unittest.TestCase):
    def setUp(self):
        self.localizer = sightline.Localizer(MAP, whole_map=True)
        half_rad = math.radians(GUESS[3]) / 2
        self.start = sightline.pose(GUESS[:3], (0, 0, math.sin(half_rad), math.cos(half_rad)))

    def test_nds_are_those_of_the_map(self):
        nds = self.localizer.nds
        expected = sightline_map.SightlineMap(MAP, "searching").nd_count
        self.assertEqual(len(nds), expected)
        if numpy:
            self.assertFalse(nds.flags.writeable)
            self.assertEqual(nds["covariance_m2"].shape, (expected, 6))
            self.assertTrue((nds["covariance_m2"][:, 0] > 0).all())
        else:
            self.assertTrue(all(nd.covariance_m2[0] > 0 for nd in nds))

    def test_reads_the_map_tile_by_tile_with_the_same_matches(self):
        near = sightline.Localizer(MAP)
        with self.assertRaises(ValueError):
            near.nds
        for _ in range(10000):
            if near.prepare(GUESS[:3], 1.0):
                break
        look = sightline.Look(range_m=30.0)
        self.assertEqual(bytes(near.match(scan_rows(), self.start, look)),
                         bytes(self.localizer.match(scan_rows(), self.start, look)))
        self.assertEqual(near.faults, [])

    def test_nds_outlive_the_localizer(self):
        nds = self.localizer.nds
        first = bytes(memoryview(nds[:1]).cast("B")) if numpy else bytes(nds[0])
        self.localizer.close()
        self.localizer = None
        self.assertEqual(bytes(memoryview(nds[:1]).cast("B")) if numpy else bytes(nds[0]), first)

    def test_takes_every_kind_of_array(self):
        rows = scan_rows()
        flat = array.array("f", struct.unpack(f"{rows.nbytes // 4}f", rows.cast("B")))
        wide = array.array("d", flat)
        look = sightline.Look(range_m=30.0)
        scans = [rows, memoryview(flat).cast("B").cast("f", rows.shape),
                 memoryview(wide).cast("B").cast("d", rows.shape)]
        if numpy:
            scans += [numpy.array(rows), numpy.array(rows, dtype=numpy.float64),
                      numpy.ascontiguousarray(numpy.array(rows)[:, :3])]
        matches = [bytes(self.localizer.match(scan, self.start, look)) for scan in scans]
        self.assertEqual(len(set(matches)), 1)
        self.assertTrue(sightline.Match.from_buffer_copy(matches[0]).is_matched)
        match = self.localizer.match(rows, [self.start[:4], self.start[4:8], self.start[8:]], look)
        self.assertEqual(bytes(match), matches[0])
        by_range = sightline.Range(range_m=30.0)
        self.assertEqual(bytes(self.localizer.match(rows, self.start, by_range)), matches[0])
        plan = sightline.LookPlan(first=look)
        self.assertEqual(bytes(self.localizer.match(rows, self.start, plan)), matches[0])
        if numpy:
            nothing = numpy.zeros((0, 3), dtype=numpy.float32)
            self.assertEqual(self.localizer.match(nothing, self.start, look).stop, sightline.NO_POINTS)
        for wrong in (flat, memoryview(flat).cast("B"), b"", [1.0, 2.0, 3.0]):
            with self.assertRaises((ValueError, TypeError)):
                self.localizer.match(wrong, self.start, look)

    def test_refuses_with_the_name_of_the_error(self):
        with self.assertRaises(sightline.Error) as caught:
            self.localizer.match(scan_rows(), [0.0] * 12, sightline.Look(range_m=30.0))
        self.assertEqual(caught.exception.name, "bad-argument")
        with self.assertRaises(sightline.Error) as caught:
            sightline.Localizer(SCAN, cell_m=0.001)
        self.assertEqual(caught.exception.name, "bad-value")


if __name__ == "__main__":
    if not WITHOUT_NUMPY:
        subprocess.run([sys.executable, *sys.argv, "--without-numpy"], check=True)
    unittest.main(argv=sys.argv[:1])
