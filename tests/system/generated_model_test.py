"""The error model that comes with the program: found beside it, named in every output, and turned off by one key.

usage: generated_model_test.py BUILD_FOLDER
"""

import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

BUILD = pathlib.Path(sys.argv[1]).resolve()
PROGRAM = BUILD / "compiler/driver/sightline"
LABEL = "Predicted from generated worlds"
QUICK = ["--set", "measure-error.offset_count=2", "--set", "build-surface.cell_m=1.0", "--set", "cast-rays.azimuth_count=180"]
CONFIG = """mapping: {scans: mapping/scans, poses: mapping/poses.tum}
localization: {scans: drive_1/scans, poses: drive_1/poses.tum}
measure-error: {reference: known}
train-model: {trees: 10}
"""


def run(*arguments, status=0):
    done = subprocess.run([str(argument) for argument in arguments], capture_output=True, text=True)
    assert done.returncode in ([status] if isinstance(status, int) else status), (arguments, done.returncode, done.stderr)
    return done


class GeneratedModel(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.work = pathlib.Path(cls.scratch.name)
        run(BUILD / "examples/town/sightline_town", "--seed", 3, "--length-m", 70, "--drives", 1, "--output", cls.work / "town")
        cls.config = cls.work / "town/town.yaml"
        cls.config.write_text(CONFIG)
        cls.map = cls.work / "town.slmap"
        cls.compiled = cls.compile(PROGRAM, cls.map)

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    @classmethod
    def compile(cls, program, output, *more, status=0):
        return run(program, "compile", cls.config, "-o", output, "--force", *QUICK, *more, status=status)

    def test_every_output_names_it(self):
        self.assertIn(LABEL, self.compiled.stdout)
        self.assertIn(LABEL, run(PROGRAM, "inspect", self.map, "--all").stdout)
        inspected = json.loads(run(PROGRAM, "inspect", self.map, "--format", "json").stdout)
        self.assertIn(LABEL, json.dumps(inspected))
        gated = run(PROGRAM, "gate", self.map, "--json", self.work / "gate.json", "--force", status=(0, 1, 2))
        self.assertIn(LABEL, gated.stdout + (self.work / "gate.json").read_text())
        run(PROGRAM, "report", self.map, "-o", self.work / "town.html")
        self.assertIn(LABEL, (self.work / "town.html").read_text())

    def test_the_promise_is_not_earned(self):
        ranges = json.loads(run(PROGRAM, "dump", self.map, "--what", "ranges", "--format", "json").stdout)
        self.assertEqual([ranges["facts"][f"limit_{limit}_m_is_earned"] for limit in ("0.1", "0.25")], [0, 0])

    def test_a_key_turns_it_off(self):
        own = self.work / "own.slmap"
        done = self.compile(PROGRAM, own, "--set", "annotation.model=own")
        self.assertNotIn(LABEL, done.stdout)
        self.assertNotIn(LABEL, run(PROGRAM, "inspect", own, "--all").stdout)

    def test_other_ranges_take_the_model_of_the_drive(self):
        done = self.compile(PROGRAM, self.work / "other.slmap", "--set", "annotation.ranges_m=10,30", "--set",
                            "annotation.looks=paper")
        self.assertIn("of other ranges", done.stderr)
        self.assertNotIn(LABEL, done.stdout)

    def test_the_installed_program_finds_it(self):
        prefix = self.work / "prefix"
        run("cmake", "--install", BUILD, "--component", "program", "--prefix", prefix)
        self.compile(prefix / "bin/sightline", self.work / "installed.slmap")
        self.assertEqual((self.work / "installed.slmap").read_bytes(), self.map.read_bytes())

    def test_a_program_without_it_says_so(self):
        alone = self.work / "alone/bin/sightline"
        alone.parent.mkdir(parents=True)
        shutil.copy(PROGRAM, alone)
        failed = self.compile(alone, self.work / "none.slmap", status=tuple(range(1, 256)))
        self.assertIn("annotation.model=own", failed.stderr)
        self.compile(alone, self.work / "none.slmap", "--set", "annotation.model=own")

    def test_a_repeated_compile_proves_the_map(self):
        self.assertIn("the same, bit for bit", run(PROGRAM, "verify", self.map, "--again", self.config, *QUICK).stdout)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
