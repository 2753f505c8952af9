#!/usr/bin/env python3
"""Says what each file of a folder of foreign point clouds holds, for interop_test.cpp.

interop_values.py FOLDER > interop_files.csv

A second opinion: it shares no code with the compiler, uses the standard library alone, and follows
the formats' own descriptions. One row a file: name, number of scans, points kept, points with a NaN
or infinity, points at (0,0,0), lowest and highest x y z; or the code that the file is refused with.
"""
import ast
import gzip
import math
import os
import re
import struct
import sys

# What is refused, by ending, where no rule below finds another reason.
UNSUPPORTED = {".laz", ".npz", ".obj", ".off", ".stl", ".vtk", ".x3d", ".dae", ".json",
               ".xyz", ".txt"}
PCD_TYPES = {("F", 4): "f", ("F", 8): "d", ("U", 1): "B", ("U", 2): "H", ("U", 4): "I",
             ("U", 8): "Q", ("I", 1): "b", ("I", 2): "h", ("I", 4): "i", ("I", 8): "q"}
PLY_TYPES = {"char": "b", "int8": "b", "uchar": "B", "uint8": "B", "bool": "B", "short": "h",
             "int16": "h", "ushort": "H", "uint16": "H", "int": "i", "int32": "i", "uint": "I",
             "uint32": "I", "float": "f", "float32": "f", "double": "d", "float64": "d"}


class Refused(Exception):
    pass


def lzf(packed, size):
    out = bytearray()
    at = 0
    while at < len(packed):
        control = packed[at]
        at += 1
        if control < 32:
            out += packed[at:at + control + 1]
            at += control + 1
            continue
        length = control >> 5
        if length == 7:
            length += packed[at]
            at += 1
        back = ((control & 31) << 8) + packed[at] + 1
        at += 1
        for _ in range(length + 2):
            out.append(out[-back])
    assert len(out) == size
    return bytes(out)


def pcd(data):
    head = {}
    at = 0
    while "DATA" not in head:
        end = data.index(b"\n", at)
        words = data[at:end].decode().split("#")[0].split()
        at = end + 1
        if words:
            head[words[0]] = words[1:]
    names = head.get("FIELDS") or head.get("COLUMNS")
    if not {"x", "y", "z"} <= set(names):
        raise Refused("missing-field")
    counts = [int(c) for c in head.get("COUNT", ["1"] * len(names))]
    types = [PCD_TYPES[t, int(s)] for t, s in zip(head["TYPE"], head["SIZE"])]
    points = int(head["POINTS"][0]) if "POINTS" in head else int(head["WIDTH"][0])
    axes = [names.index(axis) for axis in "xyz"]
    if head["DATA"][0] == "ascii":
        starts = [sum(counts[:i]) for i in range(len(names))]
        rows = [line.split() for line in data[at:].decode().split("\n") if line.strip()]
        assert len(rows) == points
        return [[float(row[starts[i]]) for i in axes] for row in rows]
    if head["DATA"][0] == "binary":
        record = struct.Struct("<" + "".join(str(c) + t for c, t in zip(counts, types)))
        starts = [sum(counts[:i]) for i in range(len(names))]
        return [[row[starts[i]] for i in axes]
                for row in record.iter_unpack(data[at:at + points * record.size])]
    packed, size = struct.unpack_from("<II", data, at)
    body = lzf(data[at + 8:at + 8 + packed], size)
    columns = {}
    start = 0
    for i, (count, kind) in enumerate(zip(counts, types)):
        columns[i] = struct.unpack_from("<%d%s" % (points * count, kind), body, start)
        start += points * count * struct.calcsize(kind)
    return list(zip(*(columns[i] for i in axes)))


def ply(data):
    end = data.index(b"end_header")
    body = data[data.index(b"\n", end) + 1:]
    elements = []
    for line in data[:end].decode().splitlines():
        words = line.split()
        if words[:1] == ["format"]:
            order = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}[words[1]]
        if words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        if words[:1] == ["property"]:
            elements[-1][2].append(words[1:])
    name, count, properties = elements[0]
    assert name == "vertex" and all(p[0] != "list" for p in properties)
    axes = [[p[1] for p in properties].index(axis) for axis in "xyz"]
    if not order:
        rows = [line.split() for line in body.decode().splitlines() if line.strip()][:count]
        return [[float(row[i]) for i in axes] for row in rows]
    record = struct.Struct(order + "".join(PLY_TYPES[p[0]] for p in properties))
    return [[row[i] for i in axes] for row in record.iter_unpack(body[:count * record.size])]


FEET = range(9002, 9100)  # EPSG's lengths that are no metre


def las_records(data):
    """User, number and content of the variable length records, in the header and (1.4) behind it."""
    header, = struct.unpack_from("<H", data, 94)
    count, = struct.unpack_from("<I", data, 100)
    places = [(header, count, "<H", 54)]
    if data[25] == 4:
        places.append((*struct.unpack_from("<QI", data, 235), "<Q", 60))
    for at, count, length_type, head in places:
        for _ in range(count):
            length, = struct.unpack_from(length_type, data, at + 20)
            number, = struct.unpack_from("<H", data, at + 18)
            yield data[at + 2:at + 18].rstrip(b"\0"), number, data[at + head:at + head + length]
            at += head + length


def check_metres(data):
    for user, number, content in las_records(data):
        if user == b"LASF_Projection" and number == 34735:
            keys = list(struct.iter_unpack("<4H", content))[1:]
            if any(k[0] == 1024 and k[3] in (2, 3) or k[0] in (3076, 4099) and k[3] in FEET for k in keys):
                raise Refused("unsupported-format")
        if user == b"LASF_Projection" and number == 2112:
            first = re.search(rb"PROJC|GEOGC|GEOCCS|GEODCRS", content)
            if first and first[0] != b"PROJC" or re.search(rb'UNIT\["[^"]*[Ff](oo|ee)t', content):
                raise Refused("unsupported-format")


def las(data):
    if data[104] & 0xC0:
        raise Refused("unsupported-format")
    check_metres(data)
    length, = struct.unpack_from("<H", data, 105)
    start, = struct.unpack_from("<I", data, 96)
    count, = struct.unpack_from("<Q", data, 247) if data[25] == 4 else (0,)
    count = count or struct.unpack_from("<I", data, 107)[0]
    if count == 0:
        raise Refused("empty-scan")
    scale = struct.unpack_from("<ddd", data, 131)
    offset = struct.unpack_from("<ddd", data, 155)
    flag_at, flag = (15, 0x80) if data[104] < 6 else (15, 0x04)
    return [[n * s + o for n, s, o in zip(struct.unpack_from("<iii", data, start + i * length),
                                          scale, offset)]
            for i in range(count) if not data[start + i * length + flag_at] & flag]


def float_bin(data, name):
    """The files of this set that are large enough to tell have KITTI's floats or nuScenes'."""
    floats = 5 if name.endswith(".pcd.bin") else 4
    if len(data) < 4 * 4096 and sum(len(data) % (4 * n) == 0 for n in range(3, 11)) != 1:
        raise Refused("unsupported-format")
    if len(data) % (4 * floats):
        raise Refused("truncated-scan")
    return [row[:3] for row in struct.Struct("<%df" % floats).iter_unpack(data)]


def npy(data):
    """Rows of named fields x, y, z, or of three columns and more."""
    size = struct.unpack_from("<H", data, 8)[0]
    head = ast.literal_eval(data[10:10 + size].decode())
    codes = {"f4": "f", "f8": "d", "u1": "B", "i4": "i"}
    fields = head["descr"]
    if isinstance(fields, str):
        fields = [("xyz"[i:i + 1], fields) for i in range(head["shape"][1])]
    row = struct.Struct("<" + "".join(codes[kind[1:]] for _, kind in fields))
    at = [[name for name, _ in fields].index(axis) for axis in "xyz"]
    return [[values[i] for i in at] for values in row.iter_unpack(data[10 + size:])]


VLP16_DEG = [-15, 1, -13, 3, -11, 5, -9, 7, -7, 9, -5, 11, -3, 13, -1, 15]
VLP16_MM = [11.2, -0.7, 9.7, -2.2, 8.1, -3.7, 6.6, -5.1, 5.1, -6.6, 3.7, -8.1, 2.2, -9.7, 0.7, -11.2]
HDL32_DEG = [-92 / 3 + 4 / 3 * (i // 2 + 16 * (i % 2)) for i in range(32)]


def velodyne(data):
    """Points of whole revolutions, one after the other, and how many there are."""
    blocks = []
    at = 24
    while at < len(data):
        size, = struct.unpack_from("<I", data, at + 8)
        packet = data[at + 16 + 42:at + 16 + size]
        at += 16 + size
        if len(packet) != 1206:
            continue
        azimuths = [struct.unpack_from("<H", packet, 100 * i + 2)[0] for i in range(12)]
        steps = [(b - a) % 36000 for a, b in zip(azimuths, azimuths[1:])]
        for i in range(12):
            blocks.append((azimuths[i], (steps + steps[-1:])[i], packet[100 * i + 4:100 * i + 100],
                           packet[1205]))
    starts = [i for i in range(1, len(blocks)) if blocks[i][0] < blocks[i - 1][0] - 18000]
    points = []
    for azimuth, step, body, product in blocks[starts[0]:starts[-1]]:
        for i in range(32):
            distance_m = 0.002 * struct.unpack_from("<H", body, 3 * i)[0]
            if product == 0x22:
                elevation, lift_m = math.radians(VLP16_DEG[i % 16]), 0.001 * VLP16_MM[i % 16]
                share = (i // 16 * 55.296 + i % 16 * 2.304) / 110.592
            else:
                elevation, lift_m = math.radians(HDL32_DEG[i]), 0.0
                share = i * 1.152 / 46.080
            turn = math.radians(0.01 * (azimuth + share * step))
            across_m = distance_m * math.cos(elevation)
            points.append([across_m * math.cos(turn), -across_m * math.sin(turn),
                           distance_m * math.sin(elevation) + lift_m] if distance_m else [0.0] * 3)
    return points, len(starts) - 1


def read(name, data):
    if data.startswith(b"version https://git-lfs"):
        raise Refused("git-lfs-pointer")
    if name.endswith(".gz"):
        return read(name[:-3], gzip.decompress(data))
    ending = os.path.splitext(name)[1]
    if ending in UNSUPPORTED:
        raise Refused("unsupported-format")
    if ending == ".pcap":
        return velodyne(data)
    points = {".pcd": pcd, ".ply": ply, ".las": las, ".npy": npy,
              ".bin": lambda d: float_bin(d, name)}[ending](data)
    return points, 1


def row(name, data):
    try:
        points, scans = read(name, data)
    except Refused as refused:
        return [name, str(refused)]
    finite = [p for p in points if all(map(math.isfinite, p))]
    kept = [p for p in finite if any(p)]
    if not kept:
        return [name, "no-finite-points"]
    return ([name, "read", scans, len(kept), len(points) - len(finite), len(finite) - len(kept)] +
            [repr(float(f(p[axis] for p in kept))) for f in (min, max) for axis in range(3)])


def main():
    folder = sys.argv[1]
    print("file,outcome,scans,points,nonfinite,zero,low_x,low_y,low_z,high_x,high_y,high_z")
    names = sorted(os.path.relpath(os.path.join(at, name), folder)
                   for at, _, files in os.walk(folder) for name in files)
    for name in names:
        with open(os.path.join(folder, name), "rb") as file:
            print(*row(name, file.read()), sep=",")


main()
