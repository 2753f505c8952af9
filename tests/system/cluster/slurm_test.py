"""The script of `sightline cluster plan --emit slurm` on a Slurm of two nodes, one of which is lost while its task is at work.

usage: slurm_test.py SIGHTLINE TOWN      exit 77: skipped, because no Slurm is installed or it cannot start here
"""

import os
import pathlib
import sys
import tempfile
import time
import unittest

sys.dont_write_bytecode = True
from shared_town import SharedCompile, Town, contents  # noqa: E402
from slurm_cluster import CannotStart, SlurmCluster  # noqa: E402

SETTINGS = {}
SKIPPED = 77
SHARES = 4
LONGEST_S = 240


class Slurm(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="slurm_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.folder.chmod(0o755)  # munged looks at the folders above its socket too
        self.slurm = SlurmCluster(self.folder / "slurm")
        self.slurm.__enter__()
        self.addCleanup(self.slurm.__exit__)

    def submit(self):
        """A plan, and its script handed to Slurm: the number of the last job."""
        self.shared = SharedCompile(SETTINGS["town"], self.folder / "plan")
        script = self.folder / "city.sh"
        script.write_text(self.shared.make_plan("--emit", "slurm", "--shares", SHARES).stdout)
        done = self.slurm.run("bash", script, "--mem=1G")
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.strip()

    def tasks(self):
        """Stage, state and node of each task that Slurm has not finished."""
        lines = self.slurm.run("squeue", "-h", "-r", "-o", "%j %T %N").stdout.splitlines()
        return [(words[0].removeprefix("sightline-"), words[1], words[2] if len(words) > 2 else "")
                for words in map(str.split, lines)]

    def wait(self, what, is_so):
        end = time.monotonic() + LONGEST_S
        while not is_so():
            if time.monotonic() > end:
                self.fail(f"{what}: {self.tasks()}\n{self.slurm.log()}\n{self.work_logs()}")
            time.sleep(0.05)

    def work_logs(self):
        return "".join(f"== {path.name}\n{path.read_text(errors='replace')[-2000:]}\n"
                       for path in sorted((self.shared.plan / "log").glob("*")))

    def wait_for_a_task_at_work(self, stage, node):
        """Until a task of the stage runs on the node and has written something."""
        running = (stage, "RUNNING", node)
        before = None

        def is_at_work():
            nonlocal before
            if running not in self.tasks():
                before = None
                return False
            if before is None:
                before = len(contents(self.shared.store))
            return len(contents(self.shared.store)) > before

        self.wait(f"no task of {stage} on {node}", is_at_work)

    def assert_same_map_in_the_end(self, last_job):
        self.wait("jobs do not end", lambda: not self.tasks())
        state = self.slurm.run("scontrol", "show", "job", last_job).stdout
        self.assertIn("JobState=COMPLETED", state, self.work_logs())
        self.assertTrue((self.shared.plan / "map.slmap").read_bytes() == SETTINGS["expected"], "another map")

    def was_requeued(self):
        return any(word.startswith("Restarts=") and word != "Restarts=0"
                   for word in self.slurm.run("scontrol", "show", "job").stdout.split())

    def test_a_node_that_dies_with_its_task(self):
        last_job = self.submit()
        self.wait_for_a_task_at_work("tiles", "n2")
        self.assertGreaterEqual(self.slurm.kill_node("n2"), 3, "slurmd, what starts the task, the task")
        self.assert_same_map_in_the_end(last_job)
        self.assertTrue(self.was_requeued())
        self.assertNotIn("idle", self.slurm.run("sinfo", "-h", "-n", "n2", "-o", "%T").stdout)

    def test_a_node_that_is_lost_while_its_task_goes_on(self):
        last_job = self.submit()
        self.wait_for_a_task_at_work("tiles", "n2")
        self.slurm.kill_daemon("n2")
        self.assert_same_map_in_the_end(last_job)


def main():
    program, write_town = map(os.path.abspath, sys.argv[1:3])
    with tempfile.TemporaryDirectory(prefix="slurm_made_") as made:
        try:
            os.chmod(made, 0o755)
            with SlurmCluster(f"{made}/try"):
                pass
        except CannotStart as reason:
            print("skipped: Slurm cannot start:", reason)
            return SKIPPED
        SETTINGS["town"] = Town(program, write_town, f"{made}/town", spacing_m=1)
        SETTINGS["expected"] = SETTINGS["town"].compiled(f"{made}/expected.slmap")
        return 0 if unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2, exit=False).result.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
