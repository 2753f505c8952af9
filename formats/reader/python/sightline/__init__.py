"""Compiled maps of sightline from Python: ranges and looks at a position, and localization of a scan.

    with sightline.Map("town.slmap", "searching") as town:
        look = town.look(position_world_m, limit_m=0.10)
    with sightline.Localizer("town.slmap") as localizer:          # or a .pcd
        match = localizer.match(points, T_world_start, look)      # points: n x 3 floats
        match.T_world_vehicle, match.covariance, match.information
    drive = sightline.localize("town.slmap", scans, T_world_start)    # arrays of NumPy, a row a scan

Over the C interfaces of libsightline-reader.so.0 and, for Localizer, libsightline-localizer.so.0. NDs
and sites are arrays in the library's memory: of NumPy if it is installed, else of ctypes.
"""

from ._interface import (CONVERGED, EXTRAPOLATED, FAR, INTEGRITY_DOUBTFUL, INTEGRITY_LOST,
                         INTEGRITY_OK, INTEGRITY_UNKNOWN, ITERATION_LIMIT, NO_OVERLAP, NO_POINTS, NO_SITE,
                         NOT_VISIBLE, STATIC, TIGHTER_LIMIT, UNCONSTRAINED, UNKNOWN_LOCALIZER, UNMET,
                         WEAK_FORWARD, WEAK_LEFT, WEAK_PITCH, WEAK_ROLL, WEAK_UP, WEAK_YAW, Column,
                         Error, Look, LookPlan, Match, Monitor, Nd, Promise, Protection, Range, Site)
from .localize import Localization, localize
from .localizer import Localizer, pose
from .map import Map

__all__ = ["CONVERGED", "Column", "EXTRAPOLATED", "Error", "FAR", "INTEGRITY_DOUBTFUL", "INTEGRITY_LOST",
           "INTEGRITY_OK", "INTEGRITY_UNKNOWN", "ITERATION_LIMIT", "Localization", "Localizer", "Look",
           "LookPlan", "Map", "Match", "Monitor", "NO_OVERLAP", "NO_POINTS", "NO_SITE", "NOT_VISIBLE", "Nd",
           "Promise", "Protection", "Range", "STATIC", "Site", "TIGHTER_LIMIT", "UNCONSTRAINED", "UNKNOWN_LOCALIZER", "UNMET",
           "WEAK_FORWARD", "WEAK_LEFT", "WEAK_PITCH", "WEAK_ROLL", "WEAK_UP", "WEAK_YAW", "localize",
           "pose"]
