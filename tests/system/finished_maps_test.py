#!/usr/bin/env python3
"""Finished maps and routes that are not what they should be: each is named, and nothing is invented. Prints the table of
finished_maps.md with --table.

usage: finished_maps_test.py SIGHTLINE [--table]
"""

import csv
import io
import os
import pathlib
import re
import subprocess
import sys
import tempfile

SIGHTLINE = str(pathlib.Path(sys.argv[1]).resolve())
USAGE, INPUT = 64, 65
FEW = ["--sensor", "generic-16", "--no-cache", "--threads", "1", "--set", "measure-error.offset_count=1", "--set", "annotation.ranges_m=10",
       "--set", "annotation.looks=paper"]

# What is wrong, map, route, further arguments, status, words that must be said, places (None: no map may be written).
CASES = [
    ("nothing: a street of 60 m", "street.pcd", "middle.csv", "", 0, "no scan was recorded at", "41"),
    ("no ground: walls alone", "walls.pcd", "middle.csv", "", INPUT, "SL2026 no-ground", None),
    ("no ground, everywhere", "walls.pcd", "everywhere", "", INPUT, "SL2026 no-ground", None),
    ("two floors, and a route without heights", "floors.pcd", "middle.csv", "", INPUT, "Add heights to the route", None),
    ("two floors, and a route on the upper one", "floors.pcd", "upper.csv", "", 0, "no scan was recorded at", "41 at 4.0 m"),
    ("two floors, everywhere: one of them", "floors.pcd", "everywhere", "", 0, "1 separate area is left out", "138 at 0.0 m"),
    ("a hole of 16 m", "hole.pcd", "middle.csv", "", 0, "left out: without ground in the map", "27"),
    ("a hole of 16 m, everywhere", "hole.pcd", "everywhere", "", 0, "1 separate area is left out", "none far in the hole"),
    ("a hole of 4 m is bridged", "gap.pcd", "middle.csv", "", 0, "no scan was recorded at", "41"),
    ("a map in degrees", "degrees.pcd", "degrees.csv", "", INPUT, "in degrees", None),
    ("lanes in degrees on a map in metres", "street.pcd", "lanes.geojson", "", INPUT, "world", None),
    ("lanes that leave the map", "street.pcd", "long.csv", "", 0, "left out: off the map", "61"),
    ("lanes beside the map", "street.pcd", "beside.csv", "", INPUT, "SL2016 no-overlap", None),
    ("lanes a kilometre away", "street.pcd", "away.csv", "", INPUT, "Give both in the same coordinates (route.world)", None),
    ("lanes of another zone", "utm.pcd", "lanes.geojson", "--world utm:33N", INPUT, "Give both in the same coordinates (route.world)", None),
    ("lanes of the right zone", "utm.pcd", "lanes.geojson", "--world utm:32N", 0, "no scan was recorded at", "52"),
    ("lanes 100 m above the map", "street.pcd", "above.csv", "", INPUT, "are more than 3 m from it", None),
    ("a map of no points", "empty.pcd", "middle.csv", "", INPUT, "SL2", None),
    ("a map of points that are not finite", "nan.pcd", "middle.csv", "", INPUT, "SL2", None),
]


def pcd(points):
    text = f"VERSION 0.7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {len(points)}\nHEIGHT 1\nPOINTS {len(points)}\nDATA ascii\n"
    return text + "".join(f"{x:.10g} {y:.10g} {z:.10g}\n" for x, y, z in points)


def floor(height_m, hole_m=None):
    """60 m by 10 m, a point every quarter of a metre, without those between the two ends of the hole."""
    return [(0.25 * i, 0.25 * j - 5.0, height_m) for i in range(241) for j in range(41)
            if hole_m is None or not hole_m[0] < 0.25 * i < hole_m[1]]


def fronts(highest_m=6.0):
    """Along both sides, with recesses, so that there is something to match."""
    points = []
    for i in range(301):
        x_m = 0.2 * i
        for side in (-1, 1):
            recess_m = 2.0 if int(x_m + 2 * side) % 7 < 2 else 0.0
            points += [(x_m, side * (6.0 + recess_m), 0.2 * k + 0.6) for k in range(round((highest_m - 0.6) / 0.2))]
    return points


def write_files(folder):
    def line(points):
        return "x,y\n" + "".join(f"{x},{y}\n" for x, y in points)

    street = floor(0.0) + fronts()
    clouds = {"street": street, "walls": fronts(), "floors": floor(0.0) + floor(4.0) + fronts(),
              "hole": floor(0.0, (22.0, 38.0)) + fronts(), "gap": floor(0.0, (28.0, 32.0)) + fronts(),
              "degrees": [(8.39, 48.98, 100.0), (8.391, 48.981, 120.0)], "empty": [],
              "nan": [(float("nan"), 0.0, 0.0)] * 4,
              # Where 8.4 degrees east and 49 degrees north are in zone 32.
              "utm": [(456125.0 + x, 5427629.0 + y, z) for x, y, z in street]}
    for name, points in clouds.items():
        (folder / f"{name}.pcd").write_text(pcd(points))
    routes = {"middle": line([(10, 0), (50, 0)]), "long": line([(0, 0), (300, 0)]), "beside": line([(10, 60), (50, 60)]),
              "away": line([(1010, 0), (1050, 0)]), "degrees": line([(8.39, 48.98), (8.391, 48.98)]),
              "upper": "x,y,z\n10,0,4\n50,0,4\n", "above": "x,y,z\n10,0,100\n50,0,100\n"}
    for name, text in routes.items():
        (folder / f"{name}.csv").write_text(text)
    (folder / "lanes.geojson").write_text('{"type": "LineString", "coordinates": [[8.4002, 49.00000], [8.4009, 49.00000]]}')


def sites(folder):
    """Positions of the map's places: x and y, and the ground's height below the sensor."""
    dumped = subprocess.run([SIGHTLINE, "dump", "m.slmap", "--what", "sites", "--format", "csv", "-q"], cwd=folder, capture_output=True, text=True)
    facts = dict(line[2:].split(": ", 1) for line in dumped.stdout.splitlines() if line.startswith("# "))
    rows = csv.DictReader(io.StringIO("\n".join(line for line in dumped.stdout.splitlines() if not line.startswith("#"))))
    origin_m = [float(facts[f"origin_world_{axis}_m"]) for axis in "xyz"]
    return [tuple(float(row[f"p_{axis}_m"]) + origin for axis, origin in zip("xyz", origin_m)) for row in rows]


def invented(expected, places):
    """What is wrong with the places of a map; nothing where they are as they should be."""
    if "hole" in expected:
        # Free ground goes on for 3 m where it was not seen (schemas/definitions.md, "Everywhere").
        return "" if places and not any(26.0 < x < 34.0 for x, _, _ in places) else "a place lies far in the hole"
    count, _, height = expected.partition(" at ")
    if len(places) != int(count):
        return f"{len(places)} places, expected {count}"
    ground_m = [z - 1.8 for _, _, z in places]
    if height and max(abs(z - float(height.split()[0])) for z in ground_m) > 0.1:
        return f"ground from {min(ground_m):.2f} to {max(ground_m):.2f} m, expected {height}"
    return ""


def message_of(run):
    lines = [line for line in run.stderr.splitlines() if "SL" in line or "left out" in line or "simulated" in line]
    return re.sub(r"^(error|warning [a-z-]+:) ", "", (lines or run.stderr.splitlines() or [""])[-1])


def main():
    faults, table = [], ""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write_files(folder)
        for what, points, route, further, status, words, expected in CASES:
            (folder / "m.slmap").unlink(missing_ok=True)
            command = ["annotate", points, "--route", route, *further.split()]
            run = subprocess.run([SIGHTLINE, *command, *FEW, "-o", "m.slmap"], cwd=folder, capture_output=True, text=True, timeout=120,
                                 env=dict(os.environ, NO_COLOR="1"))
            is_written = (folder / "m.slmap").exists()
            places = sites(folder) if is_written else []
            wrong = invented(expected, places) if expected and is_written else ""
            if run.returncode != status or words not in run.stderr or is_written != (expected is not None) or wrong:
                faults.append(f"{what}: {' '.join(command)}\n  status {run.returncode}, expected {status}, and '{words}'; {wrong}\n  {run.stderr.strip()}")
            cell = message_of(run).replace("|", "\\|")
            said = next((line for line in run.stderr.splitlines() if words in line), cell)
            said = re.sub(r"^(error|warning [a-z-]+:) ", "", said).replace("|", "\\|")
            table += f"| {what} | `{points}`, `{' '.join([route, *further.split()])}` | {run.returncode} | {len(places) if is_written else 'no map'} | {said} |\n"
    if sys.argv[2:] == ["--table"]:
        print("| what is wrong | map, route | status | places | what is said |\n|---|---|---|---|---|\n" + table, end="")
    print(f"{len(CASES) - len(faults)} of {len(CASES)} maps are named rightly", file=sys.stderr)
    print("\n".join(faults), file=sys.stderr)
    sys.exit(1 if faults else 0)


main()
