"""Types of the package, for editors and type checkers."""

import ctypes
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

UNMET: Final[int]
EXTRAPOLATED: Final[int]
FAR: Final[int]
TIGHTER_LIMIT: Final[int]
STATIC: Final[int]
UNKNOWN_LOCALIZER: Final[int]
NOT_VISIBLE: Final[int]
CONVERGED: Final[int]
ITERATION_LIMIT: Final[int]
NO_POINTS: Final[int]
NO_OVERLAP: Final[int]
UNCONSTRAINED: Final[int]
WEAK_FORWARD: Final[int]
WEAK_LEFT: Final[int]
WEAK_UP: Final[int]
WEAK_ROLL: Final[int]
WEAK_PITCH: Final[int]
WEAK_YAW: Final[int]
INTEGRITY_UNKNOWN: Final[int]
INTEGRITY_OK: Final[int]
INTEGRITY_DOUBTFUL: Final[int]
INTEGRITY_LOST: Final[int]
NO_SITE: Final[int]

Path = str | bytes | os.PathLike[str]
Numbers = ctypes.Array[ctypes.c_double]

class Error(Exception):
    code: int
    name: str
    def __init__(self, code: int, message: str = ...) -> None: ...

class Range(ctypes.Structure):
    range_m: float
    probability: float
    mean_error_m: float
    distance_m: float
    flags: int
    site: int
    @property
    def flag_names(self) -> list[str]: ...

class Look(ctypes.Structure):
    range_m: float
    return_count: int
    even_beyond_m: float
    point_count: int
    is_by_normals: int
    settles: int
    probability: float
    mean_error_m: float
    distance_m: float
    flags: int
    site: int
    def __init__(self, range_m: float = ..., return_count: int = ..., even_beyond_m: float = ...,
                 point_count: int = ..., is_by_normals: int = ..., settles: int = ...) -> None: ...
    @property
    def flag_names(self) -> list[str]: ...

class LookPlan(ctypes.Structure):
    first: Look
    has_second: int
    weights: Numbers
    constant: float
    doubt_above: float
    second: Look

class Errors(ctypes.Structure):
    longitudinal_m: float
    lateral_m: float
    yaw_rad: float
    kept_longitudinal: float

class Protection(ctypes.Structure):
    protection_m: Numbers
    protection_yaw_rad: float
    place_kind: int
    block_count: int

class Site(ctypes.Structure):
    position_world_m: Numbers
    range_m: float
    probability: float
    mean_error_m: float
    flags: int
    site: int

class Reasons(ctypes.Structure):
    @property
    def range(self) -> str: ...
    @property
    def look(self) -> str: ...

class Column(ctypes.Structure):
    @property
    def name(self) -> str: ...
    @property
    def unit(self) -> str: ...
    @property
    def values(self) -> NDArray[np.float32]: ...

class Promise(ctypes.Structure):
    limit_m: float
    coverage: float
    is_earned: int
    is_of_next_drive: int
    place_count: int
    drive_count: int
    @property
    def statement(self) -> str: ...

class Match(ctypes.Structure):
    T_world_vehicle: Numbers
    information: Numbers
    covariance: Numbers
    score: float
    nearest_voxel_likelihood: float
    work: int
    iterations: int
    stop: int
    point_count: int
    scored_points: int
    dropped_count: int
    look_count: int
    weak: int
    place_kind: int
    protection_m: Numbers
    protection_yaw_rad: float
    integrity: int
    protection_blocks: int
    raised_points: int
    raised_met: int
    @property
    def is_matched(self) -> bool: ...

class Monitor(ctypes.Structure):
    doubt: int
    raised_points: float
    raised_met: float
    def add(self, match: Match) -> int: ...

class Nd(ctypes.Structure):
    mean_world_m: Numbers
    covariance_m2: Numbers
    point_count: int

def pose(position_m: Sequence[float], quaternion_xyzw: Sequence[float]) -> tuple[float, ...]: ...

class Localizer:
    origin_world_m: tuple[float, float, float]
    cell_m: float
    T_vehicle_sensor: tuple[float, ...]
    leaf_m: float
    localizer: str
    kernel: str
    def __init__(self, path: Path, *, cell_m: float = ..., least_points: int = ..., threads: int = ...,
                 azimuth_step_deg: float = ..., T_vehicle_sensor: ArrayLike | None = ...,
                 whole_map: bool = ...) -> None: ...
    def __enter__(self) -> Localizer: ...
    def __exit__(self, *_: object) -> None: ...
    def close(self) -> None: ...
    @property
    def nds(self) -> NDArray[Any]: ...
    @property
    def faults(self) -> list[Error]: ...
    def score(self, scan: NDArray[Any] | memoryview, T_world_vehicle: ArrayLike, look: Look | Range) -> Match: ...
    def prepare(self, position_world_m: Sequence[float], budget_ms: float) -> bool: ...
    def match(self, scan: NDArray[Any] | memoryview, T_world_start: ArrayLike, look: Look | LookPlan | Range, *,
              start_covariance: ArrayLike | None = ..., variance_factor: float = ..., map_m: float = ...,
              map_rad: float = ..., protection_risk: float = ...) -> Match: ...

class Map:
    map_id: str
    version: str
    release: int
    origin_world_m: tuple[float, ...]
    reach_m: float
    ranges_m: tuple[float, ...]
    limits_m: tuple[float, ...]
    site_count: int
    localizer: str
    localizer_version: int
    localizer_parameters: str
    is_for_caller: bool
    world: str
    export_origin_world_m: tuple[float, ...]
    def __init__(self, path: Path, localizer: str | None = ..., in_memory: bool = ...) -> None: ...
    def __enter__(self) -> Map: ...
    def __exit__(self, *_: object) -> None: ...
    def close(self) -> None: ...
    def promise(self, limit: int) -> Promise: ...
    def observation_range(self, position_world_m: Sequence[float], limit_m: float) -> Range: ...
    def reasons(self, position_world_m: Sequence[float], limit_m: float) -> Reasons: ...
    def look(self, position_world_m: Sequence[float], limit_m: float, visible_m: float = ...) -> Look: ...
    def look_plan(self, position_world_m: Sequence[float], limit_m: float, is_tracking: bool,
                  visible_m: float = ...) -> LookPlan: ...
    def columns(self) -> list[str]: ...
    def column(self, name: str) -> Column: ...
    def errors(self, site: int, is_sample: bool = ...) -> Errors: ...
    def protection(self, site: int, risk: float = ..., is_sample: bool = ...) -> Protection: ...
    def sites(self, limit: int = ...) -> NDArray[Any]: ...

@dataclass(frozen=True)
class Localization:
    T_world_vehicle: NDArray[np.float64]
    covariance: NDArray[np.float64]
    is_localized: NDArray[np.bool_]
    integrity: NDArray[np.uint32]
    range_m: NDArray[np.float64]
    point_count: NDArray[np.uint32]
    matches: tuple[Match, ...]

def localize(map_path: Path, scans: Iterable[ArrayLike], T_world_start: ArrayLike, *,
             stamps_s: Iterable[float] | None = ..., limit_m: float = ..., visible_m: float = ...,
             T_vehicle_sensor: ArrayLike | None = ...) -> Localization: ...
