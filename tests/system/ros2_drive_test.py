#!/usr/bin/env python3
"""A drive recorded as .db3 and as MCAP gives the same NDs as its PCD files.

usage: ros2_drive_test.py SIGHTLINE FOLDER_OF_THE_WRITERS      exit 77: skipped
The set is kitti_0005 of SIGHTLINE_DATA; SIGHTLINE_SCANS: how many of its scans (default: all). The writers are
tests/formats/foreign/ros/write_db3.py and write_mcap.mjs; the latter needs the folder of node_modules that SIGHTLINE_NODE_MODULES
names, and is left out without it.
"""
import hashlib
import os
import pathlib
import subprocess
import sys
import tempfile


def nds_of(program, folder, scans):
    """SHA-256 and length of the table of NDs."""
    config = folder / "drive.yaml"
    config.write_text(f"mapping:\n  name: street\n  scans: {scans}\n  sensor: hdl-64e\n  poses_of: sensor\n")
    dumped = subprocess.run([program, "dump", config, "--what", "nds", "--format", "csv", "--no-cache", "-q"],
                            stdout=subprocess.PIPE, check=True).stdout
    return hashlib.sha256(dumped).hexdigest(), dumped.count(b"\n")


def recordings(files, folder, writers):
    """Names and paths of the same drive in each form."""
    links = folder / "pcd"
    links.mkdir()
    for file in files:
        (links / file.name).symlink_to(file)
    yield "PCD", links
    subprocess.run([sys.executable, writers / "write_db3.py", folder / "drive.db3", *files], check=True)
    yield "db3", folder / "drive.db3"
    modules = os.environ.get("SIGHTLINE_NODE_MODULES")
    if not modules:
        print("SIGHTLINE_NODE_MODULES names no folder: without MCAP")
        return
    subprocess.run(["node", writers / "write_mcap.mjs", modules, folder / "drive.mcap", *files], check=True)
    yield "MCAP", folder / "drive.mcap"


def main():
    program, writers = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    data = os.environ.get("SIGHTLINE_DATA")
    if not data:
        print("SIGHTLINE_DATA names no folder of recordings: without kitti_0005")
        return 77
    files = sorted((pathlib.Path(data) / "kitti_0005").resolve().glob("*.pcd"))
    if not files:
        print("SIGHTLINE_DATA has no set kitti_0005")
        return 77
    files = files[:int(os.environ.get("SIGHTLINE_SCANS", len(files)))]
    found = {}
    with tempfile.TemporaryDirectory() as scratch:
        for form, scans in recordings(files, pathlib.Path(scratch), writers):
            digest, lines = nds_of(program, pathlib.Path(scratch), scans)
            print(f"{form}: {len(files)} scans, {lines} lines of NDs, SHA-256 {digest}", flush=True)
            found[form] = digest
    return 0 if len(set(found.values())) == 1 else 1


if __name__ == "__main__":
    sys.exit(main())
