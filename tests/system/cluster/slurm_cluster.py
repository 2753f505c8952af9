"""A Slurm of its own on this machine: munged, slurmctld and several slurmd as children of this process, on free ports of
loopback, with all their files in one folder. No running Slurm is touched.
"""

import getpass
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import time

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "scontrol", "sinfo", "squeue")
SYSTEM_FOLDERS = ("/usr/sbin", "/usr/local/sbin")  # not in the path of every user


class CannotStart(Exception):
    """Why there is no cluster to test with."""


def program(name):
    return shutil.which(name) or shutil.which(name, path=os.pathsep.join(SYSTEM_FOLDERS))


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for each in sockets:
        each.bind(("127.0.0.1", 0))
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


def processes():
    """Of this machine that may be asked: number, number of the parent, environment."""
    for entry in pathlib.Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            fields = (entry / "stat").read_text().rsplit(")", 1)[1].split()
            yield int(entry.name), int(fields[1]), (entry / "environ").read_bytes().split(b"\0")
        except (OSError, IndexError):
            continue  # it has ended, or belongs to somebody else


class SlurmCluster:
    """`with SlurmCluster(folder) as slurm: slurm.run("sbatch", ...)`. Raises CannotStart."""

    def __init__(self, folder, nodes=2, cpus=2):
        self.folder = pathlib.Path(folder)
        self.names = [f"n{i}" for i in range(1, nodes + 1)]
        self.cpus = cpus
        self.environment = dict(os.environ, SLURM_CONF=str(self.folder / "slurm.conf"))
        self.children = {}

    def __enter__(self):
        lacking = [name for name in PROGRAMS if not program(name)]
        if lacking:
            raise CannotStart(f"not installed: {' '.join(lacking)}")
        try:
            self._start()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        for name in self.names:
            self.kill_node(name)
        for child in reversed(self.children.values()):
            child.terminate()
            try:
                child.wait(10)
            except subprocess.TimeoutExpired:
                child.kill()
                child.wait()

    def run(self, *command, **options):
        return subprocess.run([str(part) for part in command], env=self.environment, capture_output=True, text=True,
                              **options)

    def kill_node(self, name):
        """As if its power went: slurmd, what starts its jobs, and the jobs, all at once."""
        mark = self._mark(name).encode()
        known = list(processes())
        dead = {number for number, _, environment in known if mark in environment}
        while True:
            more = {number for number, parent, _ in known if parent in dead} - dead
            if not more:
                break
            dead |= more
        for number in dead:
            try:
                os.kill(number, signal.SIGKILL)
            except ProcessLookupError:
                pass
        if name in self.children:
            self.children.pop(name).wait()
        return len(dead)

    def kill_daemon(self, name):
        """As if its network went: its jobs go on, and the controller does not hear of them."""
        self.children[name].kill()
        self.children.pop(name).wait()

    def start_node(self, name):
        environment = dict(self.environment)
        variable, value = self._mark(name).split("=", 1)
        environment[variable] = value
        self._spawn(name, "slurmd", "-D", "-N", name, environment=environment)

    def log(self):
        return "".join(f"== {path.name}\n{path.read_text(errors='replace')[-3000:]}\n"
                       for path in sorted(self.folder.glob("*.log")))

    def _mark(self, name):
        return f"SIGHTLINE_TEST_NODE={self.folder}:{name}"

    def _spawn(self, name, *command, environment=None):
        with open(self.folder / f"{name}.out.log", "ab") as out:
            self.children[name] = subprocess.Popen([program(command[0]), *map(str, command[1:])], stdout=out, stderr=out,
                                                   stdin=subprocess.DEVNULL, env=environment or self.environment)

    def _start(self):
        self.folder.mkdir(parents=True, exist_ok=True)
        self.folder.chmod(0o755)  # munged wants its socket to be reachable
        (self.folder / "controller").mkdir(exist_ok=True)
        self._write_configuration()
        key = self.folder / "munge.key"
        key.touch(0o600)
        key.write_bytes(os.urandom(1024))
        self._spawn("munged", "munged", "--foreground", f"--key-file={key}", f"--socket={self.folder}/munge.socket",
                    f"--pid-file={self.folder}/munged.pid", f"--seed-file={self.folder}/munged.seed")
        self._wait("munged", lambda: (self.folder / "munge.socket").exists())
        self._spawn("slurmctld", "slurmctld", "-D", "-c")
        for name in self.names:
            (self.folder / f"spool.{name}").mkdir(exist_ok=True)
            self.start_node(name)
        self._wait("nodes", lambda: self.run("sinfo", "-h", "-N", "-o", "%t").stdout.split() == ["idle"] * len(self.names))

    def _write_configuration(self):
        ports = free_ports(1 + len(self.names))
        host = socket.gethostname().split(".")[0]
        nodes = "".join(f"NodeName={name} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs={self.cpus} "
                        "RealMemory=64000 State=UNKNOWN\n" for name, port in zip(self.names, ports[1:]))
        text = (pathlib.Path(__file__).parent / "slurm.conf.in").read_text()
        for key, value in (("HOST", host), ("PORT", ports[0]), ("USER", getpass.getuser()), ("FOLDER", self.folder),
                           ("NODES", nodes)):
            text = text.replace(f"@{key}@", str(value))
        (self.folder / "slurm.conf").write_text(text)

    def _wait(self, what, is_up, seconds=30):
        end = time.monotonic() + seconds
        while not is_up():
            ended = [name for name, child in self.children.items() if child.poll() is not None]
            if ended or time.monotonic() > end:
                raise CannotStart(f"{what} did not come up{f'; ended: {ended}' if ended else ''}\n{self.log()}")
            time.sleep(0.1)
