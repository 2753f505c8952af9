#!/usr/bin/env python3
"""Writes the recordings of ros2 bag in recordings/ with Python's own sqlite3 and a CDR of its own.

usage: write_db3.py FOLDER                writes drive.db3, big_endian.db3, imus.db3 and packed/ (a folder of two files,
                                          messages packed by the program zstd)
       write_db3.py OUT.db3 PCD...        writes scans of /points, 10 a second
What they hold is what write_mcap.mjs writes.
"""
import pathlib
import re
import sqlite3
import struct
import subprocess
import sys

FIRST_NS = 1567410201 * 10**9
TYPES = {"/points": "sensor_msgs/msg/PointCloud2", "/odom": "nav_msgs/msg/Odometry",
         "/tf": "tf2_msgs/msg/TFMessage", "/tf_static": "tf2_msgs/msg/TFMessage",
         "/imu/data": "sensor_msgs/msg/Imu", "/camera/imu": "sensor_msgs/msg/Imu"}


class Cdr:
    """XCDR1 of either byte order: each number at a multiple of its size behind the first 4 bytes."""

    def __init__(self, is_big=False):
        self.order = ">" if is_big else "<"
        self.body = bytearray()

    def put(self, kind, *values):
        for value in values:
            self.body += bytes(-len(self.body) % struct.calcsize(kind))
            self.body += struct.pack(self.order + kind, value)

    def text(self, text):
        raw = text.encode() + b"\0"
        self.put("I", len(raw))
        self.body += raw

    def blob(self, raw):
        self.put("I", len(raw))
        self.body += raw

    def header(self, ns, frame):
        self.put("i", ns // 10**9)
        self.put("I", ns % 10**9)
        self.text(frame)

    def message(self):
        return bytes([0, 0 if self.order == ">" else 1, 0, 0]) + bytes(self.body)


def cloud_message(cdr, header, size, fields, data, is_big=False):
    """size: height, width, bytes of a point, bytes of a row."""
    height, width, step, row = size
    cdr.header(*header)
    cdr.put("I", height, width, len(fields))
    for name, offset, kind in fields:
        cdr.text(name)
        cdr.put("I", offset)
        cdr.put("B", kind)
        cdr.put("I", 1)
    cdr.put("B", is_big)
    cdr.put("I", step, row)
    cdr.blob(data)
    cdr.put("B", 1)
    return cdr.message()


def small_cloud(cdr, k):
    """Two rows of three points of 20 bytes with 4 bytes between them and 8 bytes behind each row."""
    order = ">" if k == 3 else "<"
    data = b""
    for n in range(6):
        data += struct.pack(order + "ffffI", k + 1 + n, 2 - n, 0.5 * n, 10 * n, n * 10**7) + bytes(4)
        data += bytes(8) if n % 3 == 2 else b""
    fields = [("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("intensity", 12, 7), ("t", 16, 6)]
    return cloud_message(cdr, (FIRST_NS + k * 10**8, "lidar"), (2, 3, 24, 80), fields, data, k == 3)


def odometry(cdr, k):
    cdr.header(FIRST_NS + k * 10**8 + 5 * 10**7, "odom")
    cdr.text("base_link")
    cdr.put("d", k, 2, 3, 0, 0, 1, 0, *[0] * 36, *[0] * 6, *[0] * 36)
    return cdr.message()


def transform(cdr, ns, parent, child, numbers):
    cdr.put("I", 1)
    cdr.header(ns, parent)
    cdr.text(child)
    cdr.put("d", *numbers)
    return cdr.message()


def drive(is_big=False):
    """(time, topic, message), in the order of time."""
    half = 0.5**0.5
    mounting = transform(Cdr(is_big), FIRST_NS, "base_link", "lidar", (1, 0, 2, 0, 0, 1, 0))
    messages = [(FIRST_NS - 6 * 10**7, "/tf_static", mounting)]
    for j in range(-1, 9):
        ns = FIRST_NS + j * 5 * 10**7
        moved = transform(Cdr(is_big), ns, "odom", "base_link", (0.5 * j, 0, 0, 0, 0, 0, 1))
        messages.append((ns, "/tf", moved))
    for j in range(-1, 4):
        ns = FIRST_NS + j * 2 * 10**8
        moved = transform(Cdr(is_big), ns, "map", "odom", (100, 0, 0, 0, 0, half, half))
        messages.append((ns, "/tf", moved))
    for k in range(4):
        ns = FIRST_NS + k * 10**8
        messages.append((ns + 1000, "/points", small_cloud(Cdr(is_big), k)))
        messages.append((ns + 50001000, "/odom", odometry(Cdr(is_big), k)))
    return sorted(messages, key=lambda message: message[0])


def imu(cdr, ns, frame, rate, is_known=True):
    """Covariances that begin with -1 say that the numbers before them are none."""
    cdr.header(ns, frame)
    cdr.put("d", 0, 0, 0, 1, -1, *[0] * 8, *rate, 0 if is_known else -1, *[0] * 8, 0, 0, 9.81, *[0] * 9)
    return cdr.message()


def imus(is_big=False):
    """(time, topic, message), in the order of time: imus() of write_mcap.mjs."""
    half = 0.5**0.5
    places = [("lidar", (1, 0, 2, 0, 0, 1, 0)), ("imu_link", (0, 0, 1, half, 0, 0, half))]
    messages = [(FIRST_NS - 6 * 10**7, "/tf_static", transform(Cdr(is_big), FIRST_NS, "base_link", child, place))
                for child, place in places]
    messages += [(FIRST_NS + k * 10**8 + 1000, "/points", small_cloud(Cdr(is_big), k)) for k in range(4)]
    for j in range(-2, 33):
        ns = FIRST_NS + j * 10**7
        rate = (j / 10, 2, float("nan") if j == 5 else -3)
        stamp_ns = ns - (10**7 if j == 10 else 15 * 10**6 if j == 15 else 0)
        messages.append((ns + 500, "/imu/data", imu(Cdr(is_big), stamp_ns, "imu_link", rate, j != 7)))
        messages.append((ns + 600, "/camera/imu", imu(Cdr(is_big), ns, "camera_imu", (9, 9, 9))))
        messages.append((ns + 700, "/camera/imu", imu(Cdr(is_big), ns + 100, "camera_imu", (9, 9, 9))))
    return sorted(messages, key=lambda message: message[0])


def write(path, messages):
    """A database as rosbag2 of Humble makes it."""
    path.unlink(missing_ok=True)
    database = sqlite3.connect(path)
    database.executescript("""
        PRAGMA page_size = 1024;
        CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
        CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
        CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
                            serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
        CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,
                              timestamp INTEGER NOT NULL, data BLOB NOT NULL);
        CREATE INDEX timestamp_idx ON messages (timestamp ASC);
        INSERT INTO schema VALUES (3, 'humble');
    """)
    topics = sorted({topic for _, topic, _ in messages})
    for number, topic in enumerate(topics, 1):
        database.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '')", (number, topic, TYPES[topic]))
    for ns, topic, message in messages:
        database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)",
                         (topics.index(topic) + 1, ns, message))
    database.commit()
    database.close()


def packed(message):
    return subprocess.run(["zstd", "-c", "--content-size", f"--stream-size={len(message)}"], input=message,
                          capture_output=True, check=True).stdout


def write_packed(folder):
    folder.mkdir(exist_ok=True)
    messages = [(ns, topic, packed(message)) for ns, topic, message in drive()]
    half = len(messages) // 2
    write(folder / "packed_0.db3", messages[:half])
    write(folder / "packed_1.db3", messages[half:])
    (folder / "metadata.yaml").write_text("""rosbag2_bagfile_information:
  version: 5
  storage_identifier: sqlite3
  duration:
    nanoseconds: 660000000
  message_count: %d
  topics_with_message_count:
    - topic_metadata:
        name: /points
        type: sensor_msgs/msg/PointCloud2
        serialization_format: cdr
        offered_qos_profiles: ""
      message_count: 4
  compression_format: zstd
  compression_mode: MESSAGE
  relative_file_paths:
    - packed_0.db3
    - packed_1.db3
  files:
    - path: packed_0.db3
      message_count: %d
    - path: packed_1.db3
      message_count: %d
""" % (len(messages), half, len(messages) - half))


def cloud_of_pcd(file, k):
    """Binary PCD with FIELDS x y z intensity of float32."""
    raw = pathlib.Path(file).read_bytes()
    header, data = raw.split(b"DATA binary\n", 1)
    if b"FIELDS x y z intensity\n" not in header:
        raise SystemExit(f"{file}: expected FIELDS x y z intensity")
    count = int(re.search(rb"POINTS (\d+)", header).group(1))
    fields = [("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("intensity", 12, 7)]
    return cloud_message(Cdr(), (k * 10**8, "velo_link"), (1, count, 16, 16 * count), fields, data[:16 * count])


def main():
    output = pathlib.Path(sys.argv[1])
    if sys.argv[2:]:
        scans = ((k * 10**8, "/points", cloud_of_pcd(file, k)) for k, file in enumerate(sys.argv[2:]))
        write(output, list(scans))
        return
    write(output / "drive.db3", drive())
    write(output / "big_endian.db3", drive(is_big=True))
    write(output / "imus.db3", imus(is_big=True))
    write_packed(output / "packed")


if __name__ == "__main__":
    main()
