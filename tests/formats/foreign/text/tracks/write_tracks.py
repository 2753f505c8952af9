#!/usr/bin/env python3
"""Writes one drive as every form of poses in degrees, and its true poses in metres. WGS 84 by its own
defining numbers; shares no code with the readers.

usage: write_tracks.py FOLDER
"""

import math
import pathlib
import sys

A, F = 6378137.0, 1 / 298.257223563
E2 = F * (2 - F)
ORIGIN = (49.0, 8.4, 115.0)
START = 1_700_000_000  # 2023-11-14 22:13:20 UTC


def to_ecef(lat_deg, lon_deg, height_m):
    lat, lon = math.radians(lat_deg), math.radians(lon_deg)
    n = A / math.sqrt(1 - E2 * math.sin(lat) ** 2)
    return ((n + height_m) * math.cos(lat) * math.cos(lon), (n + height_m) * math.cos(lat) * math.sin(lon),
            (n * (1 - E2) + height_m) * math.sin(lat))


def to_geodetic(x, y, z):
    lon, p = math.atan2(y, x), math.hypot(x, y)
    lat, height = math.atan2(z, p * (1 - E2)), 0.0
    for _ in range(20):
        n = A / math.sqrt(1 - E2 * math.sin(lat) ** 2)
        height = p / math.cos(lat) - n
        lat = math.atan2(z, p * (1 - E2 * n / (n + height)))
    return math.degrees(lat), math.degrees(lon), height


def enu_rows(lat_deg, lon_deg):
    """Rows east, north and up in earth's axes."""
    lat, lon = math.radians(lat_deg), math.radians(lon_deg)
    return ((-math.sin(lon), math.cos(lon), 0.0),
            (-math.sin(lat) * math.cos(lon), -math.sin(lat) * math.sin(lon), math.cos(lat)),
            (math.cos(lat) * math.cos(lon), math.cos(lat) * math.sin(lon), math.sin(lat)))


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def transposed(a):
    return [list(row) for row in zip(*a)]


def attitude(roll, pitch, yaw):
    cr, sr, cp, sp, cy, sy = (f(v) for v in (roll, pitch, yaw) for f in (math.cos, math.sin))
    return product(product([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]], [[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]]),
                   [[1, 0, 0], [0, cr, -sr], [0, sr, cr]])


def quaternion(r):
    w = math.sqrt(max(0.0, 1 + r[0][0] + r[1][1] + r[2][2])) / 2
    return ((r[2][1] - r[1][2]) / (4 * w), (r[0][2] - r[2][0]) / (4 * w), (r[1][0] - r[0][1]) / (4 * w), w)


def drive():
    """(enu position, roll, pitch, yaw) of eight poses along a bend, 40 m apart."""
    for i in range(8):
        turn = 0.15 * i
        yield ((40.0 * i, 6.0 * i * i, 0.5 * i), 0.01 * i, 0.02 - 0.005 * i, 0.3 + turn)


def poses():
    axes = enu_rows(ORIGIN[0], ORIGIN[1])
    base = to_ecef(*ORIGIN)
    for (e, n, u), roll, pitch, yaw in drive():
        place = [base[k] + e * axes[0][k] + n * axes[1][k] + u * axes[2][k] for k in range(3)]
        lat, lon, height = to_geodetic(*place)
        tilt = product(axes, transposed(enu_rows(lat, lon)))  # local axes in those of the origin
        yield (e, n, u), product(tilt, attitude(roll, pitch, yaw)), (lat, lon, height), (roll, pitch, yaw)


def sentence(body):
    total = 0
    for c in body.encode():
        total ^= c
    return f"${body}*{total:02X}\n"


def minutes(value, width):
    degrees = int(abs(value))
    return f"{degrees:0{width}d}{(abs(value) - degrees) * 60:013.10f}"


def main():
    folder = pathlib.Path(sys.argv[1])
    (folder / "oxts" / "data").mkdir(parents=True, exist_ok=True)
    truth, csv, ins = "", "time,latitude,longitude,height,roll,pitch,yaw\n", \
        "GPS Time (s);Lat (deg);Lon (deg);Ellipsoid Height (m);sats;Roll (deg);Pitch (deg);Heading (deg)\n"
    nmea, plain, stamps = "", "lat\tlon\n", ""
    for i, (place, rotation, (lat, lon, height), (roll, pitch, yaw)) in enumerate(poses()):
        time = f"{START + i}.25"
        clock = f"2213{20 + i}.25"
        truth += f"{time} " + " ".join(f"{v:.12f}" for v in (*place, *quaternion(rotation))) + "\n"
        csv += ",".join([time] + [f"{v:.14f}" for v in (lat, lon, height)] +
                        [f"{math.degrees(v):.12f}" for v in (roll, pitch, yaw)]) + "\n"
        heading = (90 - math.degrees(yaw)) % 360
        ins += ";".join([time, f"{lat:.14f}", f"{lon:.14f}", f"{height:.12f}", "", f"{math.degrees(roll):.12f}",
                         f"{-math.degrees(pitch):.12f}", f"{heading:.12f}"]) + "\n"
        nmea += sentence(f"GNGGA,{clock},{minutes(lat, 2)},N,{minutes(lon, 3)},E,4,12,0.7,{height - 48.5:.9f},M,48.5,M,,")
        nmea += sentence(f"GNRMC,{clock},A,{minutes(lat, 2)},N,{minutes(lon, 3)},E,5.0,84.4,141123,,,A")
        nmea += sentence(f"PASHR,{clock},{heading:.12f},T,{math.degrees(roll):.12f},{-math.degrees(pitch):.12f},0,0,0,0,1")
        plain += f"{lat:.14f}\t{lon:.14f}\n"
        (folder / "oxts" / "data" / f"{i:010d}.txt").write_text(
            " ".join(f"{v:.14f}" for v in (lat, lon, height, roll, pitch, yaw)) + " 0" * 24 + "\n")
        stamps += f"2023-11-14 22:13:{20 + i}.250000000\n"
    nmea += "$GNGGA,221330.25,4900.0,N,00824.0,E,4,12,0.7,1,M,48.5,M,,*00\n"  # a wrong checksum
    nmea += sentence("GNGGA,221331.25,,,,,0,00,,,M,,M,,")  # no fix
    for name, text in (("truth.tum", truth), ("gnss.csv", csv), ("ins.csv", ins), ("track.nmea", nmea),
                       ("places.csv", plain), ("oxts/timestamps.txt", stamps)):
        (folder / name).write_text(text)


main()
