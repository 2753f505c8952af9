"""One compile by many processes: plan, work, link, status. Whoever works, in any order and however often it is ended, the
map has the bytes of one `sightline compile`.

usage: shared_work_test.py SIGHTLINE TOWN [unittest arguments]
SIGHTLINE_KILLS=50 in the environment ends so many workers by each signal (default: 3).
"""

import json
import os
import pathlib
import random
import shutil
import signal
import sys
import tempfile
import time
import unittest

sys.dont_write_bytecode = True
from shared_town import STAGES, SharedCompile, Town, contents  # noqa: E402

SETTINGS = {}
KILLS = int(os.environ.get("SIGHTLINE_KILLS", "3"))
INPUT, INCOMPLETE = 65, 75

# A step of each stage without which the next one cannot begin.
NEEDED = {"drives": "ingest", "graph": "estimate-trajectory", "tiles": "build-ndt", "sites": "compute-factors",
          "learn": "choose-ranges"}


class SharedWork(unittest.TestCase):
    """All cases share a town, the map of one compile of it, and a plan whose work is finished."""

    @classmethod
    def make(cls, folder):
        cls.made = folder
        cls.town = Town(SETTINGS["sightline"], SETTINGS["town"], f"{folder}/town")
        cls.expected = cls.town.compiled(f"{folder}/expected.slmap")
        cls.finished = SharedCompile(cls.town, f"{folder}/plan")
        cls.finished.make_plan()
        cls.usual_s = {}
        for stage in STAGES:
            began = time.monotonic()
            cls.finished.work(stage)
            cls.usual_s[stage] = time.monotonic() - began

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="shared_")
        self.addCleanup(shutil.rmtree, self.folder)
        self.plans = 0

    def fresh(self, *words, **options):
        self.plans += 1
        shared = SharedCompile(self.town, f"{self.folder}/plan_{self.plans}")
        shared.make_plan(*words, **options)
        return shared

    def copy_of_finished(self):
        self.plans += 1
        shared = SharedCompile(self.town, f"{self.folder}/plan_{self.plans}")
        shutil.copytree(self.finished.plan, shared.plan)
        return shared

    def assert_links_to(self, expected, shared, about=""):
        out = f"{shared.plan}.slmap"
        shared.link(out)
        self.assertTrue(pathlib.Path(out).read_bytes() == expected, f"another map: {about}")
        os.remove(out)

    def assert_incomplete(self, done, step):
        self.assertEqual(done.returncode, INCOMPLETE, done.stderr)
        self.assertIn("SL7002 work-missing", done.stderr)
        self.assertIn(step, done.stderr)

    def assert_refused(self, done, *names):
        self.assertEqual(done.returncode, INPUT, done.stderr)
        for name in ("SL2022", *names):
            self.assertIn(name, done.stderr)


class Shares(SharedWork):
    def test_one_process_with_one_thread_or_eight(self):
        self.assert_links_to(self.expected, self.finished, "1 thread")
        shared = self.fresh()
        shared.all_stages(threads=8)
        self.assert_links_to(self.expected, shared, "8 threads")

    def test_shares_in_any_order(self):
        chance = random.Random(11)
        for count in (1, 2, 7):
            shared = self.fresh()
            for stage in STAGES:
                shares = [f"{k}/{count}" for k in range(1, count + 1)]
                chance.shuffle(shares)
                for worker in [shared.start(stage, share) for share in shares]:
                    _, printed = worker.communicate()
                    self.assertEqual(worker.returncode, 0, printed)
            self.assert_links_to(self.expected, shared, f"{count} shares")

    def test_two_workers_on_the_same_share(self):
        shared = self.fresh()
        for stage in STAGES:
            for worker in [shared.start(stage, "1/2") for _ in range(2)]:
                _, printed = worker.communicate()
                self.assertEqual(worker.returncode, 0, printed)
        self.assert_links_to(self.expected, shared)

    def test_a_given_model_and_a_map_of_several_days(self):
        model = f"{self.made}/expected.slmap"
        options = ("--model", model)
        expected = self.town.compiled(f"{self.folder}/one.slmap", *options, config=self.town.config_of_two_days)
        shared = self.fresh(*options, config=self.town.config_of_two_days)
        for stage in STAGES:
            for worker in [shared.start(stage, f"{k}/3") for k in (3, 1, 2)]:
                _, printed = worker.communicate()
                self.assertEqual(worker.returncode, 0, printed)
        self.assert_links_to(expected, shared)
        self.assertNotEqual(expected, self.expected)

    def test_a_finished_stage_is_not_done_again(self):
        # Times of files say when they were used last; what is written again is another file.
        before = {path: path.stat().st_ino for path in self.finished.store.rglob("*") if path.is_file()}
        self.finished.all_stages()
        for path, written in before.items():
            if path.suffix == ".sla":
                self.assertEqual(path.stat().st_ino, written, f"{path.name} was written again")

    def test_a_worker_begins_with_its_share(self):
        for share, first in (("1/3", 0), ("2/3", 1), ("3/3", 2)):
            shared = self.copy_of_finished()
            for path in shared.store.glob("compute-factors*"):
                shutil.rmtree(path) if path.is_dir() else path.unlink()
            shared.work("sites", share)
            parts = list(shared.store.glob("compute-factors.parts/*.sla"))
            self.assertEqual(len(parts), 3)
            earliest = min(parts, key=lambda path: path.stat().st_mtime_ns).stem.removeprefix("compute-factors-")
            self.assertEqual(self.keys_of_parts(shared)[first][: len(earliest)], earliest)

    def keys_of_parts(self, shared):
        """In their order, as the pass reported them: three digests, and then the seal."""
        (printed,) = shared.store.glob("compute-factors-*.slp")
        return [printed.read_bytes()[32 * part : 32 * part + 32].hex() for part in range(3)]

    def test_workers_may_be_called_from_anywhere(self):
        os.mkdir(f"{self.folder}/elsewhere")
        self.town.sightline("cluster", "plan", "town.yaml", "-o", f"{self.folder}/plan", cwd=self.town.folder)
        shared = SharedCompile(self.town, f"{self.folder}/plan")
        shared.work("drives", cwd="/")
        self.town.sightline("cluster", "work", "../plan", "--stage", "graph", cwd=f"{self.folder}/elsewhere")


class Ends(SharedWork):
    def ended_by(self, number, expected_status):
        """Workers, some of them with another at work beside them, are ended at random moments."""
        chance = random.Random(number)
        ended = 0
        while ended < KILLS:
            shared, kept = self.fresh(), {}
            for stage in STAGES:
                status = expected_status
                while status != 0:
                    share = chance.randint(1, 3)
                    beside = shared.start(stage, f"{share % 3 + 1}/3") if chance.random() < 0.3 else None
                    worker = shared.start(stage, f"{share}/3")
                    if ended < KILLS:
                        time.sleep(chance.uniform(0, self.usual_s[stage]))
                        worker.send_signal(number)
                    _, printed = worker.communicate()
                    status = worker.returncode
                    if status != -number or printed:  # else it ended before it could know of the signal
                        self.assertIn(status, (0, expected_status), printed)
                    ended += status == expected_status
                    if beside:
                        _, printed = beside.communicate()
                        self.assertEqual(beside.returncode, 0, printed)
                    kept = self.assert_nothing_lost(shared, kept)
            self.assert_links_to(self.expected, shared, f"{ended} ended")
        return ended

    def assert_nothing_lost(self, shared, kept):
        """What was finished once stays as it is."""
        found = {name: digest for name, digest in contents(shared.store).items()
                 if not os.path.basename(name).startswith(".sl-") and not name.endswith(".last")}
        for name, digest in kept.items():
            self.assertEqual(found.get(name), digest, f"{name} changed or is gone")
        return found

    def test_by_kill(self):
        print(self.ended_by(signal.SIGKILL, -signal.SIGKILL), "workers killed", file=sys.stderr)

    def test_by_the_machine_that_asks_to_stop(self):
        print(self.ended_by(signal.SIGTERM, INCOMPLETE), "workers asked to stop", file=sys.stderr)


class Store(SharedWork):
    def objects(self, shared):
        return sorted(shared.store.rglob("*.sla"))

    def assert_made_again(self, shared, spoilt):
        """Whether link sees it or not, the map is the same once the stages ran again."""
        out = f"{shared.plan}.slmap"
        done = shared.link(out, ok=False)
        self.assertIn(done.returncode, (0, INCOMPLETE), done.stderr)
        if done.returncode == 0:
            self.assertTrue(pathlib.Path(out).read_bytes() == self.expected, f"another map: {spoilt}")
            os.remove(out)
        else:
            self.assertIn("SL7002", done.stderr)
            self.assertFalse(os.path.exists(out))
        shared.all_stages()
        self.assert_links_to(self.expected, shared, spoilt)

    @staticmethod
    def change_a_byte(path, chance):
        found = bytearray(path.read_bytes())
        found[chance.randrange(len(found))] ^= 1 << chance.randrange(8)
        path.write_bytes(found)

    def test_an_object_that_was_changed_is_made_again(self):
        chance = random.Random(5)
        shared = self.copy_of_finished()
        for path in chance.sample(self.objects(shared), KILLS):
            self.change_a_byte(path, chance)
            self.assert_made_again(shared, path.name)

    def test_an_object_that_was_removed_is_made_again(self):
        chance = random.Random(6)
        shared = self.copy_of_finished()
        for path in chance.sample(self.objects(shared), KILLS):
            path.unlink()
            self.assert_made_again(shared, path.name)

    def test_a_store_of_which_every_file_was_changed(self):
        chance = random.Random(7)
        shared = self.copy_of_finished()
        for name in contents(shared.store):
            self.change_a_byte(shared.store / name, chance)
        self.assert_made_again(shared, "all")

    def test_a_store_that_is_gone(self):
        shared = self.copy_of_finished()
        shutil.rmtree(shared.store)
        self.assert_incomplete(shared.link(f"{self.folder}/out.slmap", ok=False), "ingest")


class Order(SharedWork):
    def test_a_stage_waits_for_the_one_before_and_says_for_what(self):
        shared = self.fresh()
        for i, stage in enumerate(STAGES):
            for later in STAGES[i + 1:]:
                self.assert_incomplete(shared.work(later, ok=False), NEEDED[stage])
            self.assert_incomplete(shared.link(f"{self.folder}/out.slmap", ok=False), NEEDED["learn"])
            self.assertFalse(os.path.exists(f"{self.folder}/out.slmap"))
            shared.work(stage)
        self.assert_links_to(self.expected, shared)

    def test_status_counts_what_is_there(self):
        shared = self.fresh()
        finished = set()
        for stage in (None, *STAGES):
            if stage:
                shared.work(stage)
                finished.add(stage)
            steps = json.loads(self.town.sightline("cluster", "status", shared.plan, "--format", "json").stdout)
            self.assertEqual({step["stage"] for step in steps}, set(STAGES))
            for step in steps:
                self.assertEqual(step["is_done"], step["stage"] in finished, step)
                self.assertLessEqual(step["parts_there"], step["parts"], step)
            for needed in NEEDED.values():
                self.assertIn(needed, [step["step"] for step in steps])
        self.assertIn("compute-factors", self.town.sightline("cluster", "status", shared.plan).stdout)


class Changes(SharedWork):
    def setUp(self):
        super().setUp()
        copy = f"{self.folder}/town"
        shutil.copytree(self.town.folder, copy)
        self.mine = Town.__new__(Town)
        self.mine.__dict__.update(self.town.__dict__, folder=pathlib.Path(copy), config=pathlib.Path(copy, "town.yaml"))
        self.shared = SharedCompile(self.mine, f"{self.folder}/plan")
        self.shared.make_plan()
        self.shared.work("drives")

    def assert_all_refuse(self, *names):
        self.assert_refused(self.shared.work("drives", ok=False), *names)
        self.assert_refused(self.shared.work("sites", ok=False), *names)
        self.assert_refused(self.shared.link(f"{self.folder}/out.slmap", ok=False), *names)

    def test_another_configuration_is_refused(self):
        text = self.mine.config.read_text()
        self.mine.config.write_text(text + "# A remark changes nothing.\n")
        self.shared.work("drives")
        self.mine.config.write_text(text + "build-ndt: {cell_m: 2.5}\n")
        self.assert_all_refuse("configuration")
        self.mine.config.write_text(text)
        self.shared.work("drives")

    def test_another_recording_is_refused(self):
        scan = sorted((self.mine.folder / "mapping/scans").iterdir())[3]
        whole = scan.read_bytes()
        found = bytearray(whole)
        found[-2] ^= 1
        scan.write_bytes(found)
        self.assert_all_refuse("'mapping'")
        scan.write_bytes(whole)
        self.shared.work("drives")
        sorted((self.mine.folder / "drive_1/scans").iterdir())[-1].unlink()
        self.assert_all_refuse("'localization'")


if __name__ == "__main__":
    SETTINGS.update(zip(("sightline", "town"), map(os.path.abspath, sys.argv[1:3])))
    with tempfile.TemporaryDirectory(prefix="shared_made_") as made:
        SharedWork.make(made)
        unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2)
