"""The vehicle's localizer."""

import ctypes
import math
import os
from ctypes import byref

from . import _interface as c


def pose(position_m, quaternion_xyzw):
    """The upper three rows of a 4 x 4 matrix, row by row, of a position and a quaternion."""
    x, y, z, w = quaternion_xyzw
    length = math.sqrt(x * x + y * y + z * z + w * w)
    x, y, z, w = x / length, y / length, z / length, w / length
    return (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), position_m[0],
            2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), position_m[1],
            2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), position_m[2])


def _flat(matrix):
    numbers = []
    for row in matrix:
        numbers.extend(row if hasattr(row, "__len__") else (row,))
    return numbers


def _rows(matrix):
    """12 numbers of a 3 x 4 or 4 x 4 matrix, which may be flat."""
    numbers = _flat(matrix)
    return c.doubles(numbers[:12] if len(numbers) == 16 else numbers, 12)


def _points(scan):
    """A view of the scan: n rows of three or more floats or doubles, stored one after the other."""
    view = memoryview(scan)
    if view.format not in ("f", "d") or view.ndim != 2 or view.shape[1] < 3 or not view.c_contiguous:
        raise ValueError("a scan is an array of n rows of x, y, z and maybe more, of floats or doubles, "
                         f"row by row in memory; found shape {view.shape} of '{view.format}'")
    count, columns = view.shape
    if count == 0:
        return c.Points(None, 0, columns * view.itemsize, 0), None
    flat = view.cast("B")
    if flat.readonly:
        memory = ctypes.c_char_p(flat.obj) if type(flat.obj) is bytes and flat.nbytes == len(flat.obj) \
            else ctypes.create_string_buffer(flat.tobytes(), max(1, flat.nbytes))
    else:
        memory = (ctypes.c_char * flat.nbytes).from_buffer(flat)
    points = c.Points(ctypes.cast(memory, ctypes.c_void_p), count, columns * view.itemsize,
                      1 if view.format == "d" else 0)
    return points, memory


class Localizer:
    """A map to localize in: a compiled map, a point cloud, or a folder of clouds.

    cell_m and least_points: of the cells made of a cloud. T_vehicle_sensor: the sensor's place in the
    vehicle where it is not the map's. Of a compiled map only what is near the vehicle is in memory, and a
    thread of the library prepares what comes next; whole_map: all of it is read, checked and kept. Errors are sightline.Error. Safe to use from several threads at
    once; a match runs without Python's lock.
    """

    def __init__(self, path, *, cell_m=0.0, least_points=0, threads=0, azimuth_step_deg=0.0,
                 T_vehicle_sensor=None, whole_map=False):
        library = c.localizer()
        options = c.LocalizerOptions(cell_m, least_points, threads, azimuth_step_deg, None,
                                     1 if whole_map else 0, 0)
        if T_vehicle_sensor is not None:
            options.T_vehicle_sensor = _rows(T_vehicle_sensor)
        self._handle = c.Handle(library.sightline_localizer_open, library.sightline_localizer_close,
                                (os.fsencode(path), byref(options)))
        info = c.LocalizerInfo()
        library.sightline_localizer_get_info(self._handle, byref(info))
        self.origin_world_m = tuple(info.origin_world_m)
        self.cell_m = info.cell_m
        self.T_vehicle_sensor = tuple(info.T_vehicle_sensor)
        self.leaf_m = info.leaf_m
        self.localizer = info.localizer.decode()
        self.kernel = info.kernel.decode()
        self._nds = (c.Nd * info.nd_count).from_address(
            ctypes.cast(info.nds, ctypes.c_void_p).value or 0) if info.nd_count else (c.Nd * 0)()
        self._nds._owner = self._handle  # whose memory it is

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """Arrays of NDs are valid as long as a reference to them exists."""
        self._handle = self._nds = None

    @staticmethod
    def _opened(what):
        """What another thread may have closed."""
        if what is None:
            raise ValueError("the localizer is closed")
        return what

    @property
    def nds(self):
        """The map's normal distributions: an array of sightline.Nd, in the library's memory.

        Of a point cloud, or a compiled map opened with whole_map.
        """
        nds = self._opened(self._nds)
        if not len(nds):
            raise ValueError("the map is read tile by tile: open it with whole_map=True")
        return c.records(nds)

    @property
    def faults(self):
        """A sightline.Error for each tile of the map that could not be read so far."""
        handle, library = self._opened(self._handle), c.localizer()
        faults = []
        for number in range(library.sightline_localizer_fault_count(handle)):
            message = ctypes.create_string_buffer(1024)
            code = library.sightline_localizer_get_fault(handle, number, message, len(message))
            faults.append(c.Error(code, message.value.decode(errors="replace")))
        return faults

    def score(self, scan, T_world_vehicle, look):
        """How well a scan fits the map at a pose, which stays: a sightline.Match.

        Its score, nearest_voxel_likelihood, point_count, scored_points, dropped_count and stop are set.
        """
        handle = self._opened(self._handle)
        points, memory = _points(scan)
        match = c.Match()
        if isinstance(look, c.Range):
            look = c.Look(range_m=look.range_m)
        code = c.localizer().sightline_localizer_score(handle, byref(points), _rows(T_world_vehicle), byref(look),
                                                       byref(match))
        del memory  # until here the library read it
        c.check(code)
        return match

    def prepare(self, position_world_m, budget_ms):
        """Prepares the map ahead of a vehicle there, for about so long. True once all is prepared.

        Optional: a thread of the library does it, and a match prepares what it needs.
        """
        is_done = ctypes.c_int()
        c.check(c.localizer().sightline_localizer_prepare(
            self._opened(self._handle), c.doubles(position_world_m, 3), budget_ms, byref(is_done)))
        return bool(is_done.value)

    def match(self, scan, T_world_start, look, *, start_covariance=None, variance_factor=0.0, map_m=0.0,
              map_rad=0.0, protection_risk=0.0):
        """The pose of the vehicle: a sightline.Match.

        scan: n rows of x, y, z and maybe more, in the sensor's frame: an array of NumPy, or a
        memoryview of two dimensions. T_world_start: 12 numbers (see pose), or a 3 x 4 or 4 x 4 matrix.
        look: of Map.look, Map.look_plan, Map.observation_range, or Look(range_m=...).
        start_covariance: 6 x 6 or 36 numbers, in the order of Match.covariance; the pose is then the
        most probable one. Without it the start is unknown. variance_factor, map_m, map_rad: of the errors of this place; 0: the defaults.
        protection_risk: of Match.protection_m and .protection_yaw_rad in 60 m; 0: 0.01.
        """
        handle = self._opened(self._handle)
        points, memory = _points(scan)
        match = c.Match()
        options = c.MatchOptions(None, variance_factor, map_m, map_rad, protection_risk)
        if start_covariance is not None:
            options.start_covariance = c.doubles(_flat(start_covariance), 36)
        arguments = (handle, byref(points), _rows(T_world_start))
        if isinstance(look, c.LookPlan):
            code = c.localizer().sightline_localizer_match_plan(*arguments, byref(look), byref(options),
                                                                byref(match))
        else:
            if isinstance(look, c.Range):
                look = c.Look(range_m=look.range_m)
            code = c.localizer().sightline_localizer_match(*arguments, byref(look), byref(options),
                                                           byref(match))
        del memory  # until here the library read it
        c.check(code)
        return match
