#!/usr/bin/env python3
"""main.cpp from Python:  localize.py MAP SCAN X_M Y_M Z_M YAW_DEG [LIMIT_M]

Needs only python3-sightline; a scan may also be an array of floats of NumPy.
"""

import math
import sys

import sightline

STOPS = ("converged", "iteration limit", "no points", "no overlap")


def read_scan(path):
    """A binary PCD of floats, x y z first, as a view of n rows."""
    with open(path, "rb") as file:
        header, body = file.read().split(b"DATA binary\n", 1)
    facts = dict(line.split(" ", 1) for line in header.decode().splitlines() if " " in line)
    columns = len(facts["FIELDS"].split())
    return memoryview(body).cast("f", (int(facts["POINTS"]), columns))


def main(arguments):
    if len(arguments) not in (6, 7):
        print(__doc__, file=sys.stderr)
        return 64
    guess_m = [float(text) for text in arguments[2:5]]
    half_rad = float(arguments[5]) * math.pi / 180.0 / 2.0
    limit_m = float(arguments[6]) if len(arguments) == 7 else 0.10
    try:
        localizer = sightline.Localizer(arguments[0])
        look = sightline.Look(range_m=50.0)
        if arguments[0].endswith(".slmap"):
            look = sightline.Map(arguments[0], localizer.localizer).look(guess_m, limit_m)
        T_world_guess = sightline.pose(guess_m, (0.0, 0.0, math.sin(half_rad), math.cos(half_rad)))
        match = localizer.match(read_scan(arguments[1]), T_world_guess, look)
    except (sightline.Error, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    T, c = match.T_world_vehicle, match.covariance
    print(f"range_m {look.range_m:g} probability {look.probability:.4f}")
    print(f"stop {STOPS[match.stop]}")
    print(f"position_world_m {T[3]:.17g} {T[7]:.17g} {T[11]:.17g}")
    print(f"heading {T[0]:.17g} {T[4]:.17g}")
    print(f"score {match.score:.17g} iterations {match.iterations} points {match.point_count} "
          f"scored {match.scored_points}")
    print(f"variance_m2 {c[0]:.17g} {c[7]:.17g} {c[14]:.17g} weak {match.weak}")
    return 1 if match.stop in (sightline.NO_POINTS, sightline.NO_OVERLAP) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
