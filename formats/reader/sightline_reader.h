#ifndef SIGHTLINE_READER_H
#define SIGHTLINE_READER_H

/* How far to look: the C interface of the vehicle's map reader.
 *
 * Functions return 0 or the stable number of an error (schemas/error_codes.md). A map may be used
 * from several threads at once; after sightline_open a look-up that succeeds allocates nothing. A
 * pointer may be NULL: the answer is then the number of bad-argument, and nothing else happens.
 * What is pointed to is filled as on any failure; without a map the longest range is INFINITY.
 *
 * The file is read where it lies (mmap). Replace a map by renaming a new file over it, never in
 * place: a file that is shortened while it is open ends the process (SIGBUS). Where that cannot be
 * promised, sightline_open_in_memory reads the whole file first. */

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif
#ifdef __GNUC__
#pragma GCC visibility push(default)
#endif

typedef struct sightline_map sightline_map;

/* Flags of an answer. */
#define SIGHTLINE_UNMET 1u         /* no range is good enough here */
#define SIGHTLINE_EXTRAPOLATED 2u  /* unlike what the model was trained on */
#define SIGHTLINE_FAR 4u           /* no site within the map's reach: the longest range */
#define SIGHTLINE_TIGHTER_LIMIT 8u /* tighter than any limit of the map: the longest range */
#define SIGHTLINE_STATIC 16u       /* the street's own static answer: no model is believed here */
/* The map's errors were measured with another localizer than the caller's: the longest range. */
#define SIGHTLINE_UNKNOWN_LOCALIZER 32u

#define SIGHTLINE_SIMULATED 128u  /* no scan was ever seen here: simulation decided */
#define SIGHTLINE_NOT_VISIBLE 64u /* neither look nor range lies within what can be seen now */

#define SIGHTLINE_NO_SITE UINT32_MAX

typedef struct sightline_range {
  double range_m; /* how far to look */
  /* That the localization error is within the limit, at this range. */
  double probability;  /* NaN with SIGHTLINE_UNKNOWN_LOCALIZER */
  double mean_error_m; /* predicted, at this range; infinity far from any site; NaN as above */
  double distance_m;   /* 3D, to the nearest site; infinity far from any */
  uint32_t flags;
  uint32_t site; /* the nearest one, or SIGHTLINE_NO_SITE */
} sightline_range;

/* The cheapest way to localize: how a scan becomes the points that are matched. */
typedef struct sightline_look {
  double range_m;        /* 3D slant range from the sensor */
  uint32_t return_count; /* so many returns of a scan are looked at, spread evenly; 0: every one */
  double even_beyond_m;  /* nearer returns are kept with chance (r / even_beyond_m)^2; 0: all */
  uint32_t point_count;  /* matched at most; 0: all that are left */
  int is_by_normals;     /* 1: taken in turn from the directions of the map's normals */
  int settles;           /* 1: matched on the last level alone, for a vehicle that tracks */
  /* As in sightline_range, of this look. */
  double probability;
  double mean_error_m;
  double distance_m;
  uint32_t flags;
  uint32_t site;
} sightline_look;

/* How to localize step by step: a look, a test of what its match shows, and a second look
 * where the test doubts it ("Driving by a plan" in schemas/definitions.md). */
typedef struct sightline_look_plan {
  sightline_look first; /* probability and mean_error_m are NaN where a second look may follow */
  int has_second;       /* 1, or 0: the first look stands, and what is below is 0 */
  double weights[8];    /* doubt = constant + the sum of weights times the eight signs */
  double constant;
  double doubt_above;    /* the second look is taken where doubt is above this */
  sightline_look second; /* probability and mean_error_m are NaN */
} sightline_look_plan;

/* A site, and what the map holds there for one limit: as in sightline_range. */
typedef struct sightline_site {
  double position_world_m[3];
  double range_m;
  double probability;
  double mean_error_m;
  uint32_t flags;
  uint32_t site;
} sightline_site;

/* Pointers stay valid until sightline_close. */
typedef struct sightline_info {
  const char* map_id;
  const char* version;
  uint64_t release;
  double origin_world_m[3];
  double reach_m;
  const double* ranges_m; /* ascending */
  const double* limits_m; /* ascending */
  size_t range_count;
  size_t limit_count;
  uint32_t site_count;
  /* The localizer whose errors were measured, its definition's version, and what the name leaves
   * open ("leaf_m=1, ..."). */
  const char* localizer;
  uint32_t localizer_version;
  const char* localizer_parameters;
  int is_for_caller; /* 1 where that is the localizer that the caller named */
  /* Where positions lie: "local" (the recording's own coordinates), "utm:32N", "mgrs:32UMV" or
   * "enu:LATITUDE,LONGITUDE,ALTITUDE". */
  const char* world;
  /* Of exported clouds (autoware, pcd, ply): a vehicle that localizes in one asks at its position
   * plus this. All 0 but for worlds of 100 km and more. */
  double export_origin_world_m[3];
} sightline_info;

/* What the map promises within one of its limits: a promise is about the next drive. */
typedef struct sightline_promise {
  double limit_m;
  double coverage;      /* least share of the answered places (flag 1 not set) expected within the
                           limit; 0: not earned */
  int is_earned;        /* 1 or 0 */
  int is_of_next_drive; /* 1: set on drives that the model did not learn from */
  uint32_t place_count; /* that it was set on */
  uint32_t drive_count;
  const char* statement; /* one sentence for people; valid until sightline_close */
} sightline_promise;

/* Opens a map for a vehicle that localizes with the localizer named: "searching", "pcl-ndt", the
 * name under which errors of one outside were imported, or "searching/3" for that version of its
 * definition alone. Where the map's errors were measured with another, or localizer is NULL, every
 * answer is the longest range with SIGHTLINE_UNKNOWN_LOCALIZER. Checks the map. On success *map is
 * to be closed; on failure it is NULL, and a sentence about what was found goes to message
 * (cut to message_size, always terminated), which may be NULL. */
int sightline_open(const char* path, const char* localizer, sightline_map** map, char* message,
                   size_t message_size);

/* The same, but reads the whole file into memory: what happens to it later changes nothing. */
int sightline_open_in_memory(const char* path, const char* localizer, sightline_map** map,
                             char* message, size_t message_size);

/* NULL is fine. */
void sightline_close(sightline_map* map);

void sightline_get_info(const sightline_map* map, sightline_info* info);

/* `limit` is an index into limits_m. Returns 0, or the number of bad-argument for another one, and
 * then *promise promises nothing. */
int sightline_get_promise(const sightline_map* map, size_t limit, sightline_promise* promise);

/* The range for a sensor at a position in world coordinates (x, y, z in metres, as the map's frame
 * defines) and an accuracy of limit_m: what the map holds at the nearest site on the level of the
 * position (less than 1 m above or below). A limit that the map does not have is served by the next
 * tighter one. On failure *range is the longest range with
 * SIGHTLINE_FAR, so that who forgets to look at the number still looks far enough. */
int sightline_observation_range(const sightline_map* map, const double position_world_m[3],
                                double limit_m, sightline_range* range);

/* Why a site has its range and its look for a limit: numbers of the rules that decided, 0 where no
 * site's answer is used. Their names: sightline_reason_name. */
typedef struct sightline_reasons {
  uint32_t range;
  uint32_t look;
} sightline_reasons;

/* Why sightline_observation_range and sightline_get_look (visible_m: INFINITY) answer there what
 * they do. On failure both are 0. */
int sightline_get_reasons(const sightline_map* map, const double position_world_m[3],
                          double limit_m, sightline_reasons* reasons);

/* "dilation"; "none" for 0, "unknown" for the number of a rule that this library does not know. */
const char* sightline_reason_name(uint32_t reason);

/* The look for a sensor there that now sees visible_m far (INFINITY: as far as it goes): the map's
 * look where that reaches no farther, else the observation range as a look at every return, else
 * the longest range with SIGHTLINE_NOT_VISIBLE. A map without looks answers with the range. On
 * failure *look is the longest range with SIGHTLINE_FAR. */
int sightline_get_look(const sightline_map* map, const double position_world_m[3], double limit_m,
                       double visible_m, sightline_look* look);

/* What to do there. A vehicle that tracks (is_tracking not 0): the map's plan, where the limit is
 * not tighter than the plan's; its first look is the place's own, settling, where that looks at no
 * more returns and matches fewer points. Where no plan applies: the place's look for tracking
 * starts, if the map has one that reaches no farther than visible_m; its mean_error_m is NaN. In
 * both cases SIGHTLINE_UNMET is about tracking starts then. A vehicle that does not track, or is
 * far from any site: the answer of sightline_get_look alone. On failure the first look is the
 * longest range with SIGHTLINE_FAR. */
int sightline_get_look_plan(const sightline_map* map, const double position_world_m[3],
                            double limit_m, int is_tracking, double visible_m,
                            sightline_look_plan* plan);

/* Fills sites, which has room for site_count, with every site of the map in the order of their
 * numbers, each with what sightline_observation_range answers there for limits_m[limit]. site_count
 * is that of sightline_info. Returns 0, or the number of bad-argument, checksum-mismatch, bad-layer
 * or out-of-memory, and then what is in sites means nothing. For tools: it reads all. */
int sightline_get_sites(const sightline_map* map, size_t limit, sightline_site* sites,
                        size_t site_count);

/* A further figure of every site, as the map names it. Pointers stay valid until sightline_close.
 */
typedef struct sightline_column {
  const char* name;    /* with its unit: "clearance_m" */
  const char* unit;    /* for people: "m" */
  const float* values; /* one a site, by sightline_range.site; infinite where there is none */
  size_t count;        /* site_count of sightline_info */
} sightline_column;

/* How many columns the map has. */
size_t sightline_column_count(const sightline_map* map);

/* Column `index`, below sightline_column_count; names ascend. Checks all of its values: get it once
 * and keep it. Returns 0, or the number of bad-argument, checksum-mismatch, bad-layer or
 * out-of-memory, and then *column has no values, but its name where the map has such a column. */
int sightline_get_column(const sightline_map* map, size_t index, sightline_column* column);

/* Standard deviations of a match about the true pose, in the vehicle's axes there, by a vehicle
 * that tracks; infinite where nothing was measured. */
typedef struct sightline_errors {
  double longitudinal_m;
  double lateral_m;
  double yaw_rad;
  double
      kept_longitudinal; /* share of the start's longitudinal error that the match keeps, 0 to 1 */
} sightline_errors;

/* Those at a site (sightline_range.site): of a match of every return within the longest range where
 * is_sample is 0, else of a look that takes a sample. The first call checks the columns of the map.
 * Returns 0, or the number of checksum-mismatch, bad-layer or out-of-memory; then all are infinite.
 */
int sightline_get_errors(const sightline_map* map, uint32_t site, int is_sample,
                         sightline_errors* errors);

/* Bounds of the errors of a vehicle that tracks, in its axes: forward, left, up; infinite where
 * none is available. */
typedef struct sightline_protection {
  double protection_m[3];
  double protection_yaw_rad;
  uint32_t place_kind;  /* the column of that name at this site; 0: unknown */
  uint32_t block_count; /* of 60 m of generated worlds that calibrated the bounds */
} sightline_protection;

/* Before any match, at a site (sightline_range.site): each bound is exceeded in at most this share
 * of stretches of 60 m of such places ("Protection levels" in schemas/definitions.md). `is_sample`:
 * see sightline_get_errors. The first call checks the columns of the map. Returns 0, or the number
 * of bad-argument (a risk that is not between 0 and 1), checksum-mismatch, bad-layer or
 * out-of-memory; then all are infinite. */
int sightline_get_protection(const sightline_map* map, uint32_t site, double risk, int is_sample,
                             sightline_protection* protection);

/* "0.1.0": of the library that answers. */
const char* sightline_reader_version(void);

/* "checksum-mismatch"; "unknown" for a number that means nothing. */
const char* sightline_error_name(int error);

#ifdef __GNUC__
#pragma GCC visibility pop
#endif
#ifdef __cplusplus
}
#endif

#endif
