"""The structs and functions of sightline_reader.h and sightline_localizer.h, field by field."""

import ctypes
import functools
import os
from ctypes import POINTER, Structure, byref, c_char_p, c_double, c_float, c_int, c_int32, c_size_t, \
    c_uint32, c_uint64, c_void_p

UNMET, EXTRAPOLATED, FAR, TIGHTER_LIMIT, STATIC, UNKNOWN_LOCALIZER, NOT_VISIBLE, SIMULATED = \
    1, 2, 4, 8, 16, 32, 64, 128
_FLAG_NAMES = {UNMET: "unmet", EXTRAPOLATED: "extrapolated", FAR: "far", TIGHTER_LIMIT: "tighter_limit",
               STATIC: "static", UNKNOWN_LOCALIZER: "unknown_localizer", NOT_VISIBLE: "not_visible",
               SIMULATED: "simulated"}
CONVERGED, ITERATION_LIMIT, NO_POINTS, NO_OVERLAP, UNCONSTRAINED = 0, 1, 2, 3, 4
WEAK_FORWARD, WEAK_LEFT, WEAK_UP, WEAK_ROLL, WEAK_PITCH, WEAK_YAW = 1, 2, 4, 8, 16, 32
INTEGRITY_UNKNOWN, INTEGRITY_OK, INTEGRITY_DOUBTFUL, INTEGRITY_LOST = 0, 1, 2, 3
NO_SITE = 0xFFFFFFFF


class _Answer(Structure):
    """Prints its fields, and its flags by name."""

    @property
    def flag_names(self):
        """["far"]: no site is near on this level, for example."""
        return [name for flag, name in _FLAG_NAMES.items() if self.flags & flag]

    def __repr__(self):
        fields = [f"{name}={getattr(self, name)}" for name, _ in self._fields_ if name != "flags"]
        return f"{type(self).__name__}({', '.join(fields)}, flags={'+'.join(self.flag_names) or 'none'})"


class Range(_Answer):
    """A chosen range: sightline_range."""
    _fields_ = [("range_m", c_double), ("probability", c_double), ("mean_error_m", c_double),
                ("distance_m", c_double), ("flags", c_uint32), ("site", c_uint32)]


class Look(_Answer):
    """How a scan becomes the points that are matched: sightline_look. Look(range_m=30): every return."""
    _fields_ = [("range_m", c_double), ("return_count", c_uint32), ("even_beyond_m", c_double),
                ("point_count", c_uint32), ("is_by_normals", c_int), ("settles", c_int),
                ("probability", c_double), ("mean_error_m", c_double), ("distance_m", c_double),
                ("flags", c_uint32), ("site", c_uint32)]


class LookPlan(Structure):
    """A look, a test of its match, a second look: sightline_look_plan."""
    _fields_ = [("first", Look), ("has_second", c_int), ("weights", c_double * 8),
                ("constant", c_double), ("doubt_above", c_double), ("second", Look)]


class Errors(Structure):
    """Errors by direction of a vehicle that tracks: sightline_errors."""
    _fields_ = [("longitudinal_m", c_double), ("lateral_m", c_double), ("yaw_rad", c_double),
                ("kept_longitudinal", c_double)]


class Protection(Structure):
    """Bounds of the errors of a tracking vehicle at a site: sightline_protection."""
    _fields_ = [("protection_m", c_double * 3), ("protection_yaw_rad", c_double),
                ("place_kind", c_uint32), ("block_count", c_uint32)]


class Site(Structure):
    """A site, and the map's answer there for one limit: sightline_site."""
    _fields_ = [("position_world_m", c_double * 3), ("range_m", c_double), ("probability", c_double),
                ("mean_error_m", c_double), ("flags", c_uint32), ("site", c_uint32)]


class Reasons(Structure):
    """Why a site has its range and its look for a limit: sightline_reasons, as names."""
    _fields_ = [("_range", c_uint32), ("_look", c_uint32)]
    range = property(lambda self: reader().sightline_reason_name(self._range).decode())
    look = property(lambda self: reader().sightline_reason_name(self._look).decode())


class Column(Structure):
    """A further figure of every site: sightline_column."""
    _fields_ = [("_name", c_char_p), ("_unit", c_char_p), ("_values", POINTER(c_float)), ("_count", c_size_t)]

    @property
    def name(self):
        return self._name.decode()

    @property
    def unit(self):
        return self._unit.decode()

    @property
    def values(self):
        """One value a site, in the map's memory: a read-only array of NumPy if it is installed."""
        if not self._count:
            return records((c_float * 0)())
        array = (c_float * self._count).from_address(ctypes.cast(self._values, c_void_p).value)
        array._owner = self._map
        view = memoryview(array).cast("B").cast("f").toreadonly()  # the map's memory cannot be written
        try:
            import numpy
        except ImportError:
            return view
        return numpy.frombuffer(view, dtype=numpy.float32)


class MapInfo(Structure):
    _fields_ = [("map_id", c_char_p), ("version", c_char_p), ("release", c_uint64),
                ("origin_world_m", c_double * 3), ("reach_m", c_double), ("ranges_m", POINTER(c_double)),
                ("limits_m", POINTER(c_double)), ("range_count", c_size_t), ("limit_count", c_size_t),
                ("site_count", c_uint32), ("localizer", c_char_p), ("localizer_version", c_uint32),
                ("localizer_parameters", c_char_p), ("is_for_caller", c_int), ("world", c_char_p),
                ("export_origin_world_m", c_double * 3)]


class Promise(Structure):
    """The promise of the map for one of its limits: sightline_promise."""
    _fields_ = [("limit_m", c_double), ("coverage", c_double), ("is_earned", c_int),
                ("is_of_next_drive", c_int), ("place_count", c_uint32), ("drive_count", c_uint32),
                ("_statement", c_char_p)]

    @property
    def statement(self):
        return self._statement.decode()


class LocalizerOptions(Structure):
    _fields_ = [("cell_m", c_double), ("least_points", c_int), ("threads", c_int),
                ("azimuth_step_deg", c_double), ("T_vehicle_sensor", POINTER(c_double)),
                ("holds_whole_map", c_int), ("has_no_thread", c_int)]


class Points(Structure):
    _fields_ = [("first", c_void_p), ("count", c_size_t), ("stride_bytes", c_size_t),
                ("is_double", c_int)]


class MatchOptions(Structure):
    """The covariance of a start, and the errors of a place: sightline_match_options."""
    _fields_ = [("start_covariance", POINTER(c_double)), ("variance_factor", c_double),
                ("map_m", c_double), ("map_rad", c_double), ("protection_risk", c_double)]


class Match(Structure):
    """The result of matching a scan: sightline_match."""
    _fields_ = [("T_world_vehicle", c_double * 12), ("information", c_double * 36),
                ("covariance", c_double * 36), ("score", c_double),
                ("nearest_voxel_likelihood", c_double), ("work", c_uint64), ("iterations", c_int32),
                ("stop", c_uint32), ("point_count", c_uint32), ("scored_points", c_uint32),
                ("dropped_count", c_uint32), ("look_count", c_int32), ("weak", c_uint32), ("place_kind", c_uint32),
                ("protection_m", c_double * 3), ("protection_yaw_rad", c_double),
                ("integrity", c_uint32), ("protection_blocks", c_uint32), ("raised_points", c_uint32),
                ("raised_met", c_uint32)]

    @property
    def is_matched(self):
        return self.stop in (CONVERGED, ITERATION_LIMIT)


class Monitor(Structure):
    """A test of the matches of successive scans: sightline_monitor."""
    _fields_ = [("doubt", c_uint32), ("reserved", c_uint32), ("raised_points", c_double), ("raised_met", c_double)]

    def add(self, match):
        """Adds the next scan's match: the integrity of all so far, INTEGRITY_OK, .._LOST, ..."""
        return localizer().sightline_monitor_add(byref(self), byref(match))


class Nd(Structure):
    """A normal distribution of the map: sightline_nd."""
    _fields_ = [("mean_world_m", c_double * 3), ("covariance_m2", c_double * 6),
                ("point_count", c_uint32), ("reserved", c_uint32)]


class LocalizerInfo(Structure):
    _fields_ = [("origin_world_m", c_double * 3), ("cell_m", c_double),
                ("T_vehicle_sensor", c_double * 12), ("leaf_m", c_double), ("localizer", c_char_p),
                ("kernel", c_char_p), ("nds", POINTER(Nd)), ("nd_count", c_size_t)]


class Error(Exception):
    """A failure, with the stable number and name of schemas/error_codes.md."""

    def __init__(self, code, message=""):
        self.code = code
        self.name = reader().sightline_error_name(code).decode()
        super().__init__(message or f"SL{code} {self.name}")


def check(code, message=""):
    if code != 0:
        raise Error(code, message)


def _library(name):
    """The library that a wheel brings, else that of the system."""
    own = os.path.join(os.path.dirname(os.path.abspath(__file__)), "libraries", name)
    return ctypes.CDLL(own if os.path.exists(own) else name)


def _declare(library, functions):
    for name, result, *arguments in functions:
        function = getattr(library, name)
        function.restype = result
        function.argtypes = arguments
    return library


@functools.lru_cache(maxsize=None)
def reader():
    return _declare(_library("libsightline-reader.so.0"), [
        ("sightline_open", c_int, c_char_p, c_char_p, POINTER(c_void_p), c_char_p, c_size_t),
        ("sightline_open_in_memory", c_int, c_char_p, c_char_p, POINTER(c_void_p), c_char_p, c_size_t),
        ("sightline_close", None, c_void_p),
        ("sightline_get_info", None, c_void_p, POINTER(MapInfo)),
        ("sightline_get_promise", c_int, c_void_p, c_size_t, POINTER(Promise)),
        ("sightline_observation_range", c_int, c_void_p, POINTER(c_double), c_double, POINTER(Range)),
        ("sightline_get_reasons", c_int, c_void_p, POINTER(c_double), c_double, POINTER(Reasons)),
        ("sightline_reason_name", c_char_p, c_uint32),
        ("sightline_get_look", c_int, c_void_p, POINTER(c_double), c_double, c_double, POINTER(Look)),
        ("sightline_get_look_plan", c_int, c_void_p, POINTER(c_double), c_double, c_int, c_double,
         POINTER(LookPlan)),
        ("sightline_get_sites", c_int, c_void_p, c_size_t, c_void_p, c_size_t),
        ("sightline_column_count", c_size_t, c_void_p),
        ("sightline_get_column", c_int, c_void_p, c_size_t, POINTER(Column)),
        ("sightline_get_errors", c_int, c_void_p, c_uint32, c_int, POINTER(Errors)),
        ("sightline_get_protection", c_int, c_void_p, c_uint32, c_double, c_int,
         POINTER(Protection)),
        ("sightline_reader_version", c_char_p),
        ("sightline_error_name", c_char_p, c_int)])


@functools.lru_cache(maxsize=None)
def localizer():
    return _declare(_library("libsightline-localizer.so.0"), [
        ("sightline_localizer_open", c_int, c_char_p, POINTER(LocalizerOptions), POINTER(c_void_p),
         c_char_p, c_size_t),
        ("sightline_localizer_close", None, c_void_p),
        ("sightline_localizer_get_info", None, c_void_p, POINTER(LocalizerInfo)),
        ("sightline_localizer_match", c_int, c_void_p, POINTER(Points), POINTER(c_double), POINTER(Look),
         POINTER(MatchOptions), POINTER(Match)),
        ("sightline_localizer_match_plan", c_int, c_void_p, POINTER(Points), POINTER(c_double),
         POINTER(LookPlan), POINTER(MatchOptions), POINTER(Match)),
        ("sightline_localizer_score", c_int, c_void_p, POINTER(Points), POINTER(c_double), POINTER(Look),
         POINTER(Match)),
        ("sightline_localizer_prepare", c_int, c_void_p, POINTER(c_double), c_double, POINTER(c_int)),
        ("sightline_localizer_fault_count", c_size_t, c_void_p),
        ("sightline_localizer_get_fault", c_int, c_void_p, c_size_t, c_char_p, c_size_t),
        ("sightline_monitor_add", c_uint32, POINTER(Monitor), POINTER(Match)),
        ("sightline_localizer_version", c_char_p)])


class Handle:
    """A handle of the library; closed with its last reference.

    A function of the library is given the Handle itself, so that another thread that closes its
    owner meanwhile does not free what the function reads.
    """

    def __init__(self, open_function, close_function, arguments):
        self._close = close_function
        self.pointer = c_void_p()
        message = ctypes.create_string_buffer(1024)
        code = open_function(*arguments, byref(self.pointer), message, len(message))
        check(code, message.value.decode(errors="replace"))
        self._as_parameter_ = self.pointer

    def __del__(self):
        if self.pointer:
            self._close(self.pointer)


def doubles(values, count):
    numbers = [float(value) for value in values]
    if len(numbers) != count:
        raise ValueError(f"{len(numbers)} numbers, expected {count}")
    return (c_double * count)(*numbers)


def records(array):
    """The same memory as a read-only array of NumPy if it is installed, else unchanged."""
    try:
        import numpy
    except ImportError:
        return array
    view = numpy.frombuffer(array, dtype=numpy.dtype(array._type_)) if len(array) else \
        numpy.zeros(0, dtype=numpy.dtype(array._type_))
    view.flags.writeable = False
    return view
