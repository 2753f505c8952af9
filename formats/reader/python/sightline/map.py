"""The vehicle's map reader."""

import math
import os
from ctypes import byref

from . import _interface as c


class Map:
    """A compiled map open for looking up, for a vehicle that localizes with the localizer named.

    Errors are sightline.Error. Safe to use from several threads at once. A map must be replaced by
    renaming a new file over it, never in place; with in_memory the whole file is read first, and what
    happens to it later changes nothing.
    """

    def __init__(self, path, localizer="searching", in_memory=False):
        library = c.reader()
        name = None if localizer is None else localizer.encode()
        opener = library.sightline_open_in_memory if in_memory else library.sightline_open
        self._handle = c.Handle(opener, library.sightline_close, (os.fsencode(path), name))
        info = c.MapInfo()
        library.sightline_get_info(self._handle, byref(info))
        self.map_id = info.map_id.decode()
        self.version = info.version.decode()
        self.release = info.release
        self.origin_world_m = tuple(info.origin_world_m)
        self.reach_m = info.reach_m
        self.ranges_m = tuple(info.ranges_m[:info.range_count])
        self.limits_m = tuple(info.limits_m[:info.limit_count])
        self.site_count = info.site_count
        self.localizer = info.localizer.decode()
        self.localizer_version = info.localizer_version
        self.localizer_parameters = info.localizer_parameters.decode()
        self.is_for_caller = bool(info.is_for_caller)
        self.world = info.world.decode()
        self.export_origin_world_m = tuple(info.export_origin_world_m)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self._handle = None

    def _open(self):
        handle = self._handle  # another thread may close the map
        if handle is None:
            raise ValueError("the map is closed")
        return handle

    def promise(self, limit):
        """The promise of the map for limits_m[limit]."""
        promise = c.Promise()
        promise._map = self._open()  # its sentence lies in the map
        c.check(c.reader().sightline_get_promise(promise._map, limit, byref(promise)))
        return promise

    def observation_range(self, position_world_m, limit_m):
        """The range for that accuracy at this position of the sensor; `far` if no site is near on its level."""
        answer = c.Range()
        c.check(c.reader().sightline_observation_range(
            self._open(), c.doubles(position_world_m, 3), limit_m, byref(answer)))
        return answer

    def reasons(self, position_world_m, limit_m):
        """The names of the rules that decided `range` and `look` there, "none" if no site is used."""
        reasons = c.Reasons()
        c.check(c.reader().sightline_get_reasons(
            self._open(), c.doubles(position_world_m, 3), limit_m, byref(reasons)))
        return reasons

    def look(self, position_world_m, limit_m, visible_m=math.inf):
        """The look for a sensor at this position if it now sees visible_m far."""
        answer = c.Look()
        c.check(c.reader().sightline_get_look(
            self._open(), c.doubles(position_world_m, 3), limit_m, visible_m, byref(answer)))
        return answer

    def look_plan(self, position_world_m, limit_m, is_tracking, visible_m=math.inf):
        """The plan for a tracking vehicle at this position."""
        answer = c.LookPlan()
        c.check(c.reader().sightline_get_look_plan(
            self._open(), c.doubles(position_world_m, 3), limit_m, 1 if is_tracking else 0,
            visible_m, byref(answer)))
        return answer

    def _columns(self):
        library = c.reader()
        handle = self._open()
        for index in range(library.sightline_column_count(handle)):
            column = c.Column()
            code = library.sightline_get_column(handle, index, byref(column))
            column._map = handle  # its names and values are in the map
            yield column, code

    def columns(self):
        """The names of further figures of each site, ascending."""
        return [column.name for column, _ in self._columns()]

    def column(self, name):
        """One of them, a sightline.Column: name, unit, and values by the number of a site."""
        for column, code in self._columns():
            if column.name == name:
                c.check(code)
                return column
        raise KeyError(f"the map has no column {name!r}, only {self.columns()}")

    def errors(self, site, is_sample=False):
        """Standard deviations of a tracking vehicle's matches at a site, infinite if not measured.

        Of every return within the longest range, or of a look that takes a sample.
        """
        errors = c.Errors()
        c.check(c.reader().sightline_get_errors(self._open(), site, 1 if is_sample else 0,
                                                byref(errors)))
        return errors

    def protection(self, site, risk=0.01, is_sample=False):
        """Bounds of a tracking vehicle's errors at a site, infinite if not available.

        Each is exceeded in at most the share `risk` of stretches of 60 m of such places.
        """
        protection = c.Protection()
        c.check(c.reader().sightline_get_protection(self._open(), site, risk, 1 if is_sample else 0,
                                                    byref(protection)))
        return protection

    def sites(self, limit=0):
        """Every site with the map's answer for limits_m[limit]: an array of sightline.Site."""
        sites = (c.Site * self.site_count)()
        c.check(c.reader().sightline_get_sites(self._open(), limit, sites, len(sites)))
        return c.records(sites)
