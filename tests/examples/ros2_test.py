#!/usr/bin/env python3
"""The package examples/ros2: compiles over headers made for it, names in package.xml and
CMakeLists.txt what it includes, and is built by colcon where ROS 2 is.

usage: ros2_test.py SOURCE_FOLDER [BUILD_FOLDER]     whose libraries are installed for colcon
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
            subprocess.run(["g++", "-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-I", root, "-I", package,
                            "-isystem", headers, "-isystem", HERE / "ros2_stubs", source], check=True)


def check_names(package):
    included = set()
    for source in (package / "src").iterdir():
        for name in re.findall(r"#include <(\w+)/", source.read_text()):
            included.add(name)
        if "rclcpp_components" in source.read_text():
            included.add("rclcpp_components")
    manifest = xml.etree.ElementTree.parse(package / "package.xml").getroot()
    depended = {element.text for element in manifest.findall("depend")}
    assert depended == included, (depended, included)
    build = (package / "CMakeLists.txt").read_text()
    found = set(re.findall(r"find_package\((\w+) REQUIRED", build))
    assert found == included | {"ament_cmake", "sightline"}, found
    name = manifest.find("name").text
    assert f"project({name} " in build
    executables = re.findall(r"add_executable\((\w+)", build) + re.findall(r"EXECUTABLE (\w+)", build)
    for launch in sorted((package / "launch").iterdir()):
        for node in xml.etree.ElementTree.parse(launch).getroot().iter("node"):
            assert node.get("pkg") == name
            assert node.get("exec") in executables, node.get("exec")
    for source in (package / "core").glob("*.cpp"):
        assert f"core/{source.name}" in build, source
        assert not re.search(r"#include <(rclcpp|tf2|\w+_msgs)", source.read_text()), source
    for source in (package / "src").glob("*.cpp"):
        assert f"src/{source.name}" in build, source


def keys_of(yaml):
    """Names of parameters in a file: those of nested ones joined by dots."""
    keys, parents = set(), []
    for line in yaml.splitlines():
        match = re.match(r"^( +)(\w+):(.*)$", line)
        if not match or len(match[1]) < 4:
            continue
        parents = parents[:(len(match[1]) - 4) // 2] + [match[2]]
        value = match[3].split("#")[0].strip()
        is_parent = not value and match[2] != "output_pose_covariance"
        if not is_parent:
            keys.add(".".join(parents))
    return keys


# Every parameter of a node is in its file, but for the map; the file has no other.
def check_parameters(package):
    for node, file in (("observation_node", "observation"), ("localizer_node", "localizer"), ("nav2_node", "nav2")):
        source = (package / "src" / f"{node}.cpp").read_text()
        declared = set(re.findall(r'declare_parameter<[^(]+>\(\s*"([\w.]+)"', source))
        written = keys_of((package / "config" / f"{file}.param.yaml").read_text())
        assert declared - {"map_file"} == written, (node, declared ^ written)


def build_with_colcon(package, build):
    if shutil.which("colcon") is None or not build:
        print("no colcon: only the syntax was checked")
        return
    with tempfile.TemporaryDirectory() as folder:
        prefix = pathlib.Path(folder) / "prefix"
        for component in ("reader", "localizer_library", "localizer"):
            subprocess.run(["cmake", "--install", build, "--component", component, "--prefix", prefix], check=True)
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
