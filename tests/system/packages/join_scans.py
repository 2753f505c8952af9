"""A point cloud of a town's drive in its world: every fifth scan by its pose.

usage: join_scans.py DRIVE CLOUD.pcd
"""

import array
import pathlib
import sys


def rotation(x, y, z, w):
    return ((1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
            (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
            (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)))


drive = pathlib.Path(sys.argv[1])
lines = [line.split() for line in (drive / "poses.tum").read_text().splitlines() if not line.startswith("#")]
joined = array.array("f")
for pose, scan in list(zip(lines, sorted((drive / "scans").glob("*.pcd"))))[::5]:
    t = [float(word) for word in pose[1:4]]
    rows = rotation(*(float(word) for word in pose[4:8]))
    points = array.array("f", scan.read_bytes().split(b"DATA binary\n", 1)[1])
    for i in range(0, len(points), 8):  # every second point
        x, y, z = points[i:i + 3]
        joined.extend([r[0] * x + r[1] * y + r[2] * z + t[axis] for axis, r in enumerate(rows)])
count = len(joined) // 3
header = (f"# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {count}\nHEIGHT 1\n"
          f"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA binary\n")
pathlib.Path(sys.argv[2]).write_bytes(header.encode() + joined.tobytes())
