"""A small town for the tests of this folder, and its compile as a plan that many processes may work on."""

import hashlib
import pathlib
import subprocess

STAGES = ("drives", "graph", "tiles", "sites", "learn")

CONFIG = """
annotation: {ranges_m: [10, 30], split: auto, looks: paper}
mapping: {scans: mapping/scans, poses: mapping/poses.tum}
localization: {scans: drive_1/scans, poses: drive_1/poses.tum}
"""

# The same street driven on two days makes the map.
CONFIG_OF_TWO_DAYS = """
annotation: {ranges_m: [10, 30], split: auto, looks: paper}
mapping:
  - {scans: mapping/scans, poses: mapping/poses.tum}
  - {scans: drive_2/scans, poses: drive_2/poses.tum}
localization: {scans: drive_1/scans, poses: drive_1/poses.tum}
"""

# So that one compile takes a few seconds.
QUICK = [word for setting in ("train-model.trees=5", "measure-error.offset_count=2", "measure-error.reference=known",
                              "build-surface.cell_m=2.0", "cast-rays.azimuth_count=180",
                              "remove-moving.carve_range_m=30")
         for word in ("--set", setting)]


def run(*command, ok=True, **options):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, errors="replace", timeout=300,
                          **options)
    if ok and done.returncode != 0:
        raise AssertionError(f"{command}: {done.returncode}\n{done.stdout}{done.stderr}")
    return done


def contents(folder):
    """Each file below a folder with its digest."""
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in sorted(pathlib.Path(folder).rglob("*")) if path.is_file()}


class Town:
    """Recordings of a street of 60 m and the configurations of its compiles."""

    def __init__(self, sightline, write_town, folder, spacing_m=3):
        self.program = pathlib.Path(sightline)
        self.folder = pathlib.Path(folder)
        run(write_town, "--seed", 3, "--length-m", 60, "--spacing-m", spacing_m, "--drives", 2, "--output", self.folder)
        self.config = self.folder / "town.yaml"
        self.config.write_text(CONFIG)
        self.config_of_two_days = self.folder / "two_days.yaml"
        self.config_of_two_days.write_text(CONFIG_OF_TWO_DAYS)

    def sightline(self, *words, **options):
        return run(self.program, *words, **options)

    def compiled(self, out, *words, config=None):
        """The bytes of the map that one `sightline compile` makes."""
        self.sightline("compile", config or self.config, "-o", out, "-q", "--no-cache", *QUICK, *words)
        return pathlib.Path(out).read_bytes()


class SharedCompile:
    """A plan folder, and workers on it."""

    def __init__(self, town, plan):
        self.town = town
        self.plan = pathlib.Path(plan)

    def make_plan(self, *words, config=None, **options):
        return self.town.sightline("cluster", "plan", config or self.town.config, "-o", self.plan, *QUICK, *words, **options)

    @property
    def store(self):
        return self.plan / "store"

    def words(self, stage, share=None, threads=1):
        shares = ("--share", share) if share else ()
        return ("cluster", "work", self.plan, "--stage", stage, *shares, "--threads", threads)

    def work(self, stage, share=None, threads=1, **options):
        return self.town.sightline(*self.words(stage, share, threads), **options)

    def start(self, stage, share=None, threads=1):
        return subprocess.Popen([str(word) for word in (self.town.program, *self.words(stage, share, threads))],
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, errors="replace")

    def all_stages(self, threads=1):
        for stage in STAGES:
            self.work(stage, threads=threads)

    def link(self, out, **options):
        return self.town.sightline("cluster", "link", self.plan, "-o", out, **options)
