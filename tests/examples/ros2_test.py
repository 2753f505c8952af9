#!/usr/bin/env python3
"""The package examples/ros2: compiles over headers made for it, names in package.xml and
CMakeLists.txt what it includes, and is built by colcon where ROS 2 is.

usage: ros2_test.py SOURCE_FOLDER [BUILD_FOLDER]     whose reader is installed for colcon
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

HERE = pathlib.Path(__file__).resolve().parent


def check_syntax(root, package):
    with tempfile.TemporaryDirectory() as headers:
        subprocess.run([sys.executable, HERE / "ros2_headers.py", headers], check=True)
        for source in sorted((package / "src").glob("*.cpp")):
            subprocess.run(["g++", "-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-I", root,
                            "-isystem", headers, source], check=True)


def check_names(package):
    included = set()
    for source in (package / "src").iterdir():
        for name in re.findall(r"#include <(\w+)/", source.read_text()):
            included.add(name)
    manifest = xml.etree.ElementTree.parse(package / "package.xml").getroot()
    depended = {element.text for element in manifest.findall("depend")}
    assert depended == included, (depended, included)
    build = (package / "CMakeLists.txt").read_text()
    found = set(re.findall(r"find_package\((\w+) REQUIRED\)", build))
    assert found == included | {"ament_cmake", "sightline"}, found
    name = manifest.find("name").text
    assert f"project({name} " in build
    launch = xml.etree.ElementTree.parse(package / "launch" / "observation.launch.xml").getroot()
    assert launch.find("node").get("pkg") == name
    executables = re.findall(r"add_executable\((\w+)", build)
    assert launch.find("node").get("exec") in executables


# Every parameter of the node stands in the file, but for the map; the file has no other.
def check_parameters(package):
    source = (package / "src" / "observation_node.cpp").read_text()
    declared = set(re.findall(r'declare_parameter<[^(]+>\(\s*"(\w+)"', source))
    text = (package / "config" / "observation.param.yaml").read_text()
    written = set(re.findall(r"^    (\w+):", text, re.MULTILINE))
    assert declared - {"map_file"} == written, (declared, written)


def build_with_colcon(package, build):
    if shutil.which("colcon") is None or not build:
        print("no colcon: only the syntax was checked")
        return
    with tempfile.TemporaryDirectory() as folder:
        prefix = pathlib.Path(folder) / "prefix"
        subprocess.run(["cmake", "--install", build, "--component", "reader", "--prefix", prefix],
                       check=True)
        shutil.copytree(package, pathlib.Path(folder) / "src" / "sightline_ros2")
        subprocess.run(["colcon", "build", "--packages-select", "sightline_ros2", "--cmake-args",
                        f"-DCMAKE_PREFIX_PATH={prefix}"], cwd=folder, check=True)


def main():
    root = pathlib.Path(sys.argv[1])
    package = root / "examples" / "ros2"
    check_names(package)
    check_parameters(package)
    check_syntax(root, package)
    build_with_colcon(package, sys.argv[2] if len(sys.argv) > 2 else "")


if __name__ == "__main__":
    main()
