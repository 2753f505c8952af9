"""Hostile names of recordings, configurations, maps and folders, with every verb and every format that writes them:
no raw control character, no abort, no key and no command that a name dictates. Prints the counts.
By default those names alone that contain all the others' parts; SIGHTLINE_NAMES=all: all names, some minutes;
SIGHTLINE_NAMES="quotes,C1": these.

usage: names_test.py SIGHTLINE TOWN [unittest arguments]
"""

import collections
import csv
import inspect
import io
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unicodedata
import unittest
import xml.etree.ElementTree

SETTINGS = {}
COUNTS = collections.Counter()
KNOWN = (0, 1, 2, 64, 65, 66, 67, 68, 69, 74, 75)
MARKS = "\u2028\u2029\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069\u200e\u200f\u061c"
BINARY = (".slmap", ".slmodel", ".sldelta", ".gpkg", ".pcd", ".ply", ".bt", ".slposes")

# As bytes, since one is no UTF-8. A slash cannot be in a name.
NAMES = {
    "plain": b"drive",
    "line end": b"a\n::error title=hacked::x\ninjected: 1\n- injected: 2",
    "carriage return": b"a\r::error title=hacked::x",
    "escape": b"a\x1b[2J\x1b]0;hacked\x07b",
    "C1": "a\u009b31m\u0085b".encode(),
    "line separator": "a\u2028::error title=hacked::x\u2029b".encode(),
    "turned around": "a\u202exyz\u2066b\u200f".encode(),
    "quotes": b"a\"b'c`d\\e",
    "not UTF-8": b"a\xff\xfe\xc3b",
    "255 bytes": b"n" * 255,
    "script": b"<script>alert(1)<!-- ]]> &amp; <b",
    "command": b"::error title=hacked::x ##[error]y",
    "formula": b"=cmd|' calc'!A1",
    "markdown": b"[x](javascript:1) | ![y](z) *b* @all `c`",
    "yaml": b"{injected: 1, &a *b # c",
    "shell": b"$(touch hacked) ; touch hacked && `touch hacked` %s %n {x}",
    "everything": b"=a\n::error title=hacked::x\ninjected: 1\r\x1b[2J\xc2\x9b\xe2\x80\xa8\xe2\x80\xae\xff<script>alert(1)"
                  b"\"'\\`touch hacked`|##[error]y",
}
USUAL = ("command", "everything")


def chosen_names():
    wanted = os.environ.get("SIGHTLINE_NAMES", ",".join(USUAL))
    return NAMES if wanted == "all" else {kind: NAMES[kind] for kind in wanted.split(",")}


CONFIG = """
mapping: {scans: overridden}
annotation: {ranges_m: [10, 30], looks: paper, world: "utm:32N"}
measure-error: {offset_count: 2, reference: known}
train-model: {trees: 5}
build-surface: {cell_m: 1.0}
cast-rays: {azimuth_count: 180}
remove-moving: {carve_range_m: 30}
"""


def is_control(letter):
    return (unicodedata.category(letter) == "Cc" and letter not in "\n\t") or letter in MARKS


def keys_of(value):
    if isinstance(value, dict):
        for key, inner in value.items():
            yield key
            yield from keys_of(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from keys_of(inner)


class Names(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = tempfile.mkdtemp(prefix="names_").encode()
        cls.town = os.path.join(cls.root, b"town")
        subprocess.run([SETTINGS["town"], "--seed", "3", "--length-m", "40", "--spacing-m", "2", "--drives", "2",
                        "--origin-m", "456500,5429500", "--output", cls.town], check=True, capture_output=True)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.root)
        counts = COUNTS
        print("names:", len(chosen_names()), " runs of verbs:", counts["runs"], " texts looked at:", counts["texts"],
              " raw control characters:", counts["controls"], " aborts:", counts["aborts"], " keys injected:", counts["keys"],
              " commands injected:", counts["commands"])

    def place(self, name):
        """A folder of this name, whose recordings, configuration and maps have it too."""
        folder = os.path.join(self.root, b"w", name)
        os.makedirs(folder)
        self.addCleanup(shutil.rmtree, os.path.join(self.root, b"w"), ignore_errors=True)
        for role in (b"mapping", b"drive_1", b"drive_2"):
            os.makedirs(os.path.join(folder, role))
            shutil.copytree(os.path.join(self.town, role, b"scans"), os.path.join(folder, role, name))
            shutil.copy(os.path.join(self.town, role, b"poses.tum"), os.path.join(folder, role, b"poses.tum"))
        return folder

    def run_verb(self, *words, where):
        words = [word if isinstance(word, bytes) else word.encode() for word in words]
        done = subprocess.run([SETTINGS["sightline"].encode(), *words], cwd=where, capture_output=True, timeout=300,
                              stdin=subprocess.DEVNULL, env={**os.environ, "NO_COLOR": "1"})
        COUNTS["runs"] += 1
        about = (words, done.returncode, done.stderr[-400:])
        if done.returncode not in KNOWN:
            COUNTS["aborts"] += 1
            self.fail(f"abort: {about}")
        form = "github" if b"--github" in words or b"github" in words else "text"
        self.look_at(done.stderr, "text", about)
        self.look_at(done.stdout, form, about)
        return done

    def look_at(self, raw, form, about):
        COUNTS["texts"] += 1
        try:
            text = raw.decode("utf-8")
        except UnicodeDecodeError as error:
            COUNTS["controls"] += 1
            self.fail(f"not UTF-8: {error} {about}")
        bad = [letter for letter in text if is_control(letter)]
        COUNTS["controls"] += len(bad)
        self.assertFalse(bad, about)
        if form == "page":  # no log: a CI service reads no commands in it
            return text
        for line in text.split("\n"):
            is_command = line.lstrip().startswith("::") and form != "github" or "##[" in line
            if is_command or re.match(r"\s*::\w+ title=hacked", line):
                COUNTS["commands"] += 1
                self.fail(f"command {line!r}: {about}")
        return text

    def look_at_file(self, path):
        raw = pathlib.Path(os.fsdecode(path)).read_bytes()
        ending = os.path.splitext(path)[1].decode(errors="replace")
        if ending in BINARY or raw.startswith(b"\x1f\x8b"):
            return
        text = self.look_at(raw, "page" if ending == ".html" else "github" if path.endswith(b"github.txt") else "text", path)
        if ending in (".json", ".geojson", ".sarif"):
            self.assert_no_key(list(keys_of(json.loads(text))), path)
        elif ending == ".csv":
            rows = list(csv.reader(line for line in io.StringIO(text) if not line.startswith("#")))
            self.assertLessEqual(len({len(row) for row in rows}), 1, path)
            self.assert_no_key([cell for row in rows for cell in row if cell.startswith(("=", "@"))], path, "=")
        elif ending in (".xml", ".osm", ".svg"):
            tree = xml.etree.ElementTree.fromstring(text)
            self.assert_no_key([element.tag for element in tree.iter()], path, "script")
        elif ending in (".html", ".md"):
            self.assert_no_key(["script"] if "<script>alert" in text else [], path, "script")
        elif ending in (".yaml", ".yml"):
            self.assert_no_key([line.split(":")[0].strip(" -") for line in text.splitlines()], path)

    def assert_no_key(self, found, about, wanted="injected"):
        bad = [key for key in found if key.startswith(wanted)]
        COUNTS["keys"] += len(bad)
        self.assertFalse(bad, about)

    def test_every_name_with_every_verb_and_format(self):
        for kind, name in chosen_names().items():
            with self.subTest(kind):
                self.cross(name)

    def cross(self, name):
        where = self.place(name)
        cache = os.path.join(self.root, b"cache")
        short = name[:200]
        config, map_file, old = short + b".yaml", short + b".slmap", short + b"-old.slmap"
        pathlib.Path(os.fsdecode(os.path.join(where, config))).write_text(CONFIG)

        def drive(role, key):
            folder = os.path.join(where, role)
            return [b"--set", key + b".scans=" + os.path.join(folder, name), b"--set",
                    key + b".poses=" + os.path.join(folder, b"poses.tum")]

        drives = drive(b"mapping", b"mapping") + drive(b"drive_1", b"localization")
        judged = drives + drive(b"drive_2", b"evaluation")
        run = lambda *words: self.run_verb(*words, where=where)
        made = run("compile", config, "-o", map_file, "--cache", cache, "--tables", *drives)
        self.assertEqual(made.returncode, 0, made.stderr)
        run("compile", config, "-o", old, "--cache", cache, "--format", "json", "--set", "emit-map.release=2", *drives)
        run("compile", config, "-o", map_file, "--cache", cache, "--dry-run", "--explain", *drives)
        run("compile", config, "-o", map_file, "--list-inputs", *drives)
        run("init", where, "-o", b"written.yaml", "--no-schema")
        run("inspect", map_file)
        for words in (["--all"], ["--site", "0"], ["--format", "json"], ["--format", "json", "-o", "inspect.json"]):
            run("inspect", map_file, *words)
        for what in ("sites", "ranges", "recordings"):
            for form in ("csv", "json", "text"):
                run("dump", map_file, "--what", what, "--format", form, "-o", f"{what}-{form}.{form}")
        run("dump", config, "--what", "drive", "--format", "text", "--cache", cache, *drives)
        for form, ending in (("geojson", ".geojson"), ("csv", ""), ("gpkg", ".gpkg"), ("cells", ".csv")):
            run("export", map_file, "--format", form, "-o", f"export-{form}{ending}")
        for form, ending in (("pcd", ".pcd"), ("ply", ".ply"), ("autoware", "")):
            run("export", config, "--format", form, "-o", f"points-{form}{ending}", "--cache", cache, *drives)
        run("report", map_file, "-o", b"page.html")
        run("report", config, "--map", map_file, "-o", b"page-2.html", "--cache", cache, *drives)
        run("verify", map_file)
        run("verify", map_file, "--deep", "--format", "json", "-o", "verify.json")
        run("evaluate", config, "--map", map_file, "--cache", cache, *judged)
        run("evaluate", config, "--map", map_file, "--cache", cache, "--format", "json", "-o", "evaluation.json", *judged)
        for form in ("text", "json"):
            run("localize", config, "--map", map_file, "--map", old, "--format", form, *judged)
            run("localize", config, "--map", map_file, "-o", short + f".{form}.csv".encode(), "--format", form, *judged)
            run("tune", config, "--cache", cache, "--scans", "2", "--format", form, "-o", f"tune.{form}", *drives)
        for form, ending in (("text", "txt"), ("json", "json"), ("markdown", "md"), ("geojson", "geojson")):
            run("diff", old, map_file, "--format", form, "-o", f"diff.{ending}")
        run("diff", old, map_file)
        run("gate", map_file, "--all")
        run("gate", map_file, "--against", old, "--evaluation", "evaluation.json", "--json", "gate.json", "--sarif",
            "gate.sarif", "--junit", "gate.xml", "--markdown", "gate.md", "--github")
        run("weak", map_file, "--places", "0")
        run("cluster", "plan", config, "-o", name[:100] + b"-plan", *drives)
        for engine in ("make", "slurm", "snakemake"):
            run("cluster", "plan", config, "-o", name[:100] + b"-plan", "--force", "--emit", engine, *drives)
        run("cluster", "status", name[:100] + b"-plan")
        run("train", config, "-o", short + b".slmodel", "--cache", cache, *drives)
        run("inspect", short + b".slmodel")
        run("cache", cache)
        run("strip", map_file, "-o", b"bare.slmap")
        run("recover", map_file, "-o", b"found.slmap")
        run("delta", "make", old, map_file, "-o", b"d.sldelta")
        run("annotate", b"points-pcd.pcd", "--route", os.path.join(where, b"mapping", b"poses.tum"), "-o", b"drawn.slmap",
            "--set", b"annotation.world=" + name.replace(b"\n", b" "), "--set", "annotation.ranges_m=10,30")
        for words in (["key", short], ["root", "--fleet", short, "--signer", short + b".pub", "--threshold", "1", "-o", b"root"],
                      ["release", map_file, "--fleet", short, "--counter", "1", "-o", b"release"],
                      ["sign", b"release", "--key", short + b".key"], ["sign", b"root", "--key", short + b".key"],
                      ["admit", b"release", "--root", b"root", "--present", map_file],
                      ["admit", b"release", "--root", b"root", "--map", map_file, "--format", "json"]):
            run("fleet", *words)
        for wrong in ("inspect", "verify", "gate"):  # names in messages
            run(wrong, name[:200] + b".none")
        run("compile", name[:200] + b".none", "-o", b"x.slmap")
        run("compile", config, "-o", map_file, "--cache", cache, "--set", b"mapping.scans=" + name)
        for path in pathlib.Path(os.fsdecode(where)).rglob("*"):
            if path.is_file() and path.suffix not in (".tum", ".sla") and b"scans" not in os.fsencode(path.parent):
                if os.fsencode(path.parent.name) != name or path.parent == pathlib.Path(os.fsdecode(where)):
                    self.look_at_file(os.fsencode(path))
        self.assertFalse(os.path.exists(os.path.join(where, b"hacked")))

    def test_no_verb_is_missing(self):
        listed = re.findall(r"^  (\w+)  +[A-Z]", self.run_verb("help", where=self.root).stdout.decode(), re.MULTILINE)
        text = inspect.getsource(Names.cross)
        without_names = {"passes", "completion", "man", "help"}
        self.assertGreater(len(listed), 20)
        self.assertFalse([verb for verb in listed if verb not in without_names and f'"{verb}"' not in text])


if __name__ == "__main__":
    SETTINGS.update(zip(("sightline", "town"), map(os.path.abspath, sys.argv[1:3])))
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2)
