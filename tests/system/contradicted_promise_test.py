"""A promise of the model is withdrawn where the map's own localization drive contradicts it: on every page, in JSON and
for the vehicle.

Any build can be judged. 8adacdf0 keeps the promise: "three lines below each other in `inspect`".

usage: contradicted_promise_test.py SIGHTLINE TOWN SOURCES [unittest arguments]
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

# So loose that eight blocks of 60 m earn a promise, and that three blocks which all miss contradict it.
ALPHA = 0.2
TRAINED = {"seeds": (1, 2, 3, 4), "length_m": 180}
JUDGED = {"seeds": (6,), "length_m": 210}
CONFIG = f"""mapping: {{scans: mapping/scans, poses: mapping/poses.tum}}
localization: {{scans: drive_1/scans, poses: drive_1/poses.tum}}
annotation: {{ranges_m: [20, 40], looks: paper}}
choose-ranges: {{alpha: {ALPHA}}}
measure-error: {{offset_count: 2, reference: known}}
predict-error: {{history: never}}
train-model: {{trees: 10}}
build-surface: {{cell_m: 1.0}}
cast-rays: {{azimuth_count: 180}}
remove-moving: {{carve_range_m: 30}}
"""
APART_M = 0.4  # of the localization drive's poses and the map: four times the limit
WITHDRAWN = "the errors measured in this map contradict it"


def run(*words):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, (words, done.stderr)
    return done.stdout


def towns(work, seeds, length_m):
    for seed in seeds:
        folder = work / f"town-{seed}"
        run(SETTINGS["town"], "--seed", seed, "--length-m", length_m, "--spacing-m", 3, "--drives", 1, "--output", folder)
        (folder / "town.yaml").write_text(CONFIG)
        yield folder / "town.yaml"


def moved_poses(poses, by_m):
    """A file of the same poses, farther in y."""
    rows = [row.split() for row in poses.read_text().splitlines() if row and row[0] != "#"]
    moved = poses.with_name("moved.tum")
    moved.write_text("".join(" ".join([*row[:2], repr(float(row[2]) + by_m), *row[3:]]) + "\n" for row in rows))
    return moved


class ContradictedPromise(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.work = pathlib.Path(cls.scratch.name)
        cls.cache = cls.work / "cache"
        cls.model = cls.work / "towns.slmodel"
        run(SETTINGS["sightline"], "train", *towns(cls.work, **TRAINED), "-o", cls.model, "--cache", cls.cache)
        (cls.config,) = towns(cls.work, **JUDGED)

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def compiled(self, name, *more):
        """(what the compile prints, inspect, its JSON, what the vehicle reads) of the limit of 10 cm."""
        map_file = self.work / f"{name}.slmap"
        printed = run(SETTINGS["sightline"], "compile", self.config, "-o", map_file, "--model", self.model, "--cache",
                      self.cache, *more)
        inspected = run(SETTINGS["sightline"], "inspect", map_file)
        of_limit = json.loads(run(SETTINGS["sightline"], "dump", map_file, "--what", "ranges", "--format", "json"))["facts"]
        vehicle = sightline_map.SightlineMap(map_file).promises[0]
        return " ".join(printed.split()), " ".join(inspected.split()), of_limit, vehicle

    def test_is_kept_where_the_drive_agrees(self):
        printed, _, of_limit, vehicle = self.compiled("honest")
        self.assertNotIn(WITHDRAWN, printed)
        self.assertEqual(of_limit["limit_0.1_m_is_earned"], 1, of_limit["limit_0.1_m_statement"])
        self.assertTrue(vehicle["is_earned"])
        self.assertAlmostEqual(vehicle["coverage"], 1.0 - ALPHA)

    def test_is_withdrawn_where_the_drive_contradicts_it(self):
        moved = moved_poses(self.config.parent / "drive_1/poses.tum", APART_M)
        printed, inspected, of_limit, vehicle = self.compiled("contradicted", "--set", f"localization.poses={moved}")
        self.assertEqual(of_limit["limit_0.1_m_is_earned"], 0, of_limit["limit_0.1_m_statement"])
        self.assertIn(WITHDRAWN, of_limit["limit_0.1_m_statement"])
        self.assertIn(WITHDRAWN, printed)
        self.assertIn(WITHDRAWN, inspected)
        self.assertFalse(vehicle["is_earned"])
        self.assertEqual(vehicle["coverage"], 0.0)


if __name__ == "__main__":
    SETTINGS = dict(zip(("sightline", "town"), sys.argv[1:3]))
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(pathlib.Path(sys.argv[3], "examples/vehicle_reader")))
    import sightline_map  # noqa: E402
    unittest.main(argv=sys.argv[:1] + sys.argv[4:], verbosity=2)
