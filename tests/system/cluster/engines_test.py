"""The scripts of `sightline cluster plan --emit make` and `--emit snakemake`, and the line for GNU parallel of examples/cluster.

usage: engines_test.py SIGHTLINE TOWN      an engine that is not installed is skipped by its name
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
from shared_town import STAGES, SharedCompile, Town, contents  # noqa: E402

SETTINGS = {}


def lacks(program):
    return unittest.skipUnless(shutil.which(program), f"{program} is not installed")


class Engines(unittest.TestCase):
    def setUp(self):
        # A name that a shell, make and Python could each stumble over.
        folder = tempfile.mkdtemp(prefix="engines {a} it's $HOME_")
        self.addCleanup(shutil.rmtree, folder)
        self.folder = pathlib.Path(folder)
        self.shared = SharedCompile(SETTINGS["town"], self.folder / "plan")

    def script(self, engine):
        script = self.folder / engine
        script.write_text(self.shared.make_plan("--emit", engine, "--shares", 3).stdout)
        return script

    def run_engine(self, *command):
        done = subprocess.run([str(word) for word in command], cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def assert_map(self):
        self.assertTrue((self.shared.plan / "map.slmap").read_bytes() == SETTINGS["expected"], "another map")

    @lacks("make")
    def test_make(self):
        script = self.script("make")
        self.run_engine("make", "-j2", "-f", script)
        self.assert_map()
        (self.shared.plan / "map.slmap").unlink()
        before = contents(self.shared.store)
        next(self.shared.store.glob("build-ndt-*.sla")).unlink()
        self.run_engine("make", "-j2", "-f", script)
        self.assert_map()
        self.assertEqual(contents(self.shared.store).keys(), before.keys(), "what was missing was made again")

    @lacks("snakemake")
    def test_snakemake(self):
        script = self.script("snakemake")
        self.run_engine("snakemake", "-s", script, "--cores", "2")
        self.assert_map()
        (self.shared.plan / "map.slmap").unlink()
        next(self.shared.store.glob("build-ndt-*.sla")).unlink()
        self.run_engine("snakemake", "-s", script, "--cores", "2")
        self.assert_map()

    @lacks("parallel")
    def test_parallel(self):
        self.shared.make_plan()
        for stage in STAGES:
            self.run_engine("parallel", "-j2", SETTINGS["town"].program, "cluster", "work", "plan", "--stage", stage, "--share", "{}/3",
                            "--threads", "1", ":::", "1", "2", "3")
        self.shared.link(self.shared.plan / "map.slmap")
        self.assert_map()


if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="engines_made_") as made:
        SETTINGS["town"] = Town(os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]), f"{made}/town")
        SETTINGS["expected"] = SETTINGS["town"].compiled(f"{made}/expected.slmap")
        unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2)
