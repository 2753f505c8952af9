#!/usr/bin/env python3
"""Writes the captures beside it: what LiDARs of Ouster and Hesai send from inside a box.

Shares no code with the readers: packets are laid out and beams are aimed as the makers' manuals say.
The box has six different walls (BOX), so that any wrong angle, axis or offset leaves them. Every
return is the beam's way to the nearest wall, rounded to the packet's own tick.

    write_captures.py [FOLDER]
"""

import json
import math
import struct
import sys
from pathlib import Path

# Lower and upper walls along x, y and z, metres, in the sensor's frame.
BOX = ((-7.0, 11.0), (-5.0, 8.5), (-2.0, 6.0))
START_S = 1_700_000_000  # of the capturing machine


def way_to_wall(origin, direction):
    """Metres from `origin` along `direction` to the box's inside."""
    best = math.inf
    for (lower, upper), o, d in zip(BOX, origin, direction):
        if d > 0:
            best = min(best, (upper - o) / d)
        elif d < 0:
            best = min(best, (lower - o) / d)
    return best


# ---- Captures: Ethernet, IPv4 and UDP.


def ip_packets(payload, port, identification, mtu):
    """UDP over IPv4, in fragments where it is longer than a frame."""
    udp = struct.pack(">HHHH", port, port, 8 + len(payload), 0) + payload
    most = (mtu - 20) // 8 * 8
    for begin in range(0, len(udp), most):
        part = udp[begin:begin + most]
        more = 0x2000 if begin + most < len(udp) else 0
        yield struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(part), identification, more | begin // 8,
                          64, 17, 0, bytes([192, 168, 1, 201]), bytes([192, 168, 1, 2])) + part


def write_pcap(file, packets, port, mtu=9000):
    """`packets`: (seconds since START_S, payload)."""
    data = struct.pack("<IHHIIII", 0xA1B2C3D4, 2, 4, 0, 0, 1 << 18, 1)
    for number, (at_s, payload) in enumerate(packets):
        for packet in ip_packets(payload, port, number + 1, mtu):
            frame = bytes(12) + b"\x08\x00" + packet
            frame += bytes(max(0, 60 - len(frame)))
            us = round(1e6 * at_s)
            data += struct.pack("<IIII", START_S + us // 1_000_000, us % 1_000_000, len(frame),
                                len(frame)) + frame
    file.write_bytes(data)


# ---- Ouster. Software User Manual: "Lidar Data Format", "Lidar Range to XYZ".

BEAMS = 16
COLUMNS = 64
COLUMN_NS = 1_562_500  # 64 columns at 10 Hz
RADIUS_MM = 15.806
HEIGHT_MM = 4.25  # of the sensors whose metadata has beam_to_lidar_transform
LIFT_MM = 36.18
ALTITUDES_DEG = [21.3 - 2.83 * i + 0.05 * (i % 3) for i in range(BEAMS)]
AZIMUTHS_DEG = [(4.23, 1.41, -1.4, -4.19)[i % 4] + 0.01 * i for i in range(BEAMS)]


def ouster_range_m(column, beam, height_mm):
    """What the sensor measures for the wall: the way of light from the lidar's axis."""
    encoder = -2 * math.pi * column / COLUMNS
    aim = encoder - math.radians(AZIMUTHS_DEG[beam])
    rise = math.radians(ALTITUDES_DEG[beam])
    direction = (math.cos(aim) * math.cos(rise), math.sin(aim) * math.cos(rise), math.sin(rise))
    # The beam's origin turns with the head; a range counts from as far behind it as it is away.
    behind = math.hypot(RADIUS_MM, height_mm)
    origin = (RADIUS_MM * math.cos(encoder), RADIUS_MM * math.sin(encoder), height_mm)
    # The sensor's frame looks the other way along x and y, and is lower.
    to_sensor = lambda v, lift: (-v[0], -v[1], v[2] + lift)
    origin_m = [0.001 * value for value in to_sensor(origin, LIFT_MM)]
    return way_to_wall(origin_m, to_sensor(direction, 0.0)) + 0.001 * behind


def has_return(column, beam):
    return (7 * column + 3 * beam) % 11 != 0


def ouster_pixel(profile, column, beam, height_mm):
    range_m = ouster_range_m(column, beam, height_mm) if has_return(column, beam) else 0.0
    reflectivity = 16 * beam + column % 16
    ticks = round(1000 * range_m)
    if profile == "LEGACY":  # the upper bits are flags, which are no range
        return struct.pack("<IHHHH", ticks | 0xA0000000, reflectivity, 700, 800, 0)
    if profile == "RNG19_RFL8_SIG16_NIR16":
        return struct.pack("<IBBHHH", ticks | 0x00380000, reflectivity, 0, 700, 800, 0)
    if profile == "RNG19_RFL8_SIG16_NIR16_DUAL":  # the second return: half as far, or the same
        second = ticks // 2 if beam % 2 == 0 else ticks
        return (struct.pack("<I", ticks | 0x00080000)[:3] + bytes([reflectivity]) +
                struct.pack("<I", second)[:3] + bytes([255 - reflectivity]) +
                struct.pack("<HHHH", 700, 600, 800, 0))
    return struct.pack("<HBB", round(125 * range_m) | 0x8000, reflectivity, 80)


def ouster_packet(profile, frame, first_column, first_ns, height_mm):
    body = b""
    for column in range(first_column, first_column + 16):
        time_ns = first_ns + frame * COLUMNS * COLUMN_NS + column * COLUMN_NS
        is_whole = column != 5
        pixels = b"".join(ouster_pixel(profile, column, beam, height_mm) for beam in range(BEAMS))
        if profile == "LEGACY":
            body += struct.pack("<QHHI", time_ns, column, frame, column * 90112 // COLUMNS) + pixels
            body += struct.pack("<I", 0xFFFFFFFF if is_whole else 0)
        else:
            body += struct.pack("<QHH", time_ns, column, 1 if is_whole else 0) + pixels
    if profile == "LEGACY":
        return body
    return struct.pack("<HH", 1, frame) + bytes(28) + body + bytes(32)


def ouster_metadata(profile, height_mm):
    beam_to_lidar = [1, 0, 0, RADIUS_MM, 0, 1, 0, 0, 0, 0, 1, height_mm, 0, 0, 0, 1]
    sensor_from_lidar = [-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, LIFT_MM, 0, 0, 0, 1]
    data_format = {"columns_per_frame": COLUMNS, "columns_per_packet": 16,
                   "pixels_per_column": BEAMS, "column_window": [0, COLUMNS - 1]}
    if profile == "LEGACY":  # as firmware before 2.0 wrote it: flat, and without a profile
        return {"prod_line": "OS-1-16", "lidar_mode": f"{COLUMNS}x10", "data_format": data_format,
                "beam_altitude_angles": ALTITUDES_DEG, "beam_azimuth_angles": AZIMUTHS_DEG,
                "lidar_origin_to_beam_origin_mm": RADIUS_MM,
                "lidar_to_sensor_transform": sensor_from_lidar}
    data_format["udp_profile_lidar"] = profile
    return {"sensor_info": {"prod_line": "OS-1-16"}, "lidar_data_format": data_format,
            "config_params": {"lidar_mode": f"{COLUMNS}x10", "columns_per_packet": 16},
            "beam_intrinsics": {"beam_altitude_angles": ALTITUDES_DEG,
                                "beam_azimuth_angles": AZIMUTHS_DEG,
                                "lidar_origin_to_beam_origin_mm": math.hypot(RADIUS_MM, height_mm),
                                "beam_to_lidar_transform": beam_to_lidar},
            "lidar_intrinsics": {"lidar_to_sensor_transform": sensor_from_lidar}}


def write_ouster(folder, name, profile, first_ns, mtu):
    """The second half of frame 65535, then 0 and 1, then a packet of 2."""
    height_mm = 0.0 if profile == "LEGACY" else HEIGHT_MM
    packets = []
    for turn, frame in enumerate((65535, 0, 1, 2)):
        for first_column in range(0, COLUMNS, 16):
            if (turn == 0 and first_column < 32) or (turn == 3 and first_column > 0):
                continue
            since = turn * COLUMNS * COLUMN_NS - frame * COLUMNS * COLUMN_NS
            packet = ouster_packet(profile, frame, first_column, first_ns + since, height_mm)
            at_s = 1e-9 * (turn * COLUMNS + first_column + 16) * COLUMN_NS
            packets.append((at_s, packet))
            packets.append((at_s, bytes(48)))  # what the inertial unit sends
    write_pcap(folder / (name + ".pcap"), packets, 7502, mtu)
    text = json.dumps(ouster_metadata(profile, height_mm), indent=1)
    (folder / (name + ".json")).write_text(text + "\n")


# ---- Hesai. User Manuals of Pandar64, Pandar128, PandarXT-32 and PandarXT-16.

STEP_DEG = 3.0  # a block; far faster than any head turns, so that firing times show

PANDAR64_FIRINGS_US = """
51 61 -3.62 45 60 -4.924 39 57 -6.228 9 55 -7.532 49 63 -8.836 43 59 -10.14 7 56 -11.444 53 64 -12.748
47 62 -14.052 41 58 -15.356 6 54 -16.66 5 48 -17.964 4 50 -19.268 3 52 -20.572 2 46 -21.876 1 44 -23.18
24 33 -25.148 27 42 -27.116 21 36 -29.084 15 30 -31.052 22 37 -33.02 16 31 -34.988 10 25 -36.956
19 34 -38.924 13 28 -40.892 20 35 -42.86 14 29 -44.828 8 23 -46.796 17 32 -48.764 11 26 -50.732
18 38 -52.7 12 40 -54.668
"""


def pandar64_firing_us(channel):
    words = PANDAR64_FIRINGS_US.split()
    for a, b, us in zip(words[0::3], words[1::3], words[2::3]):
        if channel in (int(a), int(b)):
            return float(us)
    raise ValueError(channel)


class Pandar64:
    name, channels, blocks, block_us, last_us = "hesai_pandar64", 64, 6, 55.56, -42.58
    tick_m = 0.004

    def firing_us(self, channel):
        return pandar64_firing_us(channel)

    def packet(self, blocks, utc, us, mode):
        head = b"\xee\xff" + bytes([64, 6, 0, 4, 0, 0])
        body = b"".join(struct.pack("<H", azimuth) +
                        b"".join(struct.pack("<HB", *unit) for unit in units)
                        for azimuth, units in blocks)
        year, *rest = utc
        tail = bytes(8) + struct.pack("<HIBB6B", 600, us, mode, 0x42, year - 2000, *rest)
        return head + body + tail + struct.pack("<I", 7)  # a serial number, which firmwares add


class Xt:
    blocks, block_us, last_us, tick_m = 8, 50.0, 0.0, 0.004

    def __init__(self, channels):
        self.name, self.channels = f"hesai_xt{channels}", channels

    def firing_us(self, channel):
        return 5.632 + 0.368 + 1.512 * (channel - 1) * 32 / self.channels

    def packet(self, blocks, utc, us, mode):
        head = b"\xee\xff\x06\x01\0\0" + bytes([self.channels, 8, 1, 4, 2, 0])
        body = b"".join(struct.pack("<H", azimuth) +
                        b"".join(struct.pack("<HBB", *unit, 0) for unit in units)
                        for azimuth, units in blocks)
        year, *rest = utc
        tail = bytes(10) + struct.pack("<BH6BIB", mode, 600, year - 1900, *rest, us, 0x42)
        return head + body + tail + struct.pack("<I", 7)


# Pandar128: microseconds after the block's start, and the channels that fire then.
PANDAR128_FIRINGS_US = """
0.776:3,10,20,91,96,113,119,126 2.431:4,11,21,90,98,99,116,125 4.436:1,5,25,92,100,105,114,121
6.441:7,12,18,93,104,109,122,127 12.666:28,33,34,43,53,54,72,87 17.236:37,42,57,59,63,64,78,84
19.521:30,31,41,52,66,67,77,80 21.806:44,46,49,58,71,75,85,88 28.554:2,13,16,97,102,107,120,128
30.559:6,15,22,95,103,106,117,124 32.564:8,17,19,24,101,108,112,115 34.219:9,14,23,94,110,111,118,123
36.224:32,45,50,51,65,76,79,86 38.509:26,35,47,48,61,68,70,73 43.079:27,29,39,40,60,62,74,89
52.219:36,38,55,56,69,81,82,83
"""


class Pandar128:
    """Protocol 1.4. In high resolution the second half of a block's firings is a block of its own."""

    channels, blocks, last_us, tick_m = 128, 2, 3.148, 0.004

    def __init__(self, is_fine, has_safety, has_confidence):
        self.name = "hesai_pandar128" + ("_fine" if is_fine else "")
        self.is_fine, self.has_safety, self.has_confidence = is_fine, has_safety, has_confidence
        self.block_us = 27.778 if is_fine else 55.556
        self.firings_us = {}
        for group in PANDAR128_FIRINGS_US.split():
            us, channels = group.split(":")
            for channel in channels.split(","):
                self.firings_us[int(channel)] = float(us)

    def firing_us(self, channel):
        us = self.firings_us[channel]
        return us - 27.778 if self.is_fine and us > 27.778 else us

    def packet(self, blocks, utc, us, mode):
        flags = 1 | (4 if self.has_safety else 0) | (16 if self.has_confidence else 0)
        head = b"\xee\xff\x01\x04\0\0" + bytes([128, 2, 0, 4, 2 if mode == 0x39 else 1, flags])
        body = b""
        for azimuth, units in blocks:
            body += struct.pack("<H", azimuth)
            for unit in units:
                body += struct.pack("<HB", *unit) + (b"\xc8" if self.has_confidence else b"")
        body += b"\x11\x22\x33\x44"  # a checksum, which is not read
        safety = bytes(range(17)) if self.has_safety else b""
        year, *rest = utc
        rpm = round(STEP_DEG / self.block_us * 1e6 / 6)
        tail = bytes(9) + struct.pack("<HBBH6BIB", 0, 0 if self.is_fine else 2, mode, rpm, year - 1900,
                                      *rest, us, 0x42)
        return head + body + safety + tail + struct.pack("<I", 7) + bytes(4)


def hesai_angles(channels):
    """Elevations and azimuths in degrees of channels 1 to `channels`."""
    return [(round(15.1 - 31.3 * i / (channels - 1), 3), (1.09, 5.52, -3.35, -5.56)[i % 4] - 0.003 * i)
            for i in range(channels)]


def hesai_ticks(model, angles, block_azimuth_deg, channel):
    """The distance along where the channel looks at the moment that it fires."""
    elevation_deg, beside_deg = angles[channel - 1]
    turned_deg = STEP_DEG * model.firing_us(channel) / model.block_us
    aim = math.radians(block_azimuth_deg + beside_deg + turned_deg)  # clockwise from y
    rise = math.radians(elevation_deg)
    direction = (math.sin(aim) * math.cos(rise), math.cos(aim) * math.cos(rise), math.sin(rise))
    return round(way_to_wall((0.0, 0.0, 0.0), direction) / model.tick_m)


def write_hesai(folder, model, turns, is_dual):
    """From 321 degrees on: what is left of that turn, `turns` whole ones, and a bit."""
    angles = hesai_angles(model.channels)
    returns = 2 if is_dual else 1
    packets = []
    for index in range(math.ceil((turns + 0.2) * 360 / STEP_DEG * returns / model.blocks)):
        blocks = []
        for block in range(model.blocks):
            azimuth_deg = (321 + STEP_DEG * ((index * model.blocks + block) // returns)) % 360
            units = []
            for channel in range(1, model.channels + 1):
                ticks = hesai_ticks(model, angles, azimuth_deg, channel)
                if is_dual and block % 2 == 1 and channel % 2 == 0:
                    ticks //= 2  # the second return of a pair; the others' are the same
                if (index + block // returns + channel) % 13 == 0:
                    ticks = 0
                units.append((ticks, channel % 256))
            blocks.append((round(100 * azimuth_deg), units))
        us = 999_000 + round(index * model.blocks / returns * model.block_us)  # into the next second
        utc = (2023, 11, 14, 22, 13, 20 + us // 1_000_000)  # START_S
        packet = model.packet(blocks, utc, us % 1_000_000, 0x39 if is_dual else 0x37)
        packets.append((1e-6 * us, packet))
        packets.append((1e-6 * us, bytes(64)))  # what a GNSS receiver sends
    name = model.name + ("_dual" if is_dual else "")
    write_pcap(folder / (name + ".pcap"), packets, 2368)
    rows = [f"{i + 1},{e:.3f},{a:.3f}" for i, (e, a) in enumerate(angles)]
    if model.channels == 32:
        rows.reverse()  # any order will do
    (folder / (name + ".csv")).write_text("Channel,Elevation,Azimuth\n" + "\n".join(rows) + "\n")


def main():
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent)
    # The clock of one counts from its start, that of the others is set.
    write_ouster(folder, "ouster_legacy", "LEGACY", 12_345_678_901, 1500)
    set_ns = START_S * 1_000_000_000
    write_ouster(folder, "ouster_single", "RNG19_RFL8_SIG16_NIR16", set_ns, 9000)
    write_ouster(folder, "ouster_dual", "RNG19_RFL8_SIG16_NIR16_DUAL", set_ns, 1500)
    write_ouster(folder, "ouster_low", "RNG15_RFL8_NIR8", set_ns, 9000)
    write_hesai(folder, Pandar64(), 1, False)
    write_hesai(folder, Xt(32), 2, False)
    write_hesai(folder, Xt(16), 1, True)
    write_hesai(folder, Pandar128(False, True, False), 1, False)
    write_hesai(folder, Pandar128(True, False, True), 1, True)


if __name__ == "__main__":
    main()
