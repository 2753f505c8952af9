#include "passes/vehicle/sightline_localizer.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "formats/base/copy_message.h"
#include "formats/base/version.h"
#include "formats/drive/look.h"
#include "passes/matching/covariance/known_start.h"
#include "passes/matching/look_cutter.h"
#include "passes/matching/look_plan.h"
#include "passes/vehicle/c_values.h"
#include "passes/vehicle/localizer_handle.h"
#include "passes/vehicle/map_windows.h"
#include "passes/vehicle/match_answer.h"
#include "passes/vehicle/match_protection.h"
#include "passes/vehicle/vehicle_map.h"

namespace sightline {
namespace {

static_assert(SIGHTLINE_CONVERGED == static_cast<unsigned>(MatchStop::kConverged));
static_assert(SIGHTLINE_ITERATION_LIMIT == static_cast<unsigned>(MatchStop::kIterationLimit));
static_assert(SIGHTLINE_NO_POINTS == static_cast<unsigned>(MatchStop::kNoPoints));
static_assert(SIGHTLINE_NO_OVERLAP == static_cast<unsigned>(MatchStop::kNoOverlap));

constexpr double kMostCells = 0x1.0p29;  // that a start may be away from the map's origin

Look look_of(const sightline_look& look) {
  return {.range_m = look.range_m,
          .return_count = look.return_count,
          .even_beyond_m = look.even_beyond_m,
          .point_count = look.point_count,
          .is_by_normals = look.is_by_normals != 0,
          .mode = look.settles != 0 ? LookMode::kSettle : LookMode::kSearch};
}

LookPlan plan_of(const sightline_look_plan& plan) {
  LookPlan result;
  result.first = look_of(plan.first);
  result.second = look_of(plan.second);
  std::copy_n(plan.weights, kLookSigns, result.test.weights.begin());
  result.test.constant = plan.constant;
  result.doubt_above = plan.doubt_above;
  return result;
}

Result<VehicleMap> open_map(const char* path, const sightline_localizer_options& options) {
  VehicleMapOptions chosen;
  if (options.cell_m != 0.0) chosen.cell_m = options.cell_m;
  if (options.least_points != 0) chosen.min_points = options.least_points;
  if (options.azimuth_step_deg != 0.0) chosen.azimuth_step_deg = options.azimuth_step_deg;
  if (options.T_vehicle_sensor != nullptr) {
    chosen.T_vehicle_sensor = pose_of(options.T_vehicle_sensor);
  }
  chosen.threads = options.threads;
  chosen.is_whole = options.holds_whole_map != 0;
  return read_vehicle_map(path, chosen);
}

bool is_good(const sightline_points& scan) {
  return scan.count < (std::size_t{1} << 31) && (scan.count == 0 || scan.first != nullptr);
}

constexpr int kBadArgument = static_cast<int>(ErrorCode::kBadArgument);

GivenErrors given_errors(const sightline_match_options* o) {
  if (o == nullptr) return {};
  return {o->start_covariance, o->variance_factor, o->map_m, o->map_rad, o->protection_risk};
}

// What is known of the start, if anything is.
std::optional<KnownStart> start_of(const MatchKnowledge& knowledge, const Pose& T_map_start) {
  if (!knowledge.start_covariance) return std::nullopt;
  return KnownStart{T_map_start, *knowledge.start_covariance};
}

// A pose has six degrees of freedom.
bool is_unconstrained(const MatchResult& found, const MatchEnd& end) {
  constexpr std::uint32_t kFewestPoints = 6;
  return found.stop == MatchStop::kConverged &&
         (found.scored_points < kFewestPoints || !end.holds_every_motion);
}

// What the calls share.
struct MatchCall {
  const sightline_localizer& localizer;
  double range_m;  // of the longest look
  const sightline_points& scan;
  const double* T_world_start;
  const sightline_match_options* options;
  sightline_match& answer;
};

// A match, and the scan that was matched, in the workspace.
struct MatchOfScan {
  MatchResult match;
  const ScanForMatch& scan;
};

// Where a match of the workspace's scan begins, and how far it looks for another optimum.
struct MatchBegin {
  Pose T_map_start = Pose::Identity();
  double search_m = std::numeric_limits<double>::infinity();
};

// Checks start and scan and takes the scan's points into a workspace, by which `use` answers.
template <class Use>
int with_scan(const MatchCall& call, const Use& use) {
  const auto& [localizer, range_m, scan, T_world_start, options, answer] = call;
  const MapFrame& frame = localizer.map.ndt.frame;
  const Pose T_world_given = pose_of(T_world_start);
  if (!is_rigid(T_world_given) || !is_good(scan)) return kBadArgument;
  const Pose T_map_start = rebase(T_world_given, MapFrame{}, frame);
  const double away_m = T_map_start.translation().cwiseAbs().maxCoeff();
  if (!(away_m < kMostCells * localizer.map.ndt.cell_m)) return kBadArgument;
  try {
    const std::shared_ptr<const MapWindow> window =
        localizer.windows->at(T_map_start.translation(), range_m);
    std::unique_ptr<Workspace> workspace = localizer.take_workspace(*window);
    std::vector<Eigen::Vector3d>& points_m = workspace->scan.points_m;
    take_returns({scan.first, scan.count, scan.stride_bytes, scan.is_double != 0}, points_m);
    answer.dropped_count = static_cast<std::uint32_t>(scan.count - points_m.size());
    const int code = use(*window, *workspace, T_map_start);
    localizer.give_back(std::move(workspace));
    return code;
  } catch (const std::bad_alloc&) {
    put_start(T_world_start, answer);
    return static_cast<int>(ErrorCode::kOutOfMemory);
  }
}

// Checks the options and fills the answer. `use` matches the workspace's scan.
template <class Use>
int match_scan(const MatchCall& call, const Use& use) {
  return with_scan(
      call, [&](const MapWindow& window, Workspace& workspace, const Pose& T_map_start) {
        sightline_match& answer = call.answer;
        const std::optional<MatchKnowledge> knowledge =
            knowledge_of(given_errors(call.options), kind_at(call.localizer.map, T_map_start));
        if (!knowledge) {
          put_start(call.T_world_start, answer);
          return kBadArgument;
        }
        const std::optional<KnownStart> start = start_of(*knowledge, T_map_start);
        MatchBegin begin{.T_map_start = T_map_start};
        if (start) begin.search_m = search_of_start_m(start->covariance);
        const MatchOfScan found = use(window, workspace, begin, answer);
        answer.point_count = static_cast<std::uint32_t>(found.scan.points_m.size());
        put(found.match, answer);
        const MatchEnd end = end_of_match(found.match, found.scan, start ? &*start : nullptr,
                                          window.structures, knowledge->scale, workspace.observer);
        put(end, call.localizer.map.ndt.frame, answer);
        if (is_unconstrained(found.match, end)) answer.stop = SIGHTLINE_UNCONSTRAINED;
        put_protection(*knowledge, found.match, end, answer);
        if (!call.localizer.map.is_small) put(end.raised, answer);
        return 0;
      });
}

}  // namespace
}  // namespace sightline

using namespace sightline;

extern "C" {

int sightline_localizer_open(const char* path, const sightline_localizer_options* options,
                             sightline_localizer** localizer, char* message,
                             std::size_t message_size) {
  copy_message("", message, message_size);
  if (localizer != nullptr) *localizer = nullptr;
  if (localizer == nullptr || path == nullptr) {
    copy_message("no path, or no place for the localizer (NULL)", message, message_size);
    return kBadArgument;
  }
  try {
    Result<VehicleMap> map =
        open_map(path, options == nullptr ? sightline_localizer_options{} : *options);
    if (map) {
      auto opened = std::make_unique<sightline_localizer>(*std::move(map));
      if (options == nullptr || options->has_no_thread == 0) opened->windows->start_thread();
      *localizer = opened.release();
      return 0;
    }
    copy_message(to_string(map.error()), message, message_size);
    return static_cast<int>(map.error().code);
  } catch (const std::bad_alloc&) {
    copy_message("out of memory", message, message_size);
    return static_cast<int>(ErrorCode::kOutOfMemory);
  }
}

void sightline_localizer_close(sightline_localizer* localizer) { delete localizer; }

void sightline_localizer_get_info(const sightline_localizer* localizer,
                                  sightline_localizer_info* info) {
  if (info == nullptr) return;
  *info = {};
  info->localizer = info->kernel = "";
  if (localizer == nullptr) return;
  const VehicleMap& map = localizer->map;
  Eigen::Map<Eigen::Vector3d>(info->origin_world_m) = map.ndt.frame.origin_world_m;
  info->cell_m = map.ndt.cell_m;
  put_pose(map.sensor.T_vehicle_lidar, info->T_vehicle_sensor);
  info->leaf_m = map.leaf_m;
  info->localizer = map.localizer.c_str();
  info->kernel = localizer->kernel.c_str();
  info->nds = localizer->nds.data();
  info->nd_count = localizer->nds.size();
}

int sightline_localizer_match(const sightline_localizer* localizer, const sightline_points* scan,
                              const double T_world_start[12], const sightline_look* look,
                              const sightline_match_options* options, sightline_match* match) {
  if (match == nullptr) return kBadArgument;
  put_start(T_world_start, *match);
  if (localizer == nullptr || scan == nullptr || T_world_start == nullptr || look == nullptr) {
    return kBadArgument;
  }
  const Look chosen = look_of(*look);
  if (!validate(chosen)) return kBadArgument;
  return match_scan({*localizer, chosen.range_m, *scan, T_world_start, options, *match},
                    [&](const MapWindow& /*window*/, Workspace& workspace, const MatchBegin& begin,
                        sightline_match& answer) -> MatchOfScan {
                      workspace.matcher.take(workspace.scan, chosen);
                      answer.look_count = 1;
                      const MatchResult found =
                          workspace.matcher.match(begin.T_map_start, begin.search_m);
                      return {found, workspace.matcher.scan()};
                    });
}

int sightline_localizer_match_plan(const sightline_localizer* localizer,
                                   const sightline_points* scan, const double T_world_start[12],
                                   const sightline_look_plan* plan,
                                   const sightline_match_options* options, sightline_match* match) {
  if (plan == nullptr || plan->has_second == 0) {
    return sightline_localizer_match(localizer, scan, T_world_start,
                                     plan == nullptr ? nullptr : &plan->first, options, match);
  }
  if (match == nullptr) return kBadArgument;
  put_start(T_world_start, *match);
  if (localizer == nullptr || scan == nullptr || T_world_start == nullptr) return kBadArgument;
  const LookPlan chosen = plan_of(*plan);
  if (!validate(chosen)) return kBadArgument;
  const double range_m = std::max(chosen.first.range_m, chosen.second.range_m);
  return match_scan({*localizer, range_m, *scan, T_world_start, options, *match},
                    [&](const MapWindow& window, Workspace& workspace, const MatchBegin& begin,
                        sightline_match& answer) -> MatchOfScan {
                      PlannedLocalizer planned{window.samples, localizer->map.sensor, chosen};
                      planned.options.search_m = begin.search_m;
                      const PlannedMatch found = localize_in_looks(
                          planned, workspace.scan, {begin.T_map_start, true}, workspace.planned);
                      answer.look_count = found.look_count;
                      return {found.match, workspace.planned.cut};
                    });
}

int sightline_localizer_score(const sightline_localizer* localizer, const sightline_points* scan,
                              const double T_world_vehicle[12], const sightline_look* look,
                              sightline_match* match) {
  if (match == nullptr) return kBadArgument;
  put_start(T_world_vehicle, *match);
  if (localizer == nullptr || scan == nullptr || T_world_vehicle == nullptr || look == nullptr) {
    return kBadArgument;
  }
  const Look chosen = look_of(*look);
  if (!validate(chosen)) return kBadArgument;
  return with_scan({*localizer, chosen.range_m, *scan, T_world_vehicle, nullptr, *match},
                   [&](const MapWindow& /*window*/, Workspace& workspace, const Pose& T_map) {
                     workspace.matcher.take(workspace.scan, chosen);
                     const MatchResult found = workspace.matcher.score(T_map);
                     match->point_count =
                         static_cast<std::uint32_t>(workspace.matcher.point_count());
                     match->score = found.score;
                     match->nearest_voxel_likelihood = found.nearest_voxel_likelihood;
                     match->scored_points = found.scored_points;
                     match->stop = static_cast<std::uint32_t>(
                         found.scored_points > 0 ? MatchStop::kConverged : found.stop);
                     return 0;
                   });
}

int sightline_localizer_prepare(const sightline_localizer* localizer,
                                const double position_world_m[3], double budget_ms, int* is_done) {
  if (is_done != nullptr) *is_done = 0;
  if (localizer == nullptr || position_world_m == nullptr) return kBadArgument;
  const NdtMap& ndt = localizer->map.ndt;
  const Eigen::Vector3d p_map_m =
      Eigen::Map<const Eigen::Vector3d>(position_world_m) - ndt.frame.origin_world_m;
  if (!(p_map_m.cwiseAbs().maxCoeff() < kMostCells * ndt.cell_m)) return kBadArgument;
  try {
    const bool is_all = localizer->windows->prepare(p_map_m, budget_ms);
    if (is_done != nullptr) *is_done = is_all ? 1 : 0;
    return 0;
  } catch (const std::bad_alloc&) {
    return static_cast<int>(ErrorCode::kOutOfMemory);
  }
}

size_t sightline_localizer_fault_count(const sightline_localizer* localizer) {
  return localizer == nullptr ? 0 : localizer->windows->fault_count();
}

int sightline_localizer_get_fault(const sightline_localizer* localizer, std::size_t number,
                                  char* message, std::size_t message_size) {
  copy_message("", message, message_size);
  if (localizer == nullptr) return kBadArgument;
  if (number >= localizer->windows->fault_count()) return kBadArgument;
  try {
    const Error fault = localizer->windows->fault(number);
    copy_message(to_string(fault), message, message_size);
    return static_cast<int>(fault.code);
  } catch (const std::bad_alloc&) {
    return static_cast<int>(ErrorCode::kOutOfMemory);
  }
}

const char* sightline_localizer_version(void) {
  static const std::string kVersion = program_version();
  return kVersion.c_str();
}

}  // extern "C"
