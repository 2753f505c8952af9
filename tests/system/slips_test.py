#!/usr/bin/env python3
"""Plausible slips of a newcomer: each must end with the right class of error and name the remedy. Prints the
table of slips.md with --table.

usage: slips_test.py SIGHTLINE CORPUS_OF_FUZZING RECORDINGS [--table]
"""

import math
import os
import pathlib
import shutil
import subprocess
import sys
import tarfile
import tempfile

SIGHTLINE, CORPUS, RECORDINGS = (str(pathlib.Path(p).resolve()) for p in sys.argv[1:4])
USAGE, INPUT, VERSION, CORRUPT, SYSTEM = 64, 65, 66, 67, 74

# What slipped, the command, the class of error, words that name the remedy.
SLIPS = [
    # Wrong file to a verb.
    ("a folder to compile", "compile velodyne -o m.slmap", SYSTEM, "sightline init velodyne -o drive.yaml"),
    ("a recording to compile", "compile drive.mcap -o m.slmap", INPUT, "sightline init drive.mcap -o drive.yaml"),
    ("a bag of ROS 1 to compile", "compile drive.bag -o m.slmap", INPUT, "sightline init drive.bag -o drive.yaml"),
    ("a scan to compile", "compile velodyne/000000.pcd -o m.slmap", INPUT, "sightline init velodyne -o drive.yaml"),
    ("a map to compile", "compile town.slmap -o m.slmap", INPUT, "sightline inspect town.slmap"),
    ("a configuration to inspect", "inspect drive.yaml", CORRUPT, "sightline compile drive.yaml -o drive.slmap"),
    ("a folder to inspect", "inspect velodyne", SYSTEM, "sightline init velodyne -o drive.yaml"),
    ("a configuration to gate", "gate drive.yaml", CORRUPT, "this is a configuration"),
    ("a configuration to diff", "diff town.slmap drive.yaml", 2, "this is a configuration"),
    ("a configuration as --map", "evaluate judged.yaml --map drive.yaml", CORRUPT, "this is a configuration"),
    ("a map where a delta belongs", "delta apply town.slmap --to town.slmap -o m.slmap", CORRUPT, "this is a compiled map"),
    ("a map to init", "init town.slmap", None, "this is a compiled map"),
    ("a model to report", "report town.slmodel -o m.html", CORRUPT, "this is an error model"),
    ("the report of a configuration", "report drive.yaml -o m.html", USAGE, "add --map FILE"),
    ("poses to init", "init poses.tum", SYSTEM, "the folder with their scans"),
    ("an archive to init", "init drive.tar.gz", INPUT, "tar -xf"),
    ("a recording of Ouster's to init", "init drive.osf", INPUT, "ouster-cli source in.osf save out.pcap"),
    ("a capture that is none to init", "init broken.pcap", SYSTEM, "does not begin like"),
    ("poses to compile", "compile poses.yaml -o m.slmap", INPUT, "mapping: {scans: FOLDER}"),
    ("no drive to evaluate by", "evaluate two.yaml --map town.slmap", USAGE, "name one that did not make the map"),
    # Words of the command line.
    ("a verb misspelt", "complie drive.yaml", USAGE, "compile"),
    ("a flag misspelt", "compile drive.yaml -o m.slmap --treads 2", USAGE, "--threads"),
    ("no output", "compile drive.yaml", USAGE, "-o is required"),
    ("a folder as the output", "compile drive.yaml -o new/", USAGE, "name the file in it"),
    ("no map", "evaluate drive.yaml", USAGE, "--map"),
    ("a pass misspelt", "compile drive.yaml -o m.slmap --stop-after build_ndt", USAGE, "build-ndt"),
    ("a format that is none", "export town.slmap --format shp -o m.shp", USAGE, "gpkg"),
    ("points of a map", "export town.slmap --format autoware -o m", USAGE, "export the configuration"),
    ("tables of a configuration", "export drive.yaml --format gpkg -o m.gpkg", USAGE, "needs a map"),
    ("a bare zone", "export town.slmap --format geojson --world 32N -o m.json", USAGE, "write utm:32N"),
    ("a table that is none", "dump town.slmap --what site", USAGE, "sites"),
    ("two configurations", "compile drive.yaml judged.yaml -o m.slmap", USAGE, "a list under mapping:"),
    ("the map in place of the configuration", "evaluate town.slmap", USAGE,
     "town.slmap is the map: write `sightline evaluate CONFIG --map town.slmap`"),
    ("a format that ogr2ogr makes", "export town.slmap --format kml -o m.kml", USAGE, "ogr2ogr -f KML"),
    ("a format that PDAL makes", "export town.slmap --format laz -o m.laz", USAGE, "pdal translate"),
    ("an ending that PDAL makes", "export town.slmap -o m.laz", USAGE, "pdal translate"),
    ("an ending that is none", "export town.slmap -o m.foo", USAGE, ".geojson (geojson)"),
    ("--json", "inspect town.slmap --json", USAGE, "--format json"),
    ("-j of a verb with one thread", "inspect town.slmap -j 4", USAGE, "uses one thread: leave the flag out"),
    ("-c", "compile -c drive.yaml -o m.slmap", USAGE, "has no flag before it"),
    ("version", "version", USAGE, "sightline --version"),
    ("a verb that is not near", "foo drive.yaml", USAGE, "`sightline --help` lists them"),
    ("a page as PDF", "report town.slmap -o m.pdf", USAGE, ".html"),
    ("a map with another ending", "compile drive.yaml -o m.map", USAGE, ".slmap"),
    ("a URL", "compile https://example.com/drive.yaml -o m.slmap", INPUT, "download the file first"),
    ("standard input", "compile - -o m.slmap", INPUT, "a configuration is a file"),
    ("--set without a value", "compile drive.yaml -o m.slmap --set build-ndt.cell_m", USAGE, "section.key=value"),
    ("--set of a key that is none", "compile drive.yaml -o m.slmap --set build-ndt.cel_m=1", USAGE, "cell_m"),
    # Paths.
    ("a configuration that is not there", "compile drives.yaml -o m.slmap", INPUT, "drives.yaml"),
    ("an output that is there", "compile drive.yaml -o town.slmap", USAGE, "--force"),
    ("the configuration as output", "compile drive.yaml -o drive.yaml --force", USAGE, "ends in .slmap"),
    ("the configuration as an export", "export town.slmap --format geojson -o drive.yaml --force", SYSTEM, "name another file"),
    ("capital letters", "compile Drive.yaml -o m.slmap", INPUT, "did you mean drive.yaml?"),
    ("a folder as output", "compile drive.yaml -o velodyne", SYSTEM, "only a regular file"),
    ("an output below a file", "compile drive.yaml -o town.slmap/m.slmap", SYSTEM, "is a file, and a folder is needed"),
    ("init of a folder that is not there", "init recording", INPUT, "no such"),
    ("init of pictures", "init pictures", INPUT, ".pcd"),
    ("a map that was cut", "inspect cut.slmap", CORRUPT, "SL4002"),
    # The configuration.
    ("a quote that is not closed", "compile quote.yaml -o m.slmap", INPUT, "this quote is not closed"),
    ("a rule of the gate one level too high", "compile rule.yaml -o m.slmap", USAGE, "belongs under gate.rules"),
    ("a key misspelt, shown with a caret", "compile key.yaml -o m.slmap", USAGE, "    mapping: {scan: velodyne}\n              ^"),
    ("a key misspelt", "compile key.yaml -o m.slmap", USAGE, "did you mean 'scans'"),
    ("a section misspelt", "compile section.yaml -o m.slmap", USAGE, "did you mean 'mapping'"),
    ("a tab in YAML", "compile tab.yaml -o m.slmap", INPUT, "write blanks"),
    ("keys that begin in other columns", "compile column.yaml -o m.slmap", INPUT, "begin in the same column"),
    ("keys of a drive without its section", "compile flat.yaml -o m.slmap", USAGE, "mapping: {scans: ...}"),
    ("a folder in place of a section", "compile word.yaml -o m.slmap", USAGE, "such as {scans: FOLDER}"),
    ("limits in centimetres", "compile drive.yaml -o m.slmap --set annotation.limits_m=10,25", USAGE, "(metres)"),
    ("a decimal comma", "compile drive.yaml -o m.slmap --set build-ndt.cell_m=1,5", USAGE, "1.5"),
    ("a number out of range", "compile range.yaml -o m.slmap", USAGE, "0.1"),
    ("no mapping drive", "compile empty.yaml -o m.slmap", USAGE, "sightline init"),
    ("a world misspelt", "compile world.yaml -o m.slmap", USAGE, "utm:ZONE"),
    ("a world as a code of EPSG", "compile epsg.yaml -o m.slmap", USAGE, "write utm:32N"),
    ("the maker alone as the sensor", "compile velodyne.yaml -o m.slmap", USAGE, "those of velodyne are"),
    ("a sensor misspelt", "compile sensor.yaml -o m.slmap", USAGE, "vlp-16"),
    ("the maker's name of a sensor", "compile maker.yaml -o m.slmap", USAGE, "did you mean vlp-16?"),
    ("a file of beams misspelt", "compile beams.yaml -o m.slmap", USAGE, "azimuth_step_deg"),
    # The recording.
    ("the folder one too high", "compile high.yaml -o m.slmap", INPUT, "velodyne"),
    ("a folder misspelt", "compile missing.yaml -o m.slmap", INPUT, "folder of the configuration); did you mean velodyne?"),
    ("a backslash", "compile backslash.yaml -o m.slmap", INPUT, "separate folders by /"),
    ("a home folder", "compile home.yaml -o m.slmap", INPUT, "write the whole path"),
    ("a pattern of files", "compile pattern.yaml -o m.slmap", INPUT, "name the folder"),
    ("an empty file among the scans", "compile hole.yaml -o m.slmap", INPUT, "its row from the poses"),
    ("one scan as the folder", "compile single.yaml -o m.slmap", None, "folder"),
    ("two formats in a folder", "compile mixed.yaml -o m.slmap", INPUT, "SL2019"),
    ("a pointer of Git LFS", "compile lfs.yaml -o m.slmap", INPUT, "git lfs pull"),
    ("LAZ", "compile laz.yaml -o m.slmap", INPUT, "las"),
    ("a link to nowhere", "compile link.yaml -o m.slmap", INPUT, "Remove the link"),
    ("the wrong topic", "compile topic.yaml -o m.slmap", None, "/points"),
    ("another sensor, by a fifth of its beams", "compile wrong_sensor.yaml --stop-after ingest", 0, "sightline init"),
    ("another sensor", "compile far_sensor.yaml -o m.slmap", INPUT, "sightline init"),
    # Poses.
    ("poses that are not there", "compile no_poses.yaml -o m.slmap", INPUT, "relative to the folder of the configuration"),
    ("too few poses", "compile few.yaml -o m.slmap", INPUT, "supply one for each scan, or name no poses"),
    ("poses of another clock", "compile clock.yaml -o m.slmap", INPUT, "by 2 h, which is a time zone"),
    ("poses with decimal commas", "compile comma.yaml -o m.slmap", INPUT, "points in numbers"),
    ("poses with names above their columns", "compile named.yaml --stop-after ingest", 0, ""),
    ("names of another order", "compile order.yaml -o m.slmap", INPUT, "in the order t x y z qx qy qz qw"),
    ("poses of six columns", "compile columns.yaml -o m.slmap", INPUT, "12 (KITTI), 8 (TUM)"),
    ("poses as x y z roll pitch yaw", "compile columns.yaml -o m.slmap", INPUT, "Rotation.from_euler"),
    ("quaternions that are none", "compile norm.yaml -o m.slmap", INPUT, "SL2011"),
    ("w first in quaternions: they are turned", "compile w_first.yaml --stop-after ingest", 0, "w x y z"),
    ("a mounting of poses that are the sensor's own", "compile mounted.yaml -o m.slmap", USAGE, "those of the sensor"),
    ("a calibration for poses of the vehicle", "compile calibrated.yaml -o m.slmap", USAGE, "poses_of: sensor"),
]


def walls():
    """A street of fronts 8 m to both sides, 5 m long, with recesses of 2 m between them: ends of each in the plane."""
    for side in (-1, 1):
        for k in range(-8, 9):
            x = 7.0 * k + 1.3 * side
            yield (x, 8 * side), (x + 5, 8 * side)
            yield (x, 8 * side), (x, 12 * side)
            yield (x + 5, 8 * side), (x + 5, 12 * side)
            yield (x - 2, 12 * side), (x, 12 * side)


def distance(x, azimuth):
    """To the nearest wall from (x, 0), in the plane."""
    cos, sin = math.cos(azimuth), math.sin(azimuth)
    nearest = 80.0
    for (ax, ay), (bx, by) in walls():
        across = sin * (bx - ax) - cos * (by - ay)
        if abs(across) < 1e-9:
            continue
        reach = ((ax - x) * (ay - by) + ay * (bx - ax)) / across if bx == ax or by == ay else nearest
        along = (x + reach * cos - ax, reach * sin - ay)
        share = (along[0] * (bx - ax) + along[1] * (by - ay)) / ((bx - ax) ** 2 + (by - ay) ** 2)
        if 0.1 < reach < nearest and 0 <= share <= 1:
            nearest = reach
    return nearest


def scan_text(x):
    """Sixteen beams on the street, 1.8 m above its ground."""
    points = []
    for step in range(240):
        azimuth = math.radians(1.5 * step)
        wall = distance(x, azimuth)
        for beam in range(16):
            slope = math.tan(math.radians(-15 + 2 * beam))
            reach = min(wall, -1.8 / slope if slope < 0 else wall)
            if reach < 80 and reach * slope < 6:
                points.append(f"{reach * math.cos(azimuth):.4f} {reach * math.sin(azimuth):.4f} {reach * slope:.4f}")
    head = ("VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {0}\nHEIGHT 1\n"
            "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {0}\nDATA ascii\n").format(len(points))
    return head + "\n".join(points) + "\n"


def write_files(folder):
    def write(name, text):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)

    for i in range(6):
        write(f"velodyne/{i:06d}.pcd", scan_text(i))
        write(f"second/{i:06d}.pcd", scan_text(i + 0.5))
    drive = "scans: velodyne, sensor: vlp-16"
    write("two.yaml", f"mapping: {{{drive}}}\nlocalization: {{scans: second}}\n")
    tum = "".join(f"{i}.0 {i} 0 0 {{}}\n" for i in range(6))
    write("poses.tum", tum.format(*["0 0 0 1"] * 6))
    write("norm.tum", tum.format(*["0 0 0 2"] * 6))
    write("w_first.tum", tum.format(*["1 0 0 0"] * 6))
    write("named.csv", "timestamp,x,y,z,qx,qy,qz,qw\r\n" + tum.format(*["0 0 0 1"] * 6).replace(" ", ",").replace("\n", "\r\n"))
    write("order.csv", "timestamp,x,y,z,qw,qx,qy,qz\n" + tum.format(*["1 0 0 0"] * 6).replace(" ", ","))
    write("comma.csv", tum.format(*["0 0 0 1"] * 6).replace(".", ",").replace(" ", ";"))
    write("later.tum", "".join(f"{7200 + i}.0 {i} 0 0 0 0 0 1\n" for i in range(6)))
    write("times.txt", "".join(f"{i}.0\n" for i in range(6)))
    write("poses.yaml", "1 0 0 0 0 1 0 0 0 0 1 0\n")
    write("broken.pcap", "no capture\n")
    write("drive.osf", "no text\n")
    with tarfile.open(folder / "drive.tar.gz", "w:gz") as archive:
        archive.add(folder / "velodyne" / "000000.pcd", "000000.pcd")
    write("hole/0.pcd", scan_text(0))
    write("hole/1.pcd", "")
    write("few.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n" * 3)
    write("columns.txt", "0 1 2 3 4 5\n" * 6)
    write("beams_of_mine.yaml", "beams_deg: [1, 2]\nstep: 0.2\n")
    write("far.yaml", "beams: 16\nlowest_beam_deg: 20\nhighest_beam_deg: 50\n")
    write("pictures/a.jpg", "no scan")
    write("high/velodyne/0.pcd", scan_text(0))
    write("mixed/0.pcd", scan_text(0))
    write("mixed/1.ply", "ply\n")
    write("lfs/0.pcd", "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 1\n")
    laz = bytearray(b"LASF" + bytes(20) + b"\1\2" + bytes(240))  # LAS 1.2 with the bit of LAZ
    laz[94:104], laz[104] = (227).to_bytes(2, "little") + (227).to_bytes(4, "little") + bytes(4), 0x80
    write("laz/note.txt", "")
    (folder / "laz" / "0.laz").write_bytes(laz)
    (folder / "link").mkdir()
    (folder / "link" / "0.pcd").symlink_to("nowhere.pcd")
    write("drive.bag", "#ROSBAG V2.0\n\0\1")
    shutil.copy(pathlib.Path(RECORDINGS) / "none.mcap", folder / "drive.mcap")
    shutil.copy(pathlib.Path(CORPUS) / "map" / "seed_plain", folder / "town.slmap")
    shutil.copy(pathlib.Path(CORPUS) / "model" / "seed_tree", folder / "town.slmodel")
    (folder / "cut.slmap").write_bytes((folder / "town.slmap").read_bytes()[:-100])
    for name, text in {
            "drive": f"mapping: {{{drive}, poses: poses.tum}}",
            "judged": f"mapping: {{{drive}}}\nevaluation: {{{drive}}}",
            "key": "mapping: {scan: velodyne}", "section": "maping: {scans: velodyne}",
            "tab": "mapping:\n\tscans: velodyne", "range": f"mapping: {{{drive}}}\nbuild-ndt: {{cell_m: -1}}",
            "empty": "annotation: {seed: 2}", "world": f"annotation: {{world: utm32}}\nmapping: {{{drive}}}",
            "sensor": "mapping: {scans: velodyne, sensor: vlp16}",
            "velodyne": "mapping: {scans: velodyne, sensor: velodyne}",
            "epsg": f"annotation: {{world: 'EPSG:32632'}}\nmapping: {{{drive}}}",
            "quote": "mapping: {scans: \"velodyne, sensor: vlp-16}",
            "rule": f"mapping: {{{drive}}}\ngate: {{unmet-share: 0.1}}",
            "beams": "mapping: {scans: velodyne, sensor: beams_of_mine.yaml}",
            "high": "mapping: {scans: high}", "missing": "mapping: {scans: velodine}",
            "backslash": "mapping: {scans: drives\\velodyne}", "home": "mapping: {scans: ~/velodyne}",
            "pattern": "mapping: {scans: velodyne/*.pcd}", "hole": "mapping: {scans: hole}",
            "column": "mapping:\n scans: velodyne\n  sensor: vlp-16", "flat": drive.replace(", ", "\n"),
            "word": "mapping: velodyne", "maker": "mapping: {scans: velodyne, sensor: Velodyne VLP-16}",
            "clock": f"mapping: {{{drive}, poses: later.tum, stamps: times.txt}}",
            "comma": f"mapping: {{{drive}, poses: comma.csv}}", "named": f"mapping: {{{drive}, poses: named.csv}}",
            "order": f"mapping: {{{drive}, poses: order.csv}}",
            "single": "mapping: {scans: velodyne/000000.pcd}", "mixed": "mapping: {scans: mixed}",
            "lfs": "mapping: {scans: lfs}", "laz": "mapping: {scans: laz}", "link": "mapping: {scans: link}",
            "topic": "mapping: {scans: drive.mcap, topic: /lidar}",
            "wrong_sensor": "mapping: {scans: velodyne, sensor: os2-64, poses: poses.tum}",
            "far_sensor": "mapping: {scans: velodyne, sensor: far.yaml, poses: poses.tum}",
            "no_poses": f"mapping: {{{drive}, poses: poses.txt}}", "few": f"mapping: {{{drive}, poses: few.txt}}",
            "columns": f"mapping: {{{drive}, poses: columns.txt}}", "norm": f"mapping: {{{drive}, poses: norm.tum}}",
            "w_first": f"mapping: {{{drive}, poses: w_first.tum}}",
            "mounted": f"mapping: {{{drive}, poses: poses.tum, poses_of: sensor, lidar_x_m: 1}}",
            "calibrated": f"mapping: {{{drive}, poses: poses.tum, calibration: calib.txt}}"}.items():
        write(f"{name}.yaml", text + "\n")


def message_of(run):
    lines = [line for line in run.stderr.splitlines() if "SL" in line or "warning" in line]
    if not lines and run.returncode == 0:
        return "none: it is read as it is"
    return (lines or run.stderr.splitlines() or [""])[-1]


def main():
    faults, table = [], ""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write_files(folder)
        for what, command, status, remedy in SLIPS:
            run = subprocess.run([SIGHTLINE, *command.split()], cwd=folder, capture_output=True, text=True,
                                 timeout=60, env=dict(os.environ, NO_COLOR="1"))
            said = message_of(run)
            is_named = remedy in run.stderr
            (folder / "m.slmap").unlink(missing_ok=True)
            if run.returncode < 0 or not is_named or (status != 0 and run.returncode == 0) or (status is not None and run.returncode != status):
                faults.append(f"{what}: sightline {command}\n  status {run.returncode}, expected {status}, and "
                              f"'{remedy}' in:\n  {run.stderr.strip()}")
            cell = said.replace("error ", "", 1).replace("|", "\\|").replace(str(folder) + "/", "")
            table += f"| {what} | `{command}` | {run.returncode} | {cell} | {'yes' if is_named else 'no'} |\n"
    if sys.argv[4:] == ["--table"]:
        print("| slip | `sightline` | status | message | names the remedy |\n|---|---|---|---|---|\n" + table, end="")
    print(f"{len(SLIPS) - len(faults)} of {len(SLIPS)} slips name the remedy", file=sys.stderr)
    print("\n".join(faults), file=sys.stderr)
    sys.exit(1 if faults else 0)


main()
