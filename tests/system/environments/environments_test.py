"""Where people run the program: caches and folders that cannot be written, file systems that lack calls, machines of
which a process may use a part, signals, closed streams, terminals that only print lines. What can be done without is
done without, with one warning; what cannot is refused before the passes; the map has the same bytes.

Tests that need rights (mounts, control groups) are skipped by name without them.

usage: environments_test.py SIGHTLINE TOWN WRITE_FLEET_MAPS LACKING_CALLS SOURCES [unittest arguments]
"""

import contextlib
import errno
import json
import os
import pathlib
import pty
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

SETTINGS = {}
UNPRIVILEGED = 65534
LFS_POINTER = "version https://git-lfs.github.com/spec/v1\noid sha256:" + 64 * "a" + "\nsize 4242\n"
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


def as_another_user():
    """In the child: somebody who may read what root made, and not write it."""
    if os.geteuid() == 0:
        os.setgroups([])
        os.setgid(UNPRIVILEGED)
        os.setuid(UNPRIVILEGED)


def may_mount():
    return subprocess.run(["unshare", "-m", "true"], capture_output=True).returncode == 0


def group_folder(controller):
    """Of control groups of version 1 or 2, where a new group has this controller; none where that is not allowed."""
    for folder in (f"/sys/fs/cgroup/{controller}", "/sys/fs/cgroup"):
        path = pathlib.Path(folder, f"sightline-test-{os.getpid()}")
        try:
            path.mkdir()
        except OSError:
            continue
        names = {"cpu": ("cpu.cfs_quota_us", "cpu.max"), "memory": ("memory.limit_in_bytes", "memory.max")}[controller]
        if any((path / name).exists() for name in names):
            return path
        path.rmdir()
    return None


def needs(condition, what):
    return unittest.skipUnless(condition, f"needs the right to {what}")


class Environments(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = tempfile.mkdtemp(prefix="environments_")
        os.chmod(cls.root, 0o755)
        cls.town = f"{cls.root}/town"
        subprocess.run([SETTINGS["town"], "--seed", "3", "--length-m", "40", "--spacing-m", "2", "--drives", "1", "--output",
                        cls.town], check=True, capture_output=True)
        cls.config = f"{cls.town}/town.yaml"
        pathlib.Path(cls.config).write_text(CONFIG)
        cls.cache, cls.map = f"{cls.root}/cache", f"{cls.root}/plain.slmap"
        done = cls.compile(cls.map, "--cache", cls.cache)
        assert done.returncode == 0, done.stderr
        cls.bytes = pathlib.Path(cls.map).read_bytes()

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.root)

    @classmethod
    def compile(cls, out, *words, **options):
        return cls.sightline("compile", cls.config, "-o", out, *words, **options)

    @staticmethod
    def sightline(*words, **options):
        options.setdefault("env", dict(os.environ, NO_COLOR="1"))
        return subprocess.run([SETTINGS["sightline"], *words], capture_output=True, text=True, errors="replace", timeout=300,
                              stdin=subprocess.DEVNULL, **options)

    def setUp(self):
        """A folder that another user may write."""
        self.folder = tempfile.mkdtemp(dir=self.root)
        os.chmod(self.folder, 0o777)
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.out = f"{self.folder}/out.slmap"

    def warm_cache(self):
        cache = f"{self.folder}/warm"
        shutil.copytree(self.cache, cache)
        return cache

    def assert_made(self, done, out=None):
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(pathlib.Path(out or self.out).read_bytes() == self.bytes, "another map")

    def assert_refused_at_once(self, done, *words):
        """Before the first pass."""
        self.assertEqual(done.returncode, 74, done.stderr)
        for word in words:
            self.assertIn(word, done.stderr)
        self.assertNotIn("ingest", done.stderr)
        self.assertFalse(list(pathlib.Path(self.folder).rglob(".sl-*")))

    def lacking(self, names, number):
        return dict(os.environ, NO_COLOR="1", LD_PRELOAD=SETTINGS["lacking"], SIGHTLINE_LACKS=names,
                    SIGHTLINE_LACKS_ERRNO=str(number))


class Caches(Environments):
    def read_only(self, folder):
        for path in (pathlib.Path(folder), *pathlib.Path(folder).rglob("*")):
            os.chmod(path, 0o555 if path.is_dir() else 0o444)
        self.addCleanup(lambda: [os.chmod(path, 0o755) for path in (folder, *map(str, pathlib.Path(folder).rglob("*")))
                                 if os.path.isdir(path)])

    def test_a_warm_cache_that_may_only_be_read_is_used(self):
        cache = self.warm_cache()
        self.read_only(cache)
        done = self.compile(self.out, "--cache", cache, preexec_fn=as_another_user)
        self.assert_made(done)
        self.assertEqual(done.stderr.count("the cache cannot be written"), 1, done.stderr)
        self.assertIn("from the cache", done.stderr)

    def test_a_compile_without_a_place_for_its_cache_goes_on(self):
        self.read_only(self.town)
        for words in (("--dry-run",), ()):
            done = self.compile(self.out, *words, preexec_fn=as_another_user)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(done.stderr.count("the cache cannot be written"), 1, done.stderr)
            self.assertIn("--cache", done.stderr)
            self.assertIn("--no-cache", done.stderr)
        self.assert_made(done)

    def test_a_finished_plan_of_another_user_is_linked(self):
        plan = f"{self.folder}/plan"
        self.assertEqual(self.sightline("cluster", "plan", self.config, "-o", plan).returncode, 0)
        for stage in ("drives", "graph", "tiles", "sites", "learn"):
            done = self.sightline("cluster", "work", plan, "--stage", stage)
            self.assertEqual(done.returncode, 0, done.stderr)
        self.read_only(plan)
        done = self.sightline("cluster", "link", plan, "-o", self.out, preexec_fn=as_another_user)
        self.assert_made(done)
        done = self.sightline("cluster", "work", plan, "--stage", "learn", preexec_fn=as_another_user)
        self.assertIn(done.returncode, (0, 74), done.stderr)

    def test_work_that_cannot_be_stored_is_no_success(self):
        plan = f"{self.folder}/plan"
        self.assertEqual(self.sightline("cluster", "plan", self.config, "-o", plan).returncode, 0)
        self.read_only(plan)
        done = self.sightline("cluster", "work", plan, "--stage", "drives", preexec_fn=as_another_user)
        self.assertEqual(done.returncode, 74, done.stderr)

    def test_a_cache_that_is_removed_meanwhile(self):
        cache = self.warm_cache()
        read, write = os.pipe()
        process = subprocess.Popen([SETTINGS["sightline"], "compile", self.config, "-o", self.out, "-q", "--cache", cache,
                                    "--set", "train-model.trees=6", f"--json-progress={write}"], pass_fds=(write,),
                                   stderr=subprocess.PIPE, text=True)
        os.close(write)
        with os.fdopen(read) as events:
            next(events)
            shutil.rmtree(cache, ignore_errors=True)
            for _ in events:
                pass
        error = process.communicate()[1]
        self.assertEqual(process.returncode, 0, error)
        self.assertTrue(os.path.exists(self.out))

    @needs(may_mount(), "mount")
    def test_a_cache_whose_disk_is_full_costs_a_warning(self):
        cache = f"{self.folder}/small"
        os.mkdir(cache)
        done = subprocess.run(["unshare", "-m", "sh", "-c", f"mount -t tmpfs -o size=64k none {cache} && exec \"$@\"", "sh",
                               SETTINGS["sightline"], "compile", self.config, "-o", self.out, "--cache", cache],
                              capture_output=True, text=True, timeout=300)
        self.assert_made(done)
        self.assertEqual(done.stderr.count("the cache cannot be written"), 1, done.stderr)
        self.assertIn("SL8004", done.stderr)


class Outputs(Environments):
    @needs(may_mount(), "mount")
    def test_an_output_that_is_a_mount_point_is_refused_before_the_passes(self):
        for name in ("outside", "out.slmap"):
            pathlib.Path(self.folder, name).write_text("precious")
        mount = f"mount --bind {self.folder}/outside {self.out} && exec \"$@\""
        done = subprocess.run(["unshare", "-m", "sh", "-c", mount, "sh", SETTINGS["sightline"], "compile", self.config, "-o",
                               self.out, "--force", "--cache", self.cache], capture_output=True, text=True)
        self.assert_refused_at_once(done, "SL8003", "mounted")
        self.assertEqual(pathlib.Path(self.folder, "outside").read_text(), "precious")

    def test_a_name_that_is_too_long_for_map_or_provenance_is_refused_before_the_passes(self):
        for length in (240, 250, 300):
            name = "n" * length + ".slmap"
            done = self.compile(f"{self.folder}/{name}", "--cache", self.cache)
            self.assert_refused_at_once(done, "SL8003", "File name too long")
            done = self.compile(f"{self.folder}/new/{name}", "--cache", self.cache)
            self.assert_refused_at_once(done, "SL8003", "File name too long")

    def test_a_folder_that_cannot_be_made_is_named(self):
        done = self.sightline("export", self.map, "--format", "csv", "-o", "/proc/tables")
        self.assertEqual(done.returncode, 74, done.stderr)
        self.assertIn("/proc", done.stderr)

    def test_files_that_cannot_be_synced_are_written_with_one_warning(self):
        for number in (errno.EINVAL, errno.ENOTSUP, errno.ENOSYS):
            done = self.compile(self.out, "--force", "--cache", self.warm_cache(), env=self.lacking("fsync", number))
            self.assert_made(done)
            self.assertEqual(done.stderr.count("cannot sync files"), 1, done.stderr)
            shutil.rmtree(f"{self.folder}/warm")
        done = self.compile(self.out, "--force", "--no-cache", env=self.lacking("fsync", errno.EIO))
        self.assertEqual(done.returncode, 74, done.stderr)

    def test_a_rename_that_cannot_refuse_is_done_without(self):
        for number in (errno.EOPNOTSUPP, errno.EPERM, errno.ENOSYS, errno.EINVAL):
            done = self.compile(self.out, "--cache", self.cache, env=self.lacking("renameat2", number))
            self.assert_made(done)
            self.assertEqual(done.stderr.count("cannot rename without replacing"), 1, done.stderr)
            done = self.compile(self.out, "--cache", self.cache, env=self.lacking("renameat2", number))
            self.assertEqual(done.returncode, 64, "the check before still refuses")
            os.remove(self.out)

    def test_an_update_without_locks_is_made(self):
        subprocess.run([SETTINGS["maps"], self.folder], check=True, capture_output=True)
        run = lambda *words, **options: self.sightline(*words, cwd=self.folder, **options)
        self.assertEqual(run("delta", "make", "v1.slmap", "v2.slmap", "-o", "d.sldelta").returncode, 0)
        for number in (errno.ENOLCK, errno.ENOTSUP, errno.ENOSYS):
            shutil.copy(f"{self.folder}/v1.slmap", f"{self.folder}/m.slmap")
            pathlib.Path(self.folder, "m.slmap.part").write_text("of another process")
            done = run("delta", "apply", "d.sldelta", "--to", "m.slmap", env=self.lacking("flock", number))
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(done.stderr.count("has no locks"), 1, done.stderr)
            self.assertEqual(pathlib.Path(self.folder, "m.slmap").read_bytes(),
                             pathlib.Path(self.folder, "v2.slmap").read_bytes())

    def test_a_replaced_file_keeps_its_mode_and_group(self):
        group = 12345 if os.geteuid() == 0 else os.getegid()
        for mode in (0o664, 0o600, 0o640):
            pathlib.Path(self.out).write_text("old")
            os.chown(self.out, -1, group)
            os.chmod(self.out, mode)
            done = self.compile(self.out, "--force", "--cache", self.cache)
            self.assert_made(done)
            found = os.stat(self.out)
            self.assertEqual((found.st_mode & 0o777, found.st_gid), (mode, group))

    def test_a_map_that_is_a_pointer_of_git_lfs_is_named(self):
        pointer = f"{self.folder}/town.slmap"
        pathlib.Path(pointer).write_text(LFS_POINTER)
        for words in (("inspect", pointer), ("verify", pointer), ("gate", pointer), ("diff", self.map, pointer),
                      ("export", pointer, "--format", "geojson", "-o", f"{self.folder}/x.json"),
                      ("report", pointer, "-o", f"{self.folder}/x.html"), ("dump", pointer, "--what", "sites"),
                      ("delta", "apply", pointer, "--to", self.map), ("compile", self.config, "-o", self.out, "--model", pointer)):
            done = self.sightline(*words)
            self.assertIn(done.returncode, (65, 2), (words, done.stderr))
            self.assertIn("SL2003 git-lfs-pointer", done.stderr, words)
            self.assertIn("git lfs pull", done.stderr, words)

    def test_a_checkout_that_git_does_not_read_is_a_warning_of_the_build(self):
        script = f"{SETTINGS['sources']}/compiler/package/write_commit.cmake"
        checkout = f"{self.folder}/checkout"
        subprocess.run(["git", "init", "-q", checkout], check=True)
        command = ["cmake", "-D", f"SOURCE={checkout}", "-D", f"OUTPUT={self.folder}/commit.h", "-P", script]
        done = subprocess.run(command, capture_output=True, text=True,
                              env=dict(os.environ, GIT_TEST_ASSUME_DIFFERENT_OWNER="1"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("Warning", done.stderr)
        self.assertIn("dubious ownership", " ".join(done.stderr.split()))
        self.assertIn("unknown", pathlib.Path(self.folder, "commit.h").read_text())
        shutil.rmtree(f"{checkout}/.git")  # an archive of the sources
        done = subprocess.run(command, capture_output=True, text=True, env=dict(os.environ, GIT_DIR="/nowhere"))
        self.assertEqual(done.stderr, "")


class Machine(Environments):
    def expected(self, **options):
        done = self.compile(self.out, "--cache", self.cache, "--dry-run", "--format", "json", **options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def test_processors_are_those_of_the_affinity(self):
        first = min(os.sched_getaffinity(0))
        self.assertEqual(self.expected(preexec_fn=lambda: os.sched_setaffinity(0, {first}))["threads"], 1)
        done = self.compile(self.out, "-q", "--no-cache", "--threads", "4", preexec_fn=lambda: os.sched_setaffinity(0, {first}))
        self.assert_made(done)
        self.assertNotIn("TBB", done.stderr)

    def test_one_thread_is_one_thread(self):
        process = subprocess.Popen([SETTINGS["sightline"], "compile", self.config, "-o", self.out, "-q", "--no-cache",
                                    "--threads", "1"], stdout=subprocess.DEVNULL)
        most = 0
        while process.poll() is None:
            with contextlib.suppress(OSError):
                most = max(most, len(os.listdir(f"/proc/{process.pid}/task")))
            time.sleep(0.01)
        self.assertEqual(process.returncode, 0)
        self.assertEqual(most, 1)

    @contextlib.contextmanager
    def group(self, controller, values):
        folder = group_folder(controller)
        if folder is None:
            self.skipTest(f"needs the right to make control groups with {controller}")
        try:
            for name, value in values.items():
                if (folder / name).exists():
                    (folder / name).write_text(value)
            yield lambda: (folder / "cgroup.procs").write_text(str(os.getpid()))
        finally:
            folder.rmdir()

    def test_processors_are_at_most_the_quota_of_control_groups(self):
        with self.group("cpu", {"cpu.cfs_quota_us": "50000", "cpu.max": "50000 100000"}) as join:
            self.assertEqual(self.expected(preexec_fn=join)["threads"], 1)

    def test_free_memory_is_at_most_that_of_control_groups(self):
        limit = str(256 << 20)
        with self.group("memory", {"memory.limit_in_bytes": limit, "memory.max": limit}) as join:
            done = self.compile(self.out, "--cache", self.cache, "--dry-run", preexec_fn=join)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertRegex(done.stdout, r"memory  about [0-9]+ MiB; [0-9]+ MiB free")

    def test_threads_that_are_refused_are_done_without(self):
        for number in (errno.EPERM, errno.EAGAIN):
            done = self.compile(self.out, "--force", "--no-cache", env=self.lacking("thread", number))
            self.assert_made(done)
            done = self.compile(self.out, "--force", "--no-cache", "--threads", "3", env=self.lacking("thread", number))
            if done.returncode != 0:
                self.assertIn("thread", done.stderr)
                self.assertNotIn("not enough memory", done.stderr)

    def start(self, *words, **options):
        """A compile that has begun: its first event was read."""
        read, write = os.pipe()
        process = subprocess.Popen([SETTINGS["sightline"], "compile", self.config, "-o", self.out, "-q", "--no-cache",
                                    f"--json-progress={write}", *words], pass_fds=(write,), stdout=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE, text=True, **options)
        os.close(write)
        events = os.fdopen(read)
        next(events)
        self.addCleanup(events.close)
        return process

    def test_an_interrupt_ends_the_program_by_the_signal_and_a_request_to_stop_as_incomplete(self):
        for number, status in ((signal.SIGINT, -signal.SIGINT), (signal.SIGTERM, 75)):
            process = self.start()
            process.send_signal(number)
            error = process.communicate()[1]
            self.assertEqual(process.returncode, status, error)
            self.assertIn("SL7001 interrupted", error)

    def test_a_signal_that_is_ignored_at_the_start_stays_so(self):
        process = self.start(preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN))
        process.send_signal(signal.SIGINT)
        error = process.communicate()[1]
        self.assertEqual(process.returncode, 0, error)

    def test_closed_streams_do_not_become_files(self):
        for closed in (">&-", "2>&-", "<&-", ">&- 2>&- <&-"):
            done = subprocess.run(["sh", "-c", f"exec \"$@\" {closed}", "sh", SETTINGS["sightline"], "compile", self.config,
                                   "-o", self.out, "--force", "--cache", self.cache], capture_output=True, text=True)
            self.assert_made(done)

    def on_terminal(self, kind):
        child, terminal = pty.fork()
        if child == 0:
            os.environ.pop("NO_COLOR", None)
            os.environ["TERM"] = kind
            os.execv(SETTINGS["sightline"], ["sightline", "compile", self.config, "-o", self.out, "--force", "--no-cache"])
        shown = b""
        with contextlib.suppress(OSError):
            while piece := os.read(terminal, 65536):
                shown += piece
        os.close(terminal)
        self.assertEqual(os.waitpid(child, 0)[1], 0, shown)
        return shown

    def test_memory_that_ends_inside_zstd_is_no_damage_of_the_map(self):
        sound = self.sightline("verify", self.map)
        self.assertEqual(sound.returncode, 0, sound.stderr)
        done = self.sightline("verify", self.map, env=self.lacking("memory-of-zstd", errno.ENOMEM))
        self.assertIn("SL8005", done.stderr)
        self.assertNotIn("SL4", done.stderr)
        self.assertEqual(done.returncode, 74, done.stderr)

    def test_a_terminal_that_only_prints_lines_gets_lines(self):
        self.assertIn(b"\x1b[", self.on_terminal("xterm"))
        shown = self.on_terminal("dumb")
        self.assertNotIn(b"\x1b", shown)
        self.assertNotRegex(shown, rb"\r[^\n]")


class Clauses(Environments):
    """Refusals that come first, not after hours."""

    def assert_refused_first(self, done, status, *words):
        self.assertEqual(done.returncode, status, done.stderr)
        self.assertNotIn("ingest", done.stderr)
        for word in words:
            self.assertIn(word, done.stderr)

    def test_a_version_that_cannot_be_printed_is_refused_before_the_passes(self):
        for key in ("version", "map_id"):
            done = self.compile(self.out, "--no-cache", "--set", f"emit-map.{key}=two words")
            self.assert_refused_first(done, 64, f"emit-map.{key}", "two words")

    def test_a_map_cannot_be_a_folder(self):
        done = self.compile(f"{self.folder}/NEW/", "--no-cache")
        self.assertNotEqual(done.returncode, 0)
        self.assert_refused_first(done, done.returncode, "NEW")

    def test_coordinates_beyond_the_earth_need_a_world(self):
        poses = pathlib.Path(f"{self.town}/mapping/poses.tum").read_text().splitlines()
        moved = f"{self.folder}/poses.tum"
        for far, is_fine in ((2e7, False), (5e6, True)):
            rows = [row.split() for row in poses]
            pathlib.Path(moved).write_text("".join(
                " ".join([row[0], repr(float(row[1]) + far), *row[2:]]) + "\n" for row in rows if row and row[0] != "#"))
            done = self.compile(self.out, "--no-cache", "--stop-after", "ingest", "--set", f"mapping.poses={moved}")
            if is_fine:
                self.assertEqual(done.returncode, 0, done.stderr)
            else:
                self.assert_refused_first(done, 64, "SL1004", "annotation.world")

    def test_init_of_a_folder_without_end_ends(self):
        began = time.monotonic()
        done = self.sightline("init", "/proc", "-o", f"{self.folder}/drive.yaml")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("SL", done.stderr)
        self.assertLess(time.monotonic() - began, 60)

    def test_stop_after_ends_every_verb_well(self):
        for words in (("train", self.config, "-o", f"{self.folder}/x.slmodel"),
                      ("export", self.config, "--format", "pcd", "-o", f"{self.folder}/x.pcd"),
                      ("dump", self.config, "--what", "nds"), ("tune", self.config),
                      ("compile", self.config, "-o", self.out)):
            done = self.sightline(*words, "--stop-after", "ingest", "--cache", self.cache)
            self.assertIn(done.returncode, (0, 64), (words, done.stderr))


if __name__ == "__main__":
    SETTINGS.update(zip(("sightline", "town", "maps", "lacking", "sources"), map(os.path.abspath, sys.argv[1:6])))
    unittest.main(argv=sys.argv[:1] + sys.argv[6:], verbosity=2)
