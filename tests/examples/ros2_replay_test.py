#!/usr/bin/env python3
"""A generated drive in MCAP, localized by the core of the ROS 2 node: streamed tiles give the bits of the whole map,
and as many right poses as the library's own replay.

usage: ros2_replay_test.py SIGHTLINE SIGHTLINE_TOWN ROS2_REPLAY [LENGTH_M=90 [SEED=3]]
"""
import pathlib
import re
import struct
import subprocess
import sys
import tempfile

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "formats" / "foreign" / "ros"))
from write_db3 import cloud_of_pcd  # noqa: E402

SIGHTLINE, TOWN, REPLAY = sys.argv[1:4]
CONFIG = """annotation: {ranges_m: [10, 30], split: auto}
mapping: {scans: mapping/scans, poses: mapping/poses.tum, sensor: generic-16, lidar_z_m: 1.8}
localization: {scans: drive_1/scans, poses: drive_1/poses.tum, sensor: generic-16, lidar_z_m: 1.8}
evaluation: {scans: drive.mcap, sensor: generic-16, lidar_z_m: 1.8}
measure-error: {offset_count: 3, reference: known}
train-model: {trees: 20}
"""


def text(value):
    return struct.pack("<I", len(value)) + value.encode()


def record(kind, content):
    return struct.pack("<BQ", kind, len(content)) + content


def write_mcap(path, messages):
    """Messages of /points as an MCAP file without chunks or a summary."""
    definition = "std_msgs/Header header\nuint32 height\nuint32 width\n"
    with open(path, "wb") as file:
        file.write(b"\x89MCAP0\r\n" + record(1, text("ros2") + text("ros2_replay_test")))
        file.write(record(3, struct.pack("<H", 1) + text("sensor_msgs/msg/PointCloud2") + text("ros2msg") +
                          text(definition)))
        file.write(record(4, struct.pack("<HH", 1, 1) + text("/points") + text("cdr") + struct.pack("<I", 0)))
        for number, (ns, message) in enumerate(messages):
            file.write(record(5, struct.pack("<HIQQ", 1, number, ns, ns) + message))
        file.write(record(15, struct.pack("<I", 0)) + record(2, struct.pack("<QQI", 0, 0, 0)) + b"\x89MCAP0\r\n")


def replay(folder, length_m, seed):
    subprocess.run([TOWN, "--seed", seed, "--length-m", length_m, "--drives", "1", "--output", folder, "--force"],
                   check=True, stdout=subprocess.DEVNULL)
    scans = sorted((folder / "drive_1" / "scans").iterdir())
    write_mcap(folder / "drive.mcap", ((k * 10**8, cloud_of_pcd(scan, k)) for k, scan in enumerate(scans)))
    (folder / "town.yaml").write_text(CONFIG)
    subprocess.run([SIGHTLINE, "compile", folder / "town.yaml", "-q", "-o", folder / "town.slmap"], check=True)
    return subprocess.run([REPLAY, folder / "town.yaml", folder / "town.slmap", folder / "drive_1" / "poses.tum"],
                          check=True, capture_output=True, text=True).stdout


def main():
    length_m, seed = (sys.argv[4:] + ["90", "3"][len(sys.argv[4:]):])[:2]
    with tempfile.TemporaryDirectory() as folder:
        run = replay(pathlib.Path(folder), length_m, seed)
    print(run, end="")
    right = {name: int(number) for name, number in re.findall(r"^(\w+) posed \d+ right (\d+)", run, re.MULTILINE)}
    count = int(re.search(r" of (\d+) share", run)[1])
    same = re.search(r"same bits (\d+) of (\d+)", run)
    assert same[1] == same[2] and int(same[1]) == count, same[0]
    assert right["streamed"] == right["whole"], right
    assert right["library"] >= 0.95 * count, right
    assert abs(right["streamed"] - right["library"]) <= max(1, 0.001 * count), right


if __name__ == "__main__":
    main()
