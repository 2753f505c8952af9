"""The first command, examples/town/run, ends with map, verdict and page on one screen.
usage: first_command_test.py SOURCE_FOLDER BUILD_FOLDER
"""
import os
import pathlib
import subprocess
import sys
import unittest

SOURCE, BUILD = map(pathlib.Path, sys.argv[1:3])
MOST_LINES = 25


class FirstCommand(unittest.TestCase):
    def test_it_ends_with_map_and_page_on_one_screen(self):
        run = subprocess.run([SOURCE / "examples/town/run", "1", "100"], capture_output=True, text=True,
                             env={**os.environ, "SIGHTLINE_BUILD": str(BUILD)})
        self.assertEqual(run.returncode, 0, run.stderr)
        lines = run.stdout.splitlines()
        self.assertLessEqual(len(lines), MOST_LINES, run.stdout)
        self.assertLessEqual(max(map(len, lines)), 120, run.stdout)
        town = BUILD / "town-1-100"
        self.assertIn(str(town / "town.slmap"), lines[-2])
        self.assertIn(str((town / "town.html").resolve()), lines[-1])
        self.assertRegex(run.stdout,
                         r"A vehicle at -?\d+ m, -?\d+ m needs the LiDAR points within \d+ m, or \d+ points chosen from \d+ of the scan")
        self.assertRegex(run.stdout, r"Localized +101 of 101 scans \(100.0 %\)")
        self.assertIn("<html", (town / "town.html").read_text(encoding="utf-8")[:200])
        for step in range(1, 7):
            self.assertIn(f"[{step}/6] ", run.stderr)

    def test_it_explains_its_arguments(self):
        for words, status in [(["--help"], 0), (["--fast"], 64), (["town9"], 64), (["1", "100", "2"], 64), (["1", "100", "town", "2"], 64)]:
            run = subprocess.run([SOURCE / "examples/town/run", *words], capture_output=True, text=True, timeout=10)
            self.assertEqual(run.returncode, status, run.stderr)
            self.assertIn("usage: examples/town/run [SEED=1] [LENGTH_M=600] [WORLD=town]", run.stderr)


class Progress(unittest.TestCase):
    def shown(self, lines):
        return subprocess.run([SOURCE / "tests/support/progress", "building"], input=lines, capture_output=True, text=True,
                              check=True).stderr

    def test_percent_and_remaining_time(self):
        self.assertEqual(self.shown("step 50/200 60.1 CXX a.o\n"),
                         "building: 50 of 200 steps, 25 %, 1:00 min so far, about 3:00 min left\n")
        self.assertEqual(self.shown("step 1/200 0.4 CXX a.o\n"), "building: 1 of 200 steps, 0 %, 0:00 min so far\n")
        self.assertEqual(self.shown("pmstatus:cmake:34.7:Unpacking\n"), "building: 34 % installed\n")

    def test_steps_of_a_compile(self):
        event = '{"event":"%s","pass":"ingest","step":1,"steps":24%s}\n'
        self.assertEqual(self.shown(event % ("started", "")), "building: step 1 of 24, ingest\n")
        self.assertEqual(self.shown(event % ("progress", ',"done":1,"total":9,"run_remaining_s":63.9')),
                         "building: step 1 of 24, ingest, about 1:03 min left\n")
        self.assertEqual(self.shown(event % ("finished", "")), "")

    def test_few_lines_elsewhere_than_on_a_terminal(self):
        self.assertEqual(len(self.shown("".join(f"step {i}/200 {i} a\n" for i in range(1, 200))).splitlines()), 1)

    def test_messages_of_the_compiler_are_kept(self):
        self.assertIn("a.cpp:1: error\n", self.shown("ninja: Entering directory\nstep 1/2 0.1 a\na.cpp:1: error\n"))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
