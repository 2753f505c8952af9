#!/usr/bin/env python3
"""README's picture is what the program draws of the map of examples/town/run.

Compares with the map that examples/town/run left in build/, if that is newer than the program. With SIGHTLINE_LONG in
the environment it makes the town and compiles it, which takes minutes. Else it is skipped. With --update it writes the
picture.

usage: readme_picture.py ROOT SIGHTLINE TOWN FOLDER [--update]
"""

import os
import pathlib
import subprocess
import sys

SKIPPED = 77
SEED, LENGTH_M = "1", "600"  # as examples/town/run


def made_map(root, sightline, town, folder):
    subprocess.run([town, "--seed", SEED, "--length-m", LENGTH_M, "--output", folder, "--force"], check=True)
    config = folder / "town.yaml"
    config.write_text((root / "examples/town/town.yaml").read_text())
    subprocess.run([sightline, "compile", config, "-q", "--force", "-o", folder / "town.slmap"], check=True)
    return folder / "town.slmap"


def main():
    root, sightline, town, folder = map(pathlib.Path, sys.argv[1:5])
    map_file = root / f"build/town-{SEED}-{LENGTH_M}/town.slmap"
    if os.environ.get("SIGHTLINE_LONG"):
        map_file = made_map(root, sightline, town, folder)
    elif not map_file.exists() or map_file.stat().st_mtime < sightline.stat().st_mtime:
        print(f"skipped: {map_file} is missing or older than the program; run examples/town/run")
        return SKIPPED
    drawn = subprocess.run([sightline, "dump", map_file, "-q", "--what", "ranges", "--format", "svg"], check=True,
                           stdout=subprocess.PIPE).stdout
    picture = root / "examples/images/town_ranges.svg"
    if sys.argv[5:] == ["--update"]:
        picture.write_bytes(drawn)
    if str(picture.relative_to(root)) not in (root / "README.md").read_text():
        print(f"README.md does not show {picture}")
        return 1
    if picture.read_bytes() != drawn:
        print(f"{picture} is not the picture of {map_file}; write it with --update behind the arguments of this test")
        return 1
    return 0


sys.exit(main())
