"""What surrounds the formats: pipes and devices, disks that fill, calls that fail, memory that ends, processes that
are killed, caches that others write to. Nothing may crash, hang, leave half a file or make another map.

usage: faults_test.py SIGHTLINE TOWN WRITE_FLEET_MAPS FAILING_CALLS JUMPING_CLOCK [unittest arguments]
SIGHTLINE_FAULTS=200 in the environment makes so many kills of each verb, and as many sizes of a disk (default: 3).
"""

import collections
import errno
import hashlib
import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

SETTINGS = {}
KNOWN = (0, 2, 64, 65, 66, 67, 68, 69, 74, 75)  # every exit status that is documented
TRIES = int(os.environ.get("SIGHTLINE_FAULTS", "3"))
FIGURES = collections.Counter()

CONFIG = """
annotation: {ranges_m: [10, 30], split: auto, looks: paper}
mapping: {scans: mapping/scans, poses: mapping/poses.tum}
localization: {scans: drive_1/scans, poses: drive_1/poses.tum}
measure-error: {offset_count: 2, reference: known}
train-model: {trees: 5}
build-surface: {cell_m: 1.0}
cast-rays: {azimuth_count: 180}
remove-moving: {carve_range_m: 30}
"""

# Verbs that write, with what they read in place; the first word behind `>` is what they write.
VERBS = {
    "strip": ("strip", "v1.slmap", "-o", ">out.slmap", "--force"),
    "recover": ("recover", "v1.slmap", "-o", ">out.slmap", "--force"),
    "delta": ("delta", "v1.slmap", "v2.slmap", "-o", ">out.sldelta", "--force"),
    "apply": ("apply", "1-2.sldelta", "--to", ">v1.slmap"),
    "apply to": ("apply", "1-2.sldelta", "--to", "v1.slmap", "-o", ">out.slmap"),
    "rollback": ("apply", "--rollback", "--to", ">v3.slmap"),
    "export": ("export", "v1.slmap", "--format", "geojson", "-o", ">out.json", "--force"),
    "gate": ("gate", "v1.slmap", "--json", ">out.json", "--force"),
    "release": ("release", "v1.slmap", "--fleet", "town", "--counter", "2", "--expires",
                "2030-01-01T00:00:00Z", "-o", ">release", "--force"),
    "root": ("root", "--fleet", "town", "--signer", "a.pub", "--threshold", "1", "--expires",
             "2030-01-01T00:00:00Z", "-o", ">out.root", "--force"),
    "sign": ("sign", "root.1", "--key", "a.key"),
    "key": ("key", "new"),
    "init": ("init", "town", "-o", ">out.yaml", "--force", "--no-schema"),
    "admit": ("admit", "--root", "root.1", "--now", "2029-01-01T00:00:00Z", "--new-seen", ">seen", "release"),
    "weak": ("weak", "v1.slmap", "--places", "0", "-o", ">out.txt", "--force"),
    "report": ("report", "v1.slmap", "-o", ">out.html", "--force"),
    "plan": ("plan", "town/town.yaml", "-o", ">plan", "--force"),
    "gpkg": ("export", "v1.slmap", "--format", "gpkg", "-o", ">out.gpkg", "--force"),
    "csv": ("export", "v1.slmap", "--format", "csv", "-o", ">tables", "--force"),
}

INTO_FOLDERS = ("plan", "csv")


def run(*command, **options):
    return subprocess.run([str(part) for part in command], capture_output=True, text=True, errors="replace",
                          timeout=120, **options)


def contents(folder):
    """Each file below a folder with its digest; unfinished files by their prefix alone."""
    found = {}
    for path in sorted(pathlib.Path(folder).rglob("*")):
        if path.is_file() and not path.is_symlink():
            found[str(path.relative_to(folder))] = hashlib.sha256(path.read_bytes()).hexdigest()
    return found


class Faults(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.made = tempfile.mkdtemp(prefix="faults_")
        run(SETTINGS["maps"], cls.made)
        for name in ("mixed", "swapped", "bomb", "inflated"):
            os.remove(f"{cls.made}/{name}.slmap")
        cls.sightline("delta", "v1.slmap", "v2.slmap", "-o", "1-2.sldelta", cwd=cls.made)
        cls.sightline("key", "a", cwd=cls.made)
        cls.sightline("root", "--fleet", "town", "--signer", "a.pub", "--threshold", "1", "--expires",
                      "2030-01-01T00:00:00Z", "-o", "root.1", cwd=cls.made)
        cls.sightline("release", "v1.slmap", "--fleet", "town", "--counter", "1", "--expires",
                      "2030-01-01T00:00:00Z", "-o", "release", cwd=cls.made)
        cls.sightline("sign", "release", "--key", "a.key", cwd=cls.made)
        shutil.copy(f"{cls.made}/v1.slmap", f"{cls.made}/v3.slmap.previous")
        cls.inputs = contents(cls.made)
        cls.town = tempfile.mkdtemp(prefix="faults_town_")
        run(SETTINGS["town"], "--seed", "3", "--length-m", "40", "--spacing-m", "2", "--drives", "1", "--force", "--output",
            cls.town)
        with open(f"{cls.town}/town.yaml", "w") as file:
            file.write(CONFIG)
        cls.recordings = contents(cls.town)
        os.symlink(cls.town, f"{cls.made}/town")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.made)
        shutil.rmtree(f"{cls.town}/.sightline-cache", ignore_errors=True)  # digests of scans
        found = contents(cls.town)
        shutil.rmtree(cls.town)
        assert found == cls.recordings, f"the town has changed: {found.items() ^ cls.recordings.items()}"
        print(cls.__name__, dict(FIGURES))
        FIGURES.clear()

    @staticmethod
    def sightline(*words, **options):
        return run(SETTINGS["sightline"], *words, **options)

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="fault_")
        self.addCleanup(shutil.rmtree, self.folder)

    def fresh(self):
        """A folder with all inputs, as it was at the beginning; the town is a link, which nothing here writes into."""
        folder = os.path.join(self.folder, "work")
        if os.path.exists(folder):
            shutil.rmtree(folder)
        shutil.copytree(self.made, folder, symlinks=True)
        return folder

    def words(self, verb):
        return [word.lstrip(">") for word in VERBS[verb]]

    def whole(self, verb, **options):
        """What the folder holds after the verb has come to its end."""
        folder = self.fresh()
        done = self.sightline(*self.words(verb), cwd=folder, **options)
        self.assertIn(done.returncode, (0, 69), f"{verb}: {done.stderr}")  # the gate judges
        found = contents(folder)
        self.assertFalse([name for name in found if ".sl-" in name], verb)
        return found

    def assert_known(self, done, about):
        FIGURES["cases"] += 1
        self.assertIn(done.returncode, KNOWN, f"{about}: {done.returncode} {done.stderr[-500:]}")
        if done.returncode not in (0, 2):
            self.assertIn("SL", done.stderr, about)

    def assert_old_or_new(self, old, new, found, about, leftovers=False):
        """Each file is what it was or what it becomes; only unfinished files may lie beside."""
        for name, digest in found.items():
            base = os.path.basename(name)
            if base.startswith(".sl-") or (base.endswith((".part", ".keep")) and leftovers):
                self.assertTrue(leftovers, f"{about}: left {name}")
                continue
            self.assertIn(digest, (old.get(name), new.get(name), self.random_file(name, digest)),
                          f"{about}: {name} is neither old nor new")
        for name in old:
            if name in new:
                self.assertIn(name, found, f"{about}: {name} is gone")

    @staticmethod
    def random_file(name, digest):
        """A key differs each time, and so does what is remembered of copied files; that it is whole is asked elsewhere."""
        return digest if os.path.basename(name).startswith(("new.", "scan-digests-")) else None


class Inputs(Faults):
    def test_a_pipe_or_device_is_refused_at_once_wherever_a_file_is_read(self):
        folder = self.fresh()
        os.mkfifo(f"{folder}/pipe")
        os.mkfifo(f"{folder}/pipe.sla")
        os.mkfifo(f"{folder}/lone.minisig")
        shutil.copy(f"{folder}/root.1", f"{folder}/lone")
        os.mkfifo(f"{folder}/poses.fifo")
        os.mkdir(f"{folder}/scans")
        for i in range(3):
            os.mkfifo(f"{folder}/scans/00000{i}.pcd")
        configs = {"scans": "mapping: {scans: scans}\n", "bag": "mapping: {scans: pipe}\n",
                   "poses": "mapping: {scans: town/mapping/scans, poses: poses.fifo}\n",
                   "errors": "mapping: {scans: town/mapping/scans}\nlocalization: {scans: town/drive_1/scans}\n"
                             "import-errors: {file: pipe, localizer: x}\n"}
        for name, text in configs.items():
            with open(f"{folder}/{name}.yaml", "w") as file:
                file.write(text)
        commands = ["compile pipe -o x", "compile scans.yaml -o x", "compile bag.yaml -o x", "compile poses.yaml -o x",
                    "compile errors.yaml -o x", "compile town/town.yaml --model pipe -o x", "train pipe -o x",
                    "inspect pipe", "verify pipe", "dump pipe --what sites", "dump pipe.sla", "diff pipe v1.slmap",
                    "diff v1.slmap pipe", "gate pipe", "gate v1.slmap --rules pipe", "gate v1.slmap --against pipe",
                    "gate v1.slmap --evaluation pipe", "delta pipe v1.slmap -o x", "delta v1.slmap pipe -o x",
                    "apply pipe --to v1.slmap", "apply 1-2.sldelta --to pipe", "strip pipe -o x", "recover pipe -o x",
                    "export pipe --format geojson -o x", "report pipe --map v1.slmap -o x",
                    "report town/town.yaml --map pipe -o x", "evaluate pipe --map v1.slmap",
                    "release pipe --fleet a --counter 1 -o x", "release v1.slmap --fleet a --counter 1 --after pipe -o x",
                    "release v1.slmap --fleet a --counter 1 --delta pipe pipe -o x",
                    "root --previous pipe --signer a.pub --threshold 1 -o x", "root --fleet a --signer pipe --threshold 1 -o x",
                    "sign pipe --key a.key", "sign root.1 --key pipe", "sign lone --key a.key",
                    "sign root.1 --key a.key --passphrase-file pipe", "key n --passphrase-file pipe",
                    "admit --root pipe release", "admit --root root.1 pipe", "admit --root root.1 lone",
                    "admit --root root.1 --next-root pipe", "admit --root root.1 --seen pipe release", "cache pipe"]
        for command in commands:
            for target in ("pipe", "/dev/zero", "/dev/null"):
                self.assert_refused_at_once([target if word == "pipe" else word for word in command.split()], folder)

    def assert_refused_at_once(self, words, folder):
        began = time.monotonic()
        done = self.sightline(*words, cwd=folder, stdin=subprocess.DEVNULL)
        self.assert_known(done, words)
        self.assertNotEqual(done.returncode, 0, words)
        self.assertLess(time.monotonic() - began, 20, words)
        self.assertFalse(os.path.exists(f"{folder}/x"), words)
        return done

    def test_a_pipe_or_device_is_refused_at_once_where_the_ending_says_what_it_is(self):
        folder = self.fresh()
        os.mkdir(f"{folder}/planned")
        endings = (".csv", ".db3", ".geojson", ".json", ".las", ".mcap", ".osm", ".pcap", ".pcd", ".ply", ".slmodel", ".slposes",
                   ".tum", ".xml", ".yaml")
        town = "compile town/town.yaml -o x --set"
        commands = [f"annotate v1.slmap -o x --route odd{ending}" for ending in (".csv", ".geojson", ".osm", ".tum")]
        commands += [f"annotate odd{ending} -o x --route everywhere --sensor hdl-64e" for ending in (".las", ".pcd", ".ply")]
        commands += [f"{town} mapping.scans=odd{ending}" for ending in (".db3", ".mcap", ".pcap", ".pcd")]
        commands += [f"{town} mapping.sensor=odd{ending}" for ending in (".csv", ".json", ".xml", ".yaml")]
        commands += [f"{town} mapping.poses=odd{ending}" for ending in (".csv", ".json", ".tum")]
        commands += [f"{town} mapping.stamps=odd.csv", f"{town} base.poses=odd.slposes", "train town/town.yaml odd.yaml -o x",
                     "compile town/town.yaml -o x --model odd.slmodel", "gate v1.slmap --rules odd.yaml",
                     "gate v1.slmap --evaluation odd.json", "report v1.slmap -o x --gate odd.json",
                     "export v1.slmap -o x --format lanelet2 --lanes odd.osm", "evaluate odd.yaml --map v1.slmap",
                     "status planned", "work planned --stage drives", "link planned -o x"]
        for kind in (os.mkfifo, lambda path: os.symlink("/dev/zero", path), lambda path: os.symlink("/dev/null", path)):
            paths = [f"{folder}/odd{ending}" for ending in endings] + [f"{folder}/planned/plan.json"]
            for path in paths:
                kind(path)
            for command in commands:
                self.assert_refused_at_once(command.split(), folder)
            for path in paths:
                os.remove(path)

    def test_training_opens_every_place_before_it_measures_one(self):
        folder = self.fresh()
        os.mkfifo(f"{folder}/odd.yaml")
        pathlib.Path(folder, "hole.yaml").write_text("mapping: {scans: town/nowhere}\n")
        for second in ("odd.yaml", "missing.yaml", "hole.yaml"):
            done = self.assert_refused_at_once(["train", "town/town.yaml", second, "-o", "x"], folder)
            self.assertNotIn("place town", done.stderr)

    def test_what_is_nested_deeply_is_refused(self):
        depth = 200_000
        texts = {"brackets.yaml": "[" * depth, "maps.yaml": "{a: " * depth,
                 "brackets.json": "[" * depth, "maps.json": '{"a":' * depth,
                 "closed.geojson": '{"type": "FeatureCollection", "features": ' + "[" * depth + "]" * depth + "}",
                 "maps.geojson": '{"a":' * depth, "open.osm": "<osm>" + "<node>" * depth,
                 "closed.osm": "<osm>" + "<node>" * depth + "</node>" * depth + "</osm>",
                 "bag/metadata.yaml": "[" * depth, "bag/drive.db3": "", "planned/plan.json": "[" * depth,
                 "apollo/config.xml": "<boost_serialization>" + "<a>" * depth, "apollo/map/000/north/x": ""}
        folder = self.fresh()
        for name, text in texts.items():
            path = pathlib.Path(folder, name)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        town = "compile town/town.yaml -o x"
        for command in ("compile brackets.yaml -o x", "compile maps.yaml -o x", f"{town} --set mapping.sensor=maps.yaml",
                        f"{town} --set mapping.sensor=brackets.json", f"{town} --set mapping.poses=brackets.json",
                        f"{town} --set mapping.scans=bag", f"{town} --model maps.json", "gate v1.slmap --rules brackets.yaml",
                        "gate v1.slmap --rules maps.yaml", "gate v1.slmap --evaluation maps.json",
                        "report v1.slmap -o x --gate maps.json", "annotate v1.slmap -o x --route maps.geojson",
                        "annotate v1.slmap -o x --route closed.geojson", "annotate v1.slmap -o x --route open.osm",
                        "annotate v1.slmap -o x --route closed.osm",
                        "export v1.slmap -o x --format lanelet2 --lanes closed.osm", "status planned",
                        "annotate apollo -o x --route everywhere --sensor hdl-64e"):
            self.assertRegex(self.assert_refused_at_once(command.split(), folder).stderr, "error SL[24]", command)

    def test_198_megabytes_of_comments_end_quickly(self):
        with open(f"{self.folder}/long.yaml", "w") as file:
            file.write("# nothing\n" * 19_800_000)
        for command in (("compile", "long.yaml", "-o", "x"), ("gate", f"{self.made}/v1.slmap", "--rules", "long.yaml")):
            began = time.monotonic()
            done = self.sightline(*command, cwd=self.folder)
            self.assert_known(done, command)
            self.assertIn("SL2020", done.stderr)
            self.assertLess(time.monotonic() - began, 5)

    def assert_takes_little_memory(self, command, **options):
        """It is refused or done before what has no end was read into memory."""
        def cap():
            resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30))

        done = self.sightline(*command, preexec_fn=cap, **options)
        self.assert_known(done, command)
        self.assertNotIn("SL8005", done.stderr, command)
        return done

    def test_a_line_without_end_is_not_read_to_its_end(self):
        drive = f"{self.folder}/drive"
        shutil.copytree(f"{self.made}/town/mapping/scans", f"{drive}/scans")
        for name in ("notes.csv", "readme.txt"):
            with open(f"{drive}/{name}", "w") as file:
                file.write("0")
                file.truncate(100_000_000_000)
        began = time.monotonic()
        done = self.assert_takes_little_memory(("init", drive, "-o", f"{self.folder}/drive.yaml"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertLess(time.monotonic() - began, 20)
        with open("/dev/zero", "rb") as endless:
            done = self.assert_takes_little_memory(("key", f"{self.folder}/k", "--passphrase-file", "-"), stdin=endless)
        self.assertIn("SL4009", done.stderr)

    def test_a_capture_of_nothing_ends_quickly(self):
        with open(f"{self.folder}/hole.pcap", "wb") as file:
            file.write(bytes.fromhex("d4c3b2a1020004000000000000000000ffff000001000000"))
            file.truncate(100_000_000_000)
        began = time.monotonic()
        for command in (("compile", f"{self.made}/town/town.yaml", "--set", f"mapping.scans={self.folder}/hole.pcap",
                         "-o", f"{self.folder}/x"), ("init", f"{self.folder}/hole.pcap")):
            done = self.sightline(*command)
            self.assert_known(done, command)
            self.assertEqual(done.returncode, 65, done.stderr)
        self.assertLess(time.monotonic() - began, 20)

    def assert_steers_no_terminal(self, command):
        done = subprocess.run([SETTINGS["sightline"], *command], cwd=self.folder, capture_output=True, timeout=60)
        FIGURES["cases"] += 1
        self.assertNotEqual(done.returncode, 0, command)
        for letter in (done.stdout + done.stderr).decode("utf-8"):  # raw bytes above 127 fail here
            self.assertTrue(letter in "\n\t" or " " <= letter < "\x7f" or letter >= "\xa0", (command, done.stderr))

    def test_what_a_file_says_steers_no_terminal(self):
        steer = "\x1b]0;gotcha\x07\x1b[2J\x9b31m\r"
        quoted = '"' + steer.encode("unicode_escape").decode() + '"'
        os.mkdir(f"{self.folder}/scans")
        with open(os.path.join(self.folder, "scans", f"scan{steer}.pcd"), "w") as file:
            file.write(steer)
        files = {"a.yaml": "mapping: {scans: scans}\n", "b.yaml": f"{quoted}: {{scans: scans}}\n",
                 "c.yaml": f"mapping: {{scans: {quoted}}}\n", "d.yaml": f"annotation: {{ranges_m: {quoted}}}\n",
                 "a.pcd": f"VERSION 0.7\nFIELDS {steer} y z\n", "a.ply": f"ply\nformat ascii 1.0\nelement {steer} 1\n",
                 "a.tum": f"{steer} 1 2 3 4 5 6 7\n", "a.csv": f"{steer},Elevation,Azimuth\n1,{steer},2\n",
                 "s.yaml": f"{quoted}: 1\n", "a.osm": f"<osm><node id='{steer}'/></osm>", "rules.yaml": f"{quoted}: 1\n",
                 "rule.yaml": f"rules: {{{quoted}: off}}\n", "a.json": f'{{"{steer}": 1}}', "plan.json": steer,
                 "root": f"sightline-root {steer}\n", "a.pub": steer, "bag/metadata.yaml":
                 f"rosbag2_bagfile_information:\n  relative_file_paths:\n    - {steer}.db3\n"}
        os.mkdir(f"{self.folder}/bag")
        for name, text in files.items():
            pathlib.Path(self.folder, name).write_text(text)
        town, made = f"{self.made}/town/town.yaml", self.made
        for words in ("a.yaml", "b.yaml", "c.yaml", "d.yaml", f"{town} --set mapping.poses=a.tum",
                      f"{town} --set mapping.stamps=a.tum", f"{town} --set mapping.sensor=s.yaml",
                      f"{town} --set mapping.sensor=a.csv", f"{town} --set mapping.scans=bag", f"{town} --model a.json"):
            self.assert_steers_no_terminal(["compile", *words.split(), "-o", "x", "--no-cache"])
        for words in ("annotate a.pcd --route everywhere --sensor hdl-64e -o x", "status .", "inspect a.json",
                      "annotate a.ply --route everywhere --sensor hdl-64e -o x", "admit --root root root",
                      f"annotate {made}/v1.slmap --route a.osm -o x", f"gate {made}/v1.slmap --rules rules.yaml",
                      f"gate {made}/v1.slmap --rules rule.yaml", f"gate {made}/v1.slmap --evaluation a.json",
                      f"export {made}/v1.slmap --format lanelet2 --lanes a.osm -o x", "init bag",
                      f"report {made}/v1.slmap --gate a.json -o x", "root --fleet a --signer a.pub --threshold 1 -o x"):
            self.assert_steers_no_terminal(words.split())
        for words in (["compile", steer, "-o", "x"], [steer], ["inspect", f"--{steer}"], ["help", steer]):
            self.assert_steers_no_terminal(words)

    def test_numbers_are_read_strictly(self):
        folder = self.fresh()
        for number in ("-1", "0", "18446744073709551616", "9" * 30, "1e3", "0x10", " 1", "1 ", "+1", "", "١"):
            count = number if number not in ("0", " 1", "1 ") else "0.0"  # those are counts in YAML
            for command in (("release", "v1.slmap", "--fleet", "a", "-o", "x", f"--counter={number}"),
                            ("root", "--fleet", "a", "--signer", "a.pub", "-o", "x", f"--threshold={number}"),
                            ("compile", "town/town.yaml", "-o", "x", "--set", f"measure-error.offset_count={count}"),
                            ("compile", "town/town.yaml", "-o", "x", f"--threads={number or 'x'}x")):
                done = self.sightline(*command, cwd=folder)
                self.assert_known(done, command)
                self.assertNotEqual(done.returncode, 0, command)
                self.assertFalse(os.path.exists(f"{folder}/x"), command)

    def test_a_counter_takes_no_great_step_unasked(self):
        folder = self.fresh()
        command = ("release", "v1.slmap", "--fleet", "town", "-o", "release", "--force", "--counter")
        for counter, status in (("1", 64), ("100002", 64), ("18446744073709551615", 64), ("100001", 0), ("100001", 64)):
            self.assertEqual(self.sightline(*command, counter, cwd=folder).returncode, status, counter)
        self.assertEqual(self.sightline(*command, "5", "--any-step", cwd=folder).returncode, 0)
        self.assertEqual(self.sightline("release", "v1.slmap", "--fleet", "town", "-o", "next", "--after", "release",
                                        "--counter", "5", cwd=folder).returncode, 64)


class Outputs(Faults):
    def test_only_regular_files_are_replaced(self):
        folder = self.fresh()
        with open(f"{folder}/victim", "w") as file:
            file.write("precious")
        for verb, words in VERBS.items():
            name = next((word[1:] for word in words if word.startswith(">")), None)
            if name is None or verb in ("apply", "rollback"):
                continue
            for kind in ("link", "dangling", "folder", "pipe", "device"):
                if kind in ("link", "folder") and verb in INTO_FOLDERS:
                    continue
                path = f"{folder}/target_{kind}"
                if kind == "device":
                    path = "/dev/null"
                elif not os.path.lexists(path):
                    {"link": lambda: os.symlink(f"{folder}/victim", path), "dangling": lambda: os.symlink("nowhere", path),
                     "folder": lambda: os.mkdir(path), "pipe": lambda: os.mkfifo(path)}[kind]()
                done = self.sightline(*[path if word.startswith(">") else word for word in words], cwd=folder)
                self.assert_known(done, (verb, kind))
                self.assertNotEqual(done.returncode, 0, (verb, kind))
        self.assertEqual(pathlib.Path(folder, "victim").read_text(), "precious")
        self.assertFalse(os.path.exists(f"{folder}/nowhere"))
        self.assertTrue(pathlib.Path("/dev/null").is_char_device())

    def test_output_that_does_not_fit_is_no_success(self):
        with open("/dev/full", "w") as full:
            done = subprocess.run([SETTINGS["sightline"], "inspect", f"{self.made}/v1.slmap"], stdout=full,
                                  stderr=subprocess.PIPE, text=True)
        self.assertEqual(done.returncode, 74, done.stderr)

    def test_a_full_disk_leaves_the_old_file_and_nothing_beside(self):
        for verb in VERBS:
            new = self.whole(verb)
            for i in range(TRIES):
                folder = self.fresh()
                limit = i * 120_000 // TRIES

                def small(size=limit):
                    signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
                    resource.setrlimit(resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))

                done = self.sightline(*self.words(verb), cwd=folder, preexec_fn=small)
                self.assert_known(done, (verb, limit))
                self.assert_old_or_new(self.inputs, new, contents(folder), (verb, limit), leftovers=verb.startswith("apply"))

    def test_little_memory_leaves_the_old_file_or_the_new(self):
        for verb in VERBS:
            new = self.whole(verb)
            for i in range(TRIES):  # from 100 MB to 1 GB
                folder = self.fresh()
                megabytes = round(100 * 10 ** (i / (TRIES - 1)))

                def little(size=megabytes):
                    resource.setrlimit(resource.RLIMIT_AS, (size << 20, size << 20))

                done = self.sightline(*self.words(verb), cwd=folder, preexec_fn=little)
                about = (verb, f"{megabytes} MB")
                self.assert_old_or_new(self.inputs, new, contents(folder), about)
                if done.returncode == 127:  # not even the libraries fit
                    continue
                self.assert_known(done, about)
                if done.returncode == 74:
                    self.assertIn("SL8005", done.stderr, about)

    def test_each_call_that_fails_in_turn(self):
        for verb in VERBS:
            environment = dict(os.environ, LD_PRELOAD=SETTINGS["failing"], SIGHTLINE_FAIL_COUNT=f"{self.folder}/count")
            new = self.whole(verb, env=environment)
            count = int(pathlib.Path(self.folder, "count").read_text())
            self.assertGreater(count, 2, f"{verb}: the calls are not counted")
            kinds = ((errno.EIO, False), (errno.ESTALE, True), (errno.ENOSPC, False))
            for number, is_done in kinds[:2 if TRIES <= 6 else 3]:
                self.fail_each_call(verb, new, count, number, is_done)

    def fail_each_call(self, verb, new, count, number, is_done):
        for call in range(count):
            folder = self.fresh()
            environment = dict(os.environ, LD_PRELOAD=SETTINGS["failing"], SIGHTLINE_FAIL_AT=str(call),
                               SIGHTLINE_FAIL_ERRNO=str(number))
            if is_done:
                environment["SIGHTLINE_FAIL_DONE"] = "1"
            done = self.sightline(*self.words(verb), cwd=folder, env=environment)
            about = (verb, errno.errorcode[number], call)
            self.assert_known(done, about)
            found = contents(folder)
            self.assert_old_or_new(self.inputs, new, found, about, leftovers=True)
            # An unlink that fails leaves its file; the next run removes it.
            if set(found) - set(new):
                self.sightline(*self.words(verb), cwd=folder)
                self.assertFalse([name for name in contents(folder) if ".sl-" in name], about)
                FIGURES["cleared"] += 1


class Kills(Faults):
    def test_kill_at_a_random_moment_leaves_the_old_file_or_the_new(self):
        chance = random.Random(20)
        for verb in VERBS:
            new = self.whole(verb)
            folder = self.fresh()
            began = time.monotonic()
            self.sightline(*self.words(verb), cwd=folder)
            usual = time.monotonic() - began
            for i in range(TRIES):
                folder = self.fresh()
                process = subprocess.Popen([SETTINGS["sightline"], *self.words(verb)], cwd=folder,
                                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                time.sleep(chance.uniform(0, usual))
                process.kill()
                process.wait()
                FIGURES["kills"] += 1
                self.assert_old_or_new(self.inputs, new, contents(folder), (verb, i), leftovers=True)
                again = self.sightline(*self.words(verb), cwd=folder)
                self.assert_known(again, (verb, i, "again"))
                found = contents(folder)
                self.assertFalse([name for name in found if ".sl-" in name], (verb, i))
                self.assert_old_or_new(new, new, found, (verb, i, "again"))


class Compiles(Faults):
    """Of one small town, in one cache."""

    def compile(self, out, *words, cache=None, **options):
        cached = ("--cache", cache) if cache else ("--no-cache",)
        return self.sightline("compile", f"{self.made}/town/town.yaml", "-o", out, "-q", "--threads", "1", *cached,
                              *words, **options)

    def expected(self):
        if not hasattr(Compiles, "bytes"):
            began = time.monotonic()
            done = self.compile(f"{self.folder}/plain.slmap")
            Compiles.usual_s = time.monotonic() - began
            self.assertEqual(done.returncode, 0, done.stderr)
            Compiles.bytes = pathlib.Path(f"{self.folder}/plain.slmap").read_bytes()
        return Compiles.bytes

    def finished_cache(self, *settings):
        """A cache of its own in which a compile of the town came to its end."""
        made = os.path.join(self.made, "_".join(("cache", *settings)))
        if not os.path.exists(made):
            done = self.compile(f"{self.folder}/cached.slmap", "--force", *settings, cache=made)
            self.assertEqual(done.returncode, 0, done.stderr)
        cache = tempfile.mkdtemp(dir=self.folder)
        shutil.copytree(made, cache, dirs_exist_ok=True)
        return cache

    def assert_same_map(self, out):
        self.assertTrue(pathlib.Path(out).read_bytes() == self.expected(), f"{out} is another map")

    def test_many_at_once_in_one_cache_make_the_same_map(self):
        self.expected()
        cache = f"{self.folder}/cache"
        os.mkdir(cache)
        foreign = [f"{cache}/mine.tmp", f"{cache}/build-ndt.sla.99.tmp", f"{cache}/.sl-elsewhere.1-{'0' * 32}-1-1-0"]
        for path in foreign:
            pathlib.Path(path).write_text("precious")
        results = [None] * int(os.environ.get("SIGHTLINE_COMPILES", "4"))

        def work(i):
            results[i] = self.compile(f"{self.folder}/{i}.slmap", cache=cache)

        threads = [threading.Thread(target=work, args=(i,)) for i in range(len(results))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for i, done in enumerate(results):
            self.assert_known(done, i)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertNotIn("cache file is not used", done.stderr)
            self.assert_same_map(f"{self.folder}/{i}.slmap")
        for path in foreign:
            self.assertEqual(pathlib.Path(path).read_text(), "precious")
        left = [name for name in os.listdir(cache) if name.startswith(".sl-") and "elsewhere" not in name]
        self.assertFalse(left)
        done = self.sightline("cache", cache, "--prune")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertFalse(os.path.exists(foreign[2]))
        self.assertTrue(os.path.exists(foreign[0]) and os.path.exists(foreign[1]))

    def test_killed_compiles_go_on_to_the_same_map(self):
        chance = random.Random(7)
        self.expected()
        cache, out = f"{self.folder}/cache", f"{self.folder}/out.slmap"
        for _ in range(TRIES):
            process = subprocess.Popen(
                [SETTINGS["sightline"], "compile", f"{self.made}/town/town.yaml", "-o", out, "-q", "--force", "--cache",
                 cache], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep(chance.uniform(0, self.usual_s / 2))  # which one thread takes
            process.kill()
            process.wait()
            FIGURES["kills"] += 1
            if os.path.exists(out):
                self.assert_same_map(out)
                os.remove(out)
                shutil.rmtree(cache)
        done = self.compile(out, "--force", cache=cache)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assert_same_map(out)
        self.assertFalse([name for name in os.listdir(cache) if name.startswith(".sl-")])

    def test_neither_locale_nor_zone_nor_clock_shows_in_the_map(self):
        self.expected()
        subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", f"{self.folder}/de_DE.UTF-8"], check=True)
        german = {"LOCPATH": self.folder, "LC_ALL": "de_DE.UTF-8", "LANG": "de_DE.UTF-8", "TZ": "Asia/Kathmandu"}
        jumps = {"LD_PRELOAD": SETTINGS["jumping_clock"]}
        out, cache = f"{self.folder}/out.slmap", f"{self.folder}/cache"
        for surroundings in (german, jumps, jumps):  # at last everything is found in the cache
            done = self.compile(out, "--force", cache=cache if surroundings is jumps else None,
                                env=os.environ | surroundings)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assert_same_map(out)

    def test_objects_that_are_swapped_or_damaged_are_made_anew(self):
        cache, out = self.finished_cache(), f"{self.folder}/out.slmap"
        shutil.copytree(self.finished_cache("--set", "build-ndt.cell_m=1.0"), cache, dirs_exist_ok=True)
        by_pass = collections.defaultdict(list)
        for path in sorted(pathlib.Path(cache).glob("*.sla")):
            by_pass[path.name[:-37]].append(path)
        swapped = 0
        for paths in by_pass.values():
            if len(paths) == 2:
                first, second = (path.read_bytes() for path in paths)
                paths[0].write_bytes(second)
                paths[1].write_bytes(first)
                swapped += 2
            else:
                damaged = bytearray(paths[0].read_bytes())
                damaged[len(damaged) // 2] ^= 1
                paths[0].write_bytes(damaged)
        self.assertGreater(swapped, 4)
        FIGURES["objects"] += swapped
        done = self.compile(out, "--force", cache=cache)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("SL4008", done.stderr)
        self.assertIn("SL4004", done.stderr)
        self.assert_same_map(out)

    @staticmethod
    def sealed_as(path, content):
        """An object as compiler/store/cache.h writes it, of other content: who may write can seal anything."""
        old = path.read_bytes()
        kind_size = int.from_bytes(old[-40:-36], "little")
        kind_and_key = old[len(old) - 80 - kind_size:-48]
        body = content + kind_and_key + len(content).to_bytes(8, "little") + old[-40:-36]
        return body + hashlib.sha256(body).digest() + old[-4:]

    def test_a_forged_object_is_found_by_compiling_again(self):
        cache, out = self.finished_cache(), f"{self.folder}/out.slmap"
        config = f"{self.made}/town/town.yaml"
        pathlib.Path(out).write_bytes(self.expected())
        self.assertEqual(self.sightline("verify", out, "--deep", "--again", config).returncode, 0)
        mine = {path.name[:-37]: path for path in pathlib.Path(cache).glob("*.sla")}
        other = self.finished_cache("--set", "build-ndt.cell_m=1.0")
        theirs = next(pathlib.Path(other).glob("pack-nds-*.sla")).read_bytes()
        content = theirs[:int.from_bytes(theirs[-48:-40], "little")]
        mine["pack-nds"].write_bytes(self.sealed_as(mine["pack-nds"], content))
        done = self.compile(out, "--force", cache=cache)
        self.assert_known(done, "forged")
        self.assertNotEqual(pathlib.Path(out).read_bytes(), self.expected(), "the forged object is not used")
        found = self.sightline("verify", out, "--deep", "--again", config)
        self.assertEqual(found.returncode, 67, found.stderr)
        self.assertIn("SL4004", found.stderr)

    def test_pipes_links_and_folders_in_the_cache_end_nothing(self):
        cache, out = self.finished_cache(), f"{self.folder}/out.slmap"
        victim = pathlib.Path(self.folder, "victim")
        victim.write_text("precious")
        pathlib.Path(out).write_bytes(self.expected())
        for i, path in enumerate(sorted(pathlib.Path(cache).glob("*.*"))):
            if not path.is_file():
                continue
            path.unlink()
            (lambda: os.mkfifo(path), lambda: os.symlink(victim, path), lambda: os.mkdir(path))[i % 3]()
        done = self.compile(out, "--force", cache=cache)
        self.assert_known(done, "hostile cache")
        self.assertEqual(victim.read_text(), "precious")
        self.assert_same_map(out)

    def test_memory_that_ends_has_a_code(self):
        for i in range(TRIES):  # from 100 MB to 1 GB
            megabytes = round(100 * 10 ** (i / (TRIES - 1)))

            def little(size=megabytes):
                resource.setrlimit(resource.RLIMIT_AS, (size << 20, size << 20))

            done = self.compile(f"{self.folder}/out.slmap", "--force", preexec_fn=little)
            if done.returncode == 127:  # not even the libraries fit
                continue
            self.assert_known(done, f"{megabytes} MB")
            if done.returncode == 0:
                self.assert_same_map(f"{self.folder}/out.slmap")
            else:
                self.assertIn("SL8005", done.stderr, megabytes)

    def test_a_scan_of_100_gigabytes_of_nothing(self):
        folder = f"{self.folder}/hole"
        shutil.copytree(f"{self.made}/town/mapping", folder)
        os.truncate(f"{folder}/scans/000002.pcd", 100_000_000_000)
        with open(f"{self.folder}/hole.yaml", "w") as file:
            file.write("mapping: {scans: hole/scans, poses: hole/poses.tum}\n")
        with open(f"{self.folder}/empty.yaml", "w") as file:
            file.truncate(100_000_000_000)
        for config in ("hole.yaml", "empty.yaml"):
            def cap():
                resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))

            done = self.sightline("compile", config, "-o", "x", "--no-cache", cwd=self.folder, preexec_fn=cap)
            self.assert_known(done, config)
            self.assertNotEqual(done.returncode, 0, config)


if __name__ == "__main__":
    SETTINGS.update(zip(("sightline", "town", "maps", "failing", "jumping_clock"), map(os.path.abspath, sys.argv[1:6])))
    unittest.main(argv=sys.argv[:1] + sys.argv[6:], verbosity=2)
