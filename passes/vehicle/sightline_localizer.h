#ifndef SIGHTLINE_LOCALIZER_H
#define SIGHTLINE_LOCALIZER_H

/* Where a vehicle is: the C interface of the localizer whose errors a map predicts as "searching".
 *
 * Functions return 0 or the stable number of an error (schemas/error_codes.md). A localizer may be
 * used from several threads at once. A pointer may be NULL: the answer is then the number of
 * bad-argument, and what else is pointed to is filled as on any failure. Poses are the upper three
 * rows of a 4 x 4 matrix, row by row: T_a_b takes coordinates in frame b to coordinates in frame a.
 * The world is the map's: that of the recording, or of the point cloud's file. */

#include <stddef.h>
#include <stdint.h>

#include "formats/reader/sightline_reader.h"

#ifdef __cplusplus
extern "C" {
#endif
#ifdef __GNUC__
#pragma GCC visibility push(default)
#endif

typedef struct sightline_localizer sightline_localizer;

/* All zeros: what a map says, and the compiler's own numbers for a point cloud. */
typedef struct sightline_localizer_options {
  double cell_m;                  /* edge of an NDT cell made of a point cloud; 0: 2 m */
  int least_points;               /* that such a cell needs; 0: 10 */
  int threads;                    /* that open a point cloud; 0: all there are */
  double azimuth_step_deg;        /* of the sensor; 0: the map's, of a point cloud 0.2 */
  const double* T_vehicle_sensor; /* 12 numbers; NULL: the map's, of a point cloud the identity */
  /* 1: a compiled map is read, checked and prepared whole when it is opened, and info lists its
   * NDs. 0: it is read tile by tile, and only what is near the vehicle is held in memory. Of a
   * point cloud all is held. Matches give the same bits. */
  int holds_whole_map;
  /* 1: the library starts no thread. 0: a thread prepares the map ahead of the vehicle. */
  int has_no_thread;
} sightline_localizer_options;

/* Points of one scan in the sensor's frame, in metres, as they lie in memory: x, y and z follow
 * each other. Those that are not finite or exactly (0,0,0) are no returns and are left out. */
typedef struct sightline_points {
  const void* first;   /* x of the first point */
  size_t count;        /* less than 2^31 */
  size_t stride_bytes; /* from one point's x to the next point's */
  int is_double;       /* 1: double, 0: float */
} sightline_points;

/* Why a match ended. */
#define SIGHTLINE_CONVERGED 0u
#define SIGHTLINE_ITERATION_LIMIT 1u
#define SIGHTLINE_NO_POINTS 2u  /* the look takes none of this scan: the pose is the start */
#define SIGHTLINE_NO_OVERLAP 3u /* no point has a part of the map near: the pose is the start */
/* Fewer than six points have a part of the map near, or the surfaces and lines that they meet leave
 * a motion entirely free: the pose is no answer. */
#define SIGHTLINE_UNCONSTRAINED 4u

/* Bits of sightline_match.weak: motions along and about the vehicle's axes. */
#define SIGHTLINE_WEAK_FORWARD 1u
#define SIGHTLINE_WEAK_LEFT 2u
#define SIGHTLINE_WEAK_UP 4u
#define SIGHTLINE_WEAK_ROLL 8u
#define SIGHTLINE_WEAK_PITCH 16u
#define SIGHTLINE_WEAK_YAW 32u

/* How wrong a match may be. All zeros: the start is unknown, and the numbers are those that
 * schemas/definitions.md gives ("Covariance of a match"). Matrices have 36 numbers, row by row;
 * order dx dy dz wx wy wz: the position of the vehicle and turns about it, world axes, m and rad.
 */
typedef struct sightline_match_options {
  /* Of T_world_start; NULL: unknown. Where it is given, the pose is the most probable one: a motion
   * that scan and map do not constrain keeps its start, and the search is limited by it. */
  const double* start_covariance;
  double variance_factor; /* of a place: of errors that differ from cell to cell; 0: default */
  double map_m;           /* and of those that all cells in view share, along each axis */
  double map_rad;         /* about each axis; both 0: default */
  double protection_risk; /* of protection levels, in 60 m; 0: 0.01 */
} sightline_match_options;

/* Whether a match is like the good ones of such places. */
#define SIGHTLINE_INTEGRITY_UNKNOWN 0u /* nothing was matched */
#define SIGHTLINE_INTEGRITY_OK 1u
#define SIGHTLINE_INTEGRITY_DOUBTFUL 2u
#define SIGHTLINE_INTEGRITY_LOST 3u /* of sightline_monitor_add alone */

typedef struct sightline_match {
  double T_world_vehicle[12];
  /* What scan and map constrain of the pose, whatever the start: the inverse of a covariance,
   * singular where nothing constrains a motion. A filter that supplied the start adds this to its
   * own information, and information times the measured step from the start, which is
   * covariance^-1 (pose - start). */
  double information[36];
  /* Of this pose, given the start's: (information + start_covariance^-1)^-1. An unknown start has
   * 100 m and 1 rad. */
  double covariance[36];
  double score;
  double nearest_voxel_likelihood; /* mean over scored points of the largest single term */
  uint64_t work;                   /* points x iterations: a stand-in for time that never varies */
  int32_t iterations;
  uint32_t stop;
  uint32_t point_count;   /* that were matched; of the last look */
  uint32_t scored_points; /* of these, that have a part of the map near */
  uint32_t dropped_count; /* points of the scan that are no returns */
  int32_t look_count;     /* 1; 2 where a plan's second look followed */
  uint32_t weak;          /* SIGHTLINE_WEAK_*: not constrained to 0.25 m or 0.02 rad */
  uint32_t place_kind;    /* of the nearest site: the column `place_kind` of the map; 0: unknown */
  /* Protection levels of this pose: forward, left and up of the vehicle, and of its yaw. At most
   * the chosen share of stretches of 60 m has a scan whose error exceeds it, each axis by itself,
   * if places are like those that calibrated it ("Protection levels" in schemas/definitions.md:
   * worlds that were generated). Infinity: unavailable, because no covariance of the start was
   * given, the numbers of a place were, nothing was matched, or too few places calibrated that
   * risk. */
  double protection_m[3];
  double protection_yaw_rad;
  uint32_t integrity;         /* SIGHTLINE_INTEGRITY_* of this match alone */
  uint32_t protection_blocks; /* of 60 m that calibrated the levels */
  /* Of at most 512 of the points: those in no cell of the map with a horizontal surface, and of
   * these the ones that the map has. Both 0 in a small map (emit-map.size: promise), which lacks
   * parts of walls and poles. For sightline_monitor_add. */
  uint32_t raised_points;
  uint32_t raised_met;
} sightline_match;

/* A test of the matches of successive scans (about 1 m apart): a single doubtful match in several
 * hundred is no alarm. All zeros: a new one. Copy it freely; it needs no memory. */
typedef struct sightline_monitor {
  uint32_t doubt;
  uint32_t reserved;
  double raised_points; /* sums; those of earlier scans count less */
  double raised_met;
} sightline_monitor;

/* A normal distribution of the map. */
typedef struct sightline_nd {
  double mean_world_m[3];
  double covariance_m2[6]; /* xx xy xz yy yz zz, raw */
  uint32_t point_count;
  uint32_t reserved;
} sightline_nd;

/* Pointers stay valid until sightline_localizer_close. */
typedef struct sightline_localizer_info {
  double origin_world_m[3]; /* of the frame that is matched in, near the map */
  double cell_m;
  double T_vehicle_sensor[12];
  double leaf_m;           /* edge of the voxels that thin a scan */
  const char* localizer;   /* "searching": what the reader of this map is to be asked for */
  const char* kernel;      /* "avx2": the fastest of this processor; all give the same bits */
  const sightline_nd* nds; /* of a map that is held whole, else NULL and 0 */
  size_t nd_count;
} sightline_localizer_info;

/* Opens what is localized in: a compiled map (.slmap), a point cloud (PCD, PLY, LAS, .npy, or any
 * of them in gzip) or a folder of such clouds, as Autoware's. Of a cloud the normal distributions
 * are computed as the compiler does. `options` may be NULL. On success *localizer is to be closed;
 * on failure it is NULL, and a sentence about what was found goes to message (cut to message_size,
 * always terminated), which may be NULL. Errors: those of reading a map or a cloud; empty-map (no
 * cell has points enough), unsupported-format (points farther apart than a grid reaches), bad-value
 * (an option). */
int sightline_localizer_open(const char* path, const sightline_localizer_options* options,
                             sightline_localizer** localizer, char* message, size_t message_size);

/* NULL is fine. */
void sightline_localizer_close(sightline_localizer* localizer);

void sightline_localizer_get_info(const sightline_localizer* localizer,
                                  sightline_localizer_info* info);

/* The vehicle's pose by one look (see sightline_get_look; of a range alone range_m is set and all
 * else is 0) from a start that is about a metre and a few degrees off at most; with look->settles
 * from one that is nearly right. The answer to what can be matched is match->stop. Same points,
 * start, map and look give the same bits on every machine. `options` may be NULL. Errors:
 * bad-argument (a start that is no rigid motion, or more than 2^29 cells from the map; a look that
 * is none; a covariance that is not symmetric; too many points), out-of-memory; then *match is 0
 * but for the pose, which is the start. */
int sightline_localizer_match(const sightline_localizer* localizer, const sightline_points* scan,
                              const double T_world_start[12], const sightline_look* look,
                              const sightline_match_options* options, sightline_match* match);

/* The same by a plan (see sightline_get_look_plan) for a vehicle that tracks: T_world_start is
 * where it predicts itself, and the second look follows where the first one's match is doubted. A
 * plan without a second look is its first. */
int sightline_localizer_match_plan(const sightline_localizer* localizer,
                                   const sightline_points* scan, const double T_world_start[12],
                                   const sightline_look_plan* plan,
                                   const sightline_match_options* options, sightline_match* match);

/* How well the points of a scan fit the map at a pose, which stays: fills score,
 * nearest_voxel_likelihood, point_count, scored_points, dropped_count and stop of *match, as a
 * match that ends there does, and leaves the rest as sightline_localizer_match does on failure.
 * Scores are comparable between scans that are cut by the same look. Errors: as
 * sightline_localizer_match. */
int sightline_localizer_score(const sightline_localizer* localizer, const sightline_points* scan,
                              const double T_world_vehicle[12], const sightline_look* look,
                              sightline_match* match);

/* Prepares the map ahead of a vehicle at that place, which moves as its last matches did, in steps
 * of about a millisecond, the longest of about four, until budget_ms have passed; at least one.
 * *is_done, which may be NULL, is 1 once nothing is left to prepare. For a program that has its own
 * threads or a real-time loop (has_no_thread). Optional: a match prepares what it needs and is not
 * prepared, so results never depend on it. Errors: bad-argument, out-of-memory. */
int sightline_localizer_prepare(const sightline_localizer* localizer,
                                const double position_world_m[3], double budget_ms, int* is_done);

/* Tiles of the map that were needed and could not be read, so far. Matches use the rest. */
size_t sightline_localizer_fault_count(const sightline_localizer* localizer);

/* Why the tile of that fault, from 0 to fault_count - 1, could not be read: returns the error, and
 * writes a sentence that names the tile to message, as sightline_localizer_open does. Errors:
 * bad-argument, where there is no such fault; out-of-memory. */
int sightline_localizer_get_fault(const sightline_localizer* localizer, size_t number,
                                  char* message, size_t message_size);

/* Adds the next scan's match, and returns SIGHTLINE_INTEGRITY_* of all so far: doubtful matches
 * count up to 6, others down; doubtful from 2 on, lost from 4 on. Doubtful too while the map has
 * fewer of the raised points of the last scans than at good matches of such places. NULL: unknown.
 */
uint32_t sightline_monitor_add(sightline_monitor* monitor, const sightline_match* match);

/* "0.1.0": of the library that answers. */
const char* sightline_localizer_version(void);

#ifdef __GNUC__
#pragma GCC visibility pop
#endif
#ifdef __cplusplus
}
#endif

#endif
