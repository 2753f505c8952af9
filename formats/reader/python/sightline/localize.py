"""A drive localized in a compiled map, scan after scan, with NumPy."""

import dataclasses
import math

from . import _interface as c
from .localizer import Localizer
from .map import Map

# A pause after which the last speed no longer predicts the pose.
LONGEST_STEP_S = 2.0
# One pose does not predict the next: starts so far ahead of it, m.
SECOND_STARTS_M = (0.0, 1.0, 2.0, 3.0, -1.0)


@dataclasses.dataclass(frozen=True)
class Localization:
    """What `localize` finds: arrays of NumPy, a row a scan.

    T_world_vehicle: n x 4 x 4. covariance: n x 6 x 6, of x, y, z and turns about the axes of the world,
    m and rad. is_localized: n, whether the match is a pose; where it is not, T_world_vehicle is the
    predicted one. integrity: n, of the scans so far, sightline.INTEGRITY_OK, .._DOUBTFUL, .._LOST.
    range_m, point_count: n, of the look whose match is the pose. matches: n sightline.Match.
    """
    T_world_vehicle: object
    covariance: object
    is_localized: object
    integrity: object
    range_m: object
    point_count: object
    matches: tuple


def _matrix(numpy, rows):
    matrix = numpy.eye(4)
    matrix[:3] = numpy.asarray(rows, dtype=float).reshape(3, 4)
    return matrix


def _power(numpy, motion, factor):
    """Of a rigid motion, so often: turned about its axis and moved along the line."""
    cosine = min(1.0, max(-1.0, 0.5 * (numpy.trace(motion[:3, :3]) - 1.0)))
    angle = math.acos(cosine)
    result = numpy.eye(4)
    result[:3, 3] = factor * motion[:3, 3]
    if angle > 1e-9:
        skew = (motion[:3, :3] - motion[:3, :3].T) / (2.0 * math.sin(angle))
        result[:3, :3] += math.sin(factor * angle) * skew + (1.0 - math.cos(factor * angle)) * skew @ skew
    return result


class _Vehicle:
    """The vehicle between two scans."""

    def __init__(self, numpy, town, localizer, T_world_start, limit_m, visible_m):
        self.numpy, self.town, self.localizer = numpy, town, localizer
        self.limit_m, self.visible_m = limit_m, visible_m
        self.T_vehicle_sensor = _matrix(numpy, localizer.T_vehicle_sensor)
        self.T_last, self.last_s, self.count = T_world_start, None, 0
        self.seen_s = None  # of the scan before this one, whether or not it was localized
        self.motion, self.step_s = None, 0.0
        self.monitor = c.Monitor()

    def starts(self, stamp_s):
        numpy = self.numpy
        if self.count == 0:
            return [self.T_last], False
        if self.motion is not None:
            return [self.T_last @ _power(numpy, self.motion, (stamp_s - self.last_s) / self.step_s)], True
        return [self.T_last @ _matrix(numpy, [1, 0, 0, x_m, 0, 1, 0, 0, 0, 0, 1, 0]) for x_m in SECOND_STARTS_M], False

    def match(self, scan, T_start, is_tracking):
        sensor_m = (T_start @ self.T_vehicle_sensor)[:3, 3]
        plan = self.town.look_plan(sensor_m, self.limit_m, is_tracking, self.visible_m)
        if not is_tracking:
            plan.first.settles = 0
        match = self.localizer.match(scan, T_start, plan)
        return match, plan.second if match.look_count > 1 else plan.first

    def take(self, scan, stamp_s):
        """Pose, match, look, integrity, and whether the match is a pose."""
        if self.seen_s is not None and stamp_s <= self.seen_s:
            raise ValueError(f"times of scans must ascend; found {stamp_s} s after {self.seen_s} s")
        self.seen_s = stamp_s
        if self.last_s is not None and stamp_s - self.last_s > LONGEST_STEP_S:
            self.count, self.motion = 0, None
        starts, is_tracking = self.starts(stamp_s)
        tried = [(*self.match(scan, start, is_tracking), start) for start in starts]
        match, look, start = max(tried, key=lambda one: one[0].score / max(1, one[0].point_count))
        integrity = self.monitor.add(match)
        if not match.is_matched:
            return start, match, look, integrity, False
        T = _matrix(self.numpy, match.T_world_vehicle)
        if self.count > 0:
            self.motion, self.step_s = self.numpy.linalg.inv(self.T_last) @ T, stamp_s - self.last_s
        self.T_last, self.last_s, self.count = T, stamp_s, self.count + 1
        return T, match, look, integrity, True


def localize(map_path, scans, T_world_start, *, stamps_s=None, limit_m=0.10, visible_m=math.inf,
             T_vehicle_sensor=None):
    """Localizes scans that follow each other in a compiled map, by the map's plan: a sightline.Localization.

    scans: an iterable of arrays of n rows of x, y, z and maybe more, in the sensor's frame; they are read
    one at a time. Motion within a scan must be corrected before. T_world_start: of the first scan, right to
    about a metre and a few degrees; 3 x 4 or 4 x 4, or 12 numbers (see pose). stamps_s: times of the scans;
    default: 0.1 s apart. limit_m: one of the map's limits. T_vehicle_sensor: where it is not the map's.
    Errors: sightline.Error; ValueError if times do not ascend or are fewer than scans; ImportError without
    NumPy. `sightline localize` also searches the whole map and checks that scans show it.
    """
    import numpy
    start = numpy.asarray(T_world_start, dtype=float)
    start = _matrix(numpy, start.reshape(-1)[:12])
    stamps = None if stamps_s is None else iter(stamps_s)
    found = []
    with Localizer(map_path, T_vehicle_sensor=T_vehicle_sensor) as localizer, \
            Map(map_path, localizer.localizer) as town:
        vehicle = _Vehicle(numpy, town, localizer, start, limit_m, visible_m)
        for number, scan in enumerate(scans):
            stamp_s = 0.1 * number if stamps is None else next(stamps, None)
            if stamp_s is None:
                raise ValueError(f"stamps_s has {number} times, fewer than there are scans")
            found.append(vehicle.take(numpy.ascontiguousarray(scan), stamp_s))
    return _localization(numpy, found)


def _localization(numpy, found):
    matches = tuple(one[1] for one in found)
    return Localization(
        numpy.array([one[0] for one in found]).reshape(-1, 4, 4),
        numpy.array([numpy.array(match.covariance).reshape(6, 6) for match in matches]).reshape(-1, 6, 6),
        numpy.array([one[4] for one in found], dtype=bool),
        numpy.array([one[3] for one in found], dtype=numpy.uint32),
        numpy.array([one[2].range_m for one in found], dtype=float),
        numpy.array([match.point_count for match in matches], dtype=numpy.uint32), matches)
