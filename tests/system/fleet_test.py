"""examples/fleet as a fleet would run it: nginx on loopback, a vehicle with curl, and attackers.

usage: fleet_test.py SIGHTLINE WRITE_FLEET_MAPS EXAMPLES_FLEET FIND_NGINX FOLDER [unittest arguments]
(FOLDER is where an nginx is unpacked that is not installed; exits 77 where no nginx can be had)
"""

import hashlib
import http.server
import os
import pathlib
import resource
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest

NOW = "2026-11-21T08:00:00Z"
LATER = "2027-06-01T00:00:00Z"  # every release has expired by then, the root has not
SETTINGS = {}  # paths, from the command line


def run(*command, ok=True, **options):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, **options)
    if ok and done.returncode != 0:
        raise AssertionError(f"{command}: {done.returncode}\n{done.stdout}{done.stderr}")
    return done


def sha256(path):
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class EndlessServer:
    """Serves a folder, but never stops sending one file: without a length, or saying a modest one is coming."""

    def __init__(self, folder, endless_name):
        class Handler(http.server.SimpleHTTPRequestHandler):
            sent = 0

            def __init__(self, *arguments):
                super().__init__(*arguments, directory=folder)

            def do_GET(self):
                if os.path.basename(self.path) != endless_name:
                    super().do_GET()
                    return
                self.send_response(200)
                self.end_headers()
                try:
                    while True:
                        self.wfile.write(b"x" * 65536)
                        Handler.sent += 65536
                except OSError:
                    pass  # the vehicle hung up

            def log_message(self, *_):
                pass

        self.handler = Handler
        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.url = f"http://127.0.0.1:{self.server.server_port}"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def close(self):
        self.server.shutdown()
        self.server.server_close()


class Fleet(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.made = tempfile.mkdtemp(prefix="fleet_made_")
        run(SETTINGS["write_maps"], cls.made)
        for name in ("alice", "bob", "carol", "dave", "mallory"):
            run(SETTINGS["sightline"], "fleet", "key", f"{cls.made}/{name}")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.made)

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="fleet_")
        self.site = f"{self.folder}/site"
        self.state = f"{self.folder}/vehicle"
        os.mkdir(self.site)
        os.mkdir(self.state)
        self.nginx = None
        self.serve()
        # All cases of a class begin alike.
        begun = f"{self.made}/begun"
        if not os.path.exists(begun):
            self.begin()
            for folder in (self.site, self.state):
                shutil.copytree(folder, f"{begun}/{os.path.basename(folder)}")
        else:
            shutil.copytree(begun, self.folder, dirs_exist_ok=True)

    def begin(self):
        self.root("root.1", ["alice", "bob"], ["alice", "bob"])
        shutil.copy(f"{self.site}/root.1", f"{self.state}/root")

    def tearDown(self):
        self.stop()
        shutil.rmtree(self.folder)

    # The fleet's side.

    def serve(self, bytes_per_second=0):
        self.stop()
        port = free_port()
        self.url = f"http://127.0.0.1:{port}"
        self.nginx = subprocess.Popen(
            [f"{SETTINGS['fleet']}/serve", self.site, str(port), f"{self.folder}/nginx", str(bytes_per_second)],
            env=dict(os.environ, NGINX_PROGRAM=SETTINGS["nginx"]))
        for _ in range(500):
            try:
                socket.create_connection(("127.0.0.1", port), 1).close()
                return
            except OSError:
                time.sleep(0.02)
        raise AssertionError("nginx does not answer")

    def stop(self):
        if self.nginx:
            self.nginx.terminate()
            self.nginx.wait()

    def access_log(self):
        with open(f"{self.folder}/nginx/access.log") as file:
            return file.read()

    def sign(self, record, signers):
        if os.path.exists(record + ".minisig"):
            os.remove(record + ".minisig")
        for signer in signers:
            run(SETTINGS["sightline"], "fleet", "sign", record, "--key", f"{self.made}/{signer}.key")

    def root(self, name, keys, signers, previous=None):
        flags = sum((["--signer", f"{self.made}/{key}.pub"] for key in keys), [])
        flags += ["--previous", f"{self.site}/{previous}"] if previous else ["--fleet", "metropolis"]
        run(SETTINGS["sightline"], "fleet", "root", *flags, "--threshold", 2, "--expires", "2028-01-01T00:00:00Z", "-o",
            f"{self.site}/{name}")
        self.sign(f"{self.site}/{name}", signers)

    def release(self, version, counter, signers=("alice", "bob"), base=None, expires="2026-12-01T00:00:00Z",
                flags=()):
        shutil.copy(f"{self.made}/v{version}.slmap", self.site)
        flags = list(flags)
        if base:
            if not HAS_DELTA:
                self.skipTest("this program has no verb `delta`")
            delta = f"{self.site}/v{base}-{version}.sldelta"
            run(SETTINGS["sightline"], "delta", "make", f"{self.made}/v{base}.slmap", f"{self.made}/v{version}.slmap", "-o",
                delta)
            flags += ["--delta", f"{self.made}/v{base}.slmap", delta]
        run(SETTINGS["sightline"], "fleet", "release", f"{self.site}/v{version}.slmap", "--fleet", "metropolis", "--counter",
            counter, "--expires", expires, *flags, "-o", f"{self.site}/release", "--force")
        self.sign(f"{self.site}/release", signers)

    def change_release(self, change, signers=("alice", "bob")):
        """What signers could be brought to sign: the record with lines changed by hand."""
        path = f"{self.site}/release"
        with open(path) as file:
            text = change(file.read())
        with open(path, "w") as file:
            file.write(text)
        if signers:
            self.sign(path, signers)

    def name_file(self, path):
        """The record names another file, with its right size and digest."""
        shutil.copy(path, self.site)
        line = f"map {os.path.basename(path)} {os.path.getsize(path)} {sha256(path)}"
        self.change_release(lambda text: "\n".join(
            line if old.startswith("map ") else old for old in text.split("\n")))

    # The vehicle's side.

    def vehicle(self, verb="update", url=None, now=NOW, environment=None, **options):
        return run(f"{SETTINGS['fleet']}/vehicle", verb, self.state, url or self.url, ok=False,
                   env=dict(os.environ, SIGHTLINE=SETTINGS["sightline"], SIGHTLINE_NOW=now, **(environment or {})),
                   **options)

    def assert_has(self, version):
        self.assertEqual(sha256(f"{self.state}/map.slmap"), sha256(f"{self.made}/v{version}.slmap"))

    def assert_updates(self, version, **options):
        done = self.vehicle(**options)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assert_has(version)
        return done

    def assert_refuses(self, code, status, **options):
        """With this code and status, and the map stays what it was."""
        before = sha256(f"{self.state}/map.slmap") if os.path.exists(f"{self.state}/map.slmap") else None
        done = self.vehicle(**options)
        self.assertIn(code, done.stderr)
        self.assertEqual(done.returncode, status, done.stderr)
        after = sha256(f"{self.state}/map.slmap") if os.path.exists(f"{self.state}/map.slmap") else None
        self.assertEqual(before, after)

    def start_with(self, version, counter=1):
        self.release(version, counter)
        self.assert_updates(version)


class Updates(Fleet):
    def test_a_new_vehicle_takes_the_whole_map_and_then_a_delta(self):
        self.start_with(1)
        self.release(2, 2, base=1)
        self.assert_updates(2)
        log = self.access_log()
        self.assertIn("v1-2.sldelta", log)
        self.assertNotIn("v2.slmap", log, "the delta alone travels")
        self.assertEqual(sha256(f"{self.state}/map.slmap.previous"), sha256(f"{self.made}/v1.slmap"))
        self.assertIn("up to date", self.assert_updates(2).stdout)

    def test_rolls_back_and_does_not_take_the_same_release_again(self):
        self.start_with(1)
        self.release(2, 2)
        self.assert_updates(2)
        self.assertEqual(self.vehicle("rollback").returncode, 0)
        self.assert_has(1)
        self.assertIn("rolled back here", self.assert_updates(1).stdout)
        self.assertNotEqual(self.vehicle("rollback").returncode, 0, "there is nothing further back")
        self.release(3, 3)
        self.assert_updates(3)

    def test_follows_rotated_keys_and_forgets_the_old_ones(self):
        self.start_with(1)
        self.root("root.2", ["bob", "carol"], ["alice", "bob", "carol"], previous="root.1")
        self.release(2, 2, signers=["bob", "carol"])
        self.assert_updates(2)
        self.release(3, 3, signers=["alice", "bob"])
        self.assert_refuses("SL5002", 68)

    def test_a_root_that_old_signers_did_not_sign_is_refused(self):
        self.start_with(1)
        self.root("root.2", ["carol", "mallory"], ["carol", "mallory"], previous="root.1")
        self.assert_refuses("SL5001 wrong-key", 68)

    def test_a_download_that_was_killed_goes_on_where_it_stopped(self):
        self.release(1, 1)
        size = os.path.getsize(f"{self.site}/v1.slmap")
        self.serve(bytes_per_second=size // 4)
        process = subprocess.Popen(
            [f"{SETTINGS['fleet']}/vehicle", "update", self.state, self.url], start_new_session=True,
            env=dict(os.environ, SIGHTLINE=SETTINGS["sightline"], SIGHTLINE_NOW=NOW), stderr=subprocess.DEVNULL)
        part = f"{self.state}/incoming/{sha256(f'{self.site}/v1.slmap')}"
        for _ in range(1000):
            time.sleep(0.02)
            if os.path.exists(part) and 0 < os.path.getsize(part) < size:
                break
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        self.assertLess(os.path.getsize(part), size)
        self.serve()
        self.assert_updates(1)
        self.assertIn("/v1.slmap HTTP/1.1\" 206", self.access_log())

    def what_it_goes_on_from(self):
        """Every folder and file of the vehicle with what it holds, and which of them are one file under two names."""
        first = {}
        return tuple((str(path), path.is_dir() or (sha256(path), first.setdefault(path.stat().st_ino, str(path))))
                     for path in sorted(pathlib.Path(self.state).rglob("*")))

    def kill_at_every_command(self):
        """Before every single command of the vehicle's script in turn; returns how many there were. From each state that a
        kill leaves the vehicle goes on once."""
        with open(f"{self.folder}/killer", "w") as file:
            file.write("set -T\ncount=0\ntrap '((++count == KILL_AT)) && kill -KILL $$; :' DEBUG\n")
        saved = f"{self.folder}/saved"
        shutil.copytree(self.state, saved)
        old, new = sha256(f"{saved}/map.slmap"), sha256(f"{self.made}/v2.slmap")
        gone_on_from = set()
        at = 0
        while True:
            at += 1
            shutil.rmtree(self.state)
            shutil.copytree(saved, self.state)
            killed = self.vehicle(environment={"BASH_ENV": f"{self.folder}/killer", "KILL_AT": str(at)})
            self.assertIn(sha256(f"{self.state}/map.slmap"), (old, new), f"killed at command {at}")
            left = self.what_it_goes_on_from()
            if left not in gone_on_from:
                gone_on_from.add(left)
                self.assert_updates(2)
                self.assertEqual(sha256(f"{self.state}/map.slmap.previous"), old)
            if killed.returncode == 0:
                print(f"killed before each of {at - 1} commands, which left {len(gone_on_from)} states")
                return at - 1
            self.assertEqual(killed.returncode, -signal.SIGKILL)

    def test_survives_being_killed_before_any_command(self):
        self.start_with(1)
        self.release(2, 2, base=1 if HAS_DELTA else None)
        self.assertGreater(self.kill_at_every_command(), 40)


class Attacks(Fleet):
    def begin(self):
        super().begin()
        self.start_with(1)

    def test_wrong_key(self):
        self.release(2, 2, signers=["mallory", "carol"])
        self.assert_refuses("SL5001 wrong-key", 68)

    def test_too_few_signatures(self):
        self.release(2, 2, signers=["alice", "mallory"])
        self.assert_refuses("SL5002 too-few-signatures", 68)

    def test_a_record_changed_after_it_was_signed(self):
        self.release(2, 2)
        self.change_release(lambda text: text.replace("counter 2", "counter 3"), signers=None)
        self.assert_refuses("SL5003 bad-signature", 68)

    def test_a_replayed_older_release(self):
        for name in ("release", "release.minisig"):
            shutil.copy(f"{self.site}/{name}", f"{self.folder}/{name}")
        self.release(2, 2)
        self.assert_updates(2)
        for name in ("release", "release.minisig"):
            shutil.copy(f"{self.folder}/{name}", f"{self.site}/{name}")
        self.assert_refuses("SL5007 replayed-release", 68)

    def test_a_frozen_release(self):
        self.assert_refuses("SL5008 expired", 68, now=LATER)

    def test_another_file_in_the_place_of_the_map(self):
        self.release(2, 2)
        shutil.copy(f"{self.made}/mixed.slmap", f"{self.site}/v2.slmap")
        self.assert_refuses("SL5012 not-as-released", 68)

    def test_mixed_tiles_of_two_versions_even_when_signed(self):
        self.release(2, 2)
        self.name_file(f"{self.made}/mixed.slmap")
        # Each part is whole, and the root is that of no such whole.
        self.assert_refuses("SL4004 digest-mismatch", 67)

    def test_swapped_layers_inside_a_tile_even_when_signed(self):
        self.release(2, 2)
        self.name_file(f"{self.made}/swapped.slmap")
        self.assert_refuses("SL4008 bad-layer", 67)

    def test_a_decompression_bomb_even_when_signed(self):
        def little_memory():
            resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30))

        self.release(2, 2)
        self.name_file(f"{self.made}/bomb.slmap")
        self.assert_refuses("SL4009 too-large", 67, preexec_fn=little_memory)
        self.release(2, 3)
        self.name_file(f"{self.made}/inflated.slmap")
        self.assert_refuses("SL4008 bad-layer", 67, preexec_fn=little_memory)

    def test_a_release_of_more_bytes_than_any_map(self):
        size = os.path.getsize(f"{self.made}/v2.slmap")
        for counter, found in ((2, "17179869185"), (3, "18446744073709551615")):
            self.release(2, counter)
            self.change_release(lambda text, to=found: text.replace(f"v2.slmap {size} ", f"v2.slmap {to} "))
            self.assert_refuses("SL5013 longer-than-released", 68)

    def test_slow_retrieval_ends_in_bounded_time(self):
        self.release(2, 2)
        self.serve(bytes_per_second=2000)  # never below the speed that alone would end it
        began = time.monotonic()
        self.assert_refuses("SL7001 interrupted", 75, timeout=60, environment={
            "SIGHTLINE_MOST_SECONDS": "6", "SIGHTLINE_LEAST_RATE": "1000000"})
        self.assertLess(time.monotonic() - began, 20)
        self.serve()
        self.assert_updates(2)

    def test_a_clock_that_jumps_back_does_not_bring_an_expired_release_back(self):
        self.assert_refuses("SL5008 expired", 68, now=LATER)
        self.assert_refuses("SL5008 expired", 68, now=NOW)
        # Only as far as the expiry that was signed: one jump ahead ends no release to come.
        self.release(2, 2, expires="2026-12-08T00:00:00Z")
        self.assert_updates(2)

    def test_an_expired_root(self):
        self.release(2, 2, expires="2029-01-01T00:00:00Z")
        self.assert_refuses("SL5008 expired", 68, now="2028-06-01T00:00:00Z")

    def fast_forward(self):
        """Stolen keys sign a counter that nothing can follow."""
        self.release(2, 2)
        self.change_release(lambda text: text.replace("counter 2", f"counter {2 ** 64 - 1}"))
        self.assert_updates(2)
        self.release(3, 3, flags=["--any-step"])
        self.assert_refuses("SL5007 replayed-release", 68)

    def test_fast_forward_and_its_recovery_by_new_keys(self):
        self.fast_forward()
        self.root("root.2", ["bob", "carol", "dave"], ["alice", "bob", "carol", "dave"], previous="root.1")
        self.release(3, 3, signers=["carol", "dave"], flags=["--any-step"])
        self.assert_updates(3)
        # What is seen counts again, and the stolen keys are worth nothing.
        self.release(1, 2, signers=["carol", "dave"], flags=["--any-step"])
        self.assert_refuses("SL5007 replayed-release", 68)
        self.release(1, 9, signers=["alice", "bob"])
        self.assert_refuses("SL5002 too-few-signatures", 68)

    def test_a_rotation_that_leaves_a_threshold_of_old_keys_resets_nothing(self):
        self.fast_forward()
        self.root("root.2", ["alice", "bob", "carol"], ["alice", "bob", "carol"], previous="root.1")
        self.assert_refuses("SL5007 replayed-release", 68)

    def test_a_seen_file_that_was_emptied(self):
        self.release(2, 2)
        with open(f"{self.state}/seen", "w"):
            pass
        self.assert_refuses("SL5005 malformed-record", 68)

    def test_an_endless_map(self):
        self.release(2, 2)
        server = EndlessServer(self.site, "v2.slmap")
        self.addCleanup(server.close)
        self.assert_refuses("SL5013 longer-than-released", 68, url=server.url, timeout=60)
        self.assertFalse(os.path.exists(f"{self.state}/incoming/{sha256(f'{self.site}/v2.slmap')}"))

    def test_an_endless_record(self):
        self.release(2, 2)
        for name in ("release", "release.minisig", "root.2"):
            server = EndlessServer(self.site, name)
            self.addCleanup(server.close)
            self.assert_refuses("SL5013 longer-than-released", 68, url=server.url, timeout=60)

    def test_names_that_lead_elsewhere_even_when_signed_by_hand(self):
        for name in ("../map.slmap", "/etc/passwd", "..", "a/../../b"):
            self.release(2, 2)
            self.change_release(lambda text, to=name: text.replace("map v2.slmap", f"map {to}"), signers=None)
            self.sign_by_hand()
            self.assert_refuses("SL5006 unsafe-name", 68)

    def sign_by_hand(self):
        """With minisign, since `sightline fleet sign` refuses to sign such a record."""
        record = f"{self.site}/release"
        self.assertEqual(run(SETTINGS["sightline"], "fleet", "sign", record, "--key", f"{self.made}/alice.key",
                             ok=False).returncode, 68)
        with open(record + ".minisig", "w") as file:
            for signer in ("alice", "bob"):
                run("minisign", "-S", "-s", f"{self.made}/{signer}.key", "-m", record, "-x", f"{self.folder}/one")
                file.write(pathlib.Path(self.folder, "one").read_text())

    def test_links_in_the_vehicles_folder(self):
        self.release(2, 2)
        victim = f"{self.folder}/victim"
        with open(victim, "w") as file:
            file.write("precious")
        digest = sha256(f"{self.site}/v2.slmap")
        for name in ("seen", "lock", "rejected", f"incoming/{digest}", "incoming/release", "map.slmap.previous"):
            path = f"{self.state}/{name}"
            os.makedirs(os.path.dirname(path), exist_ok=True)
            kept = open(path, "rb").read() if os.path.exists(path) else None
            if kept is not None:
                os.remove(path)
            os.symlink(victim, path)
            self.assert_refuses("SL5006 unsafe-name", 68)
            self.assertEqual(open(victim).read(), "precious", name)
            os.remove(path)
            if kept is not None:
                with open(path, "wb") as file:
                    file.write(kept)
        self.assert_updates(2)

    def test_a_delta_onto_a_wrong_base_is_refused_and_the_whole_map_taken(self):
        self.release(2, 2, base=3)  # made for v3, said to be for v1
        self.change_release(lambda text: text.replace(sha256(f"{self.made}/v3.slmap"),
                                                      sha256(f"{self.made}/v1.slmap")))
        done = self.assert_updates(2)
        self.assertIn("SL2024 wrong-base", done.stderr)

    def test_another_file_in_the_place_of_the_delta(self):
        self.release(2, 2, base=1)
        with open(f"{self.site}/v1-2.sldelta", "r+b") as file:
            file.seek(100)
            file.write(b"\0\0\0\0\1")
        self.assert_refuses("SL5012 not-as-released", 68)

    def test_a_release_for_another_sensor(self):
        self.release(2, 2)
        self.assert_refuses("SL5011 wrong-sensor", 68, environment={"SIGHTLINE_SENSOR": "0" * 64})


def find_nginx(finder, folder):
    done = run(finder, folder, ok=False)
    return done.stdout.strip() if done.returncode == 0 else None


if __name__ == "__main__":
    SETTINGS.update(zip(("sightline", "write_maps", "fleet"), map(os.path.abspath, sys.argv[1:4])))
    HAS_DELTA = " delta " in run(SETTINGS["sightline"], "--help").stdout
    SETTINGS["nginx"] = find_nginx(*map(os.path.abspath, sys.argv[4:6]))
    lacking = [program for program in ("curl", "minisign", "flock") if not shutil.which(program)]
    if not SETTINGS["nginx"] or lacking:
        print("skipped: no nginx or no", lacking)
        sys.exit(77)
    unittest.main(argv=sys.argv[:1] + sys.argv[6:], verbosity=2)
