#!/usr/bin/env python3
"""Headers of messages and services that nodes of ROS 2 include, made for their tests from the definitions,
as rosidl names and lays them out. Those of rclcpp and tf2 are in ros2_stubs.

usage: ros2_headers.py FOLDER
"""

import pathlib
import re
import sys

# The definitions of common_interfaces, builtin_interfaces and autoware_internal_msgs, without comments.
MESSAGES = {
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec",
    "builtin_interfaces/Duration": "int32 sec\nuint32 nanosec",
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id",
    "std_msgs/Float64": "float64 data",
    "std_msgs/String": "string data",
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Quaternion": "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1",
    "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation",
    "geometry_msgs/PoseStamped": "std_msgs/Header header\ngeometry_msgs/Pose pose",
    "geometry_msgs/PoseWithCovariance": "geometry_msgs/Pose pose\nfloat64[36] covariance",
    "geometry_msgs/PoseWithCovarianceStamped": "std_msgs/Header header\n"
    "geometry_msgs/PoseWithCovariance pose",
    "geometry_msgs/PoseArray": "std_msgs/Header header\ngeometry_msgs/Pose[] poses",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Transform": "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation",
    "geometry_msgs/TransformStamped": "std_msgs/Header header\nstring child_frame_id\n"
    "geometry_msgs/Transform transform",
    "sensor_msgs/PointField": "uint8 FLOAT32=7\nuint8 FLOAT64=8\nstring name\nuint32 offset\n"
    "uint8 datatype\nuint32 count",
    "sensor_msgs/PointCloud2": "std_msgs/Header header\nuint32 height\nuint32 width\n"
    "sensor_msgs/PointField[] fields\nbool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\n"
    "bool is_dense",
    "std_msgs/ColorRGBA": "float32 r\nfloat32 g\nfloat32 b\nfloat32 a",
    "visualization_msgs/Marker": "int32 ARROW=0\nint32 ADD=0\nstd_msgs/Header header\nstring ns\nint32 id\n"
    "int32 type\nint32 action\ngeometry_msgs/Pose pose\ngeometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\n"
    "builtin_interfaces/Duration lifetime\nbool frame_locked\ngeometry_msgs/Point[] points\n"
    "std_msgs/ColorRGBA[] colors\nstring text\nstring mesh_resource\nbool mesh_use_embedded_materials",
    "visualization_msgs/MarkerArray": "visualization_msgs/Marker[] markers",
    "autoware_internal_debug_msgs/Float32Stamped": "builtin_interfaces/Time stamp\nfloat32 data",
    "autoware_internal_debug_msgs/Int32Stamped": "builtin_interfaces/Time stamp\nint32 data",
    "diagnostic_msgs/KeyValue": "string key\nstring value",
    "diagnostic_msgs/DiagnosticStatus": "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\n"
    "byte level\nstring name\nstring message\nstring hardware_id\ndiagnostic_msgs/KeyValue[] values",
    "diagnostic_msgs/DiagnosticArray": "std_msgs/Header header\n"
    "diagnostic_msgs/DiagnosticStatus[] status",
}

# Request and response.
SERVICES = {
    "std_srvs/SetBool": ("bool data", "bool success\nstring message"),
    "autoware_internal_localization_msgs/PoseWithCovarianceStamped":
        ("geometry_msgs/PoseWithCovarianceStamped pose_with_covariance",
         "bool success\nbool reliable\ngeometry_msgs/PoseWithCovarianceStamped pose_with_covariance"),
}

PLAIN = {"bool": "bool", "uint8": "std::uint8_t", "int32": "std::int32_t", "uint32": "std::uint32_t",
         "float32": "float", "float64": "double", "string": "std::string", "byte": "unsigned char"}

def snake_case(name):
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


def header_of(name, kind="msg"):
    package, message = name.split("/")
    return f"{package}/{kind}/{snake_case(message)}.hpp"


def cpp_type(name):
    array = re.fullmatch(r"(.+)\[(\d*)\]", name)
    if array and array[2]:
        return f"std::array<{cpp_type(array[1])}, {array[2]}>"
    if array:
        return f"std::vector<{cpp_type(array[1])}>"
    if name in PLAIN:
        return PLAIN[name]
    package, message = name.split("/")
    return f"{package}::msg::{message}"


def struct_of(name, definition, kind="msg"):
    includes, members = [], []
    package, message = name.split("/")
    for line in definition.splitlines():
        of, rest = line.split(maxsplit=1)
        if "=" in rest:
            constant, value = rest.split("=")
            members.append(f"  static constexpr {cpp_type(of)} {constant} = {value};")
            continue
        field, *value = rest.split()
        members.append(f"  {cpp_type(of)} {field}{{{' '.join(value)}}};")
        plain = re.sub(r"\[\d*\]$", "", of)
        if plain not in PLAIN:
            includes.append(f"#include <{header_of(plain)}>")
    return "\n".join(
        ["#pragma once", "#include <array>", "#include <cstdint>", "#include <memory>", "#include <string>", "#include <vector>",
         *includes, f"namespace {package}::{kind} {{", f"struct {message} {{", *members,
         f"  using SharedPtr = std::shared_ptr<{message}>;",
         f"  using ConstSharedPtr = std::shared_ptr<const {message}>;", "};", "}", ""])


def service_of(name, definitions):
    package, service = name.split("/")
    parts = [struct_of(f"{name}_{part}", definition, "srv")
             for part, definition in zip(("Request", "Response"), definitions)]
    return "\n".join(
        [*parts, f"namespace {package}::srv {{", f"struct {service} {{", f"  using Request = {service}_Request;",
         f"  using Response = {service}_Response;", "};", "}", ""])


def main():
    folder = pathlib.Path(sys.argv[1])
    texts = {header_of(name): struct_of(name, definition) for name, definition in MESSAGES.items()}
    for name, definitions in SERVICES.items():
        texts[header_of(name, "srv")] = service_of(name, definitions)
    for path, text in texts.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text)


if __name__ == "__main__":
    main()
