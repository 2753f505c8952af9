#include "formats/reader/sightline_reader.h"

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/copy_message.h"
#include "formats/base/version.h"
#include "formats/reader/reader.h"
#include "formats/reader/site_protection.h"

using sightline::copy_message;
using sightline::ErrorCode;
using sightline::LookAnswer;
using sightline::LookPlanAnswer;
using sightline::MapColumn;
using sightline::MapErrors;
using sightline::MapInfo;
using sightline::MapPromise;
using sightline::MapProtection;
using sightline::MapReader;
using sightline::MapSite;
using sightline::PoseErrors;
using sightline::RangeAnswer;
using sightline::Result;
using sightline::SiteProtection;

// What callers have got so far, which lasts as long as the map.
struct KeptOfMap {
  std::mutex mutex;
  std::map<size_t, std::shared_ptr<const std::vector<float>>> columns;  // by their number
  std::optional<MapErrors> errors;
  std::optional<MapProtection> protection;
};

struct sightline_map {
  MapReader reader;
  std::string parameters;  // ends in a zero
  mutable KeptOfMap kept = {};
};

namespace {

static_assert(SIGHTLINE_UNMET == sightline::kAnswerUnmet);
static_assert(SIGHTLINE_EXTRAPOLATED == sightline::kAnswerExtrapolated);
static_assert(SIGHTLINE_FAR == sightline::kAnswerFar);
static_assert(SIGHTLINE_TIGHTER_LIMIT == sightline::kAnswerTighterLimit);
static_assert(SIGHTLINE_STATIC == sightline::kAnswerStatic);
static_assert(SIGHTLINE_UNKNOWN_LOCALIZER == sightline::kAnswerUnknownLocalizer);
static_assert(SIGHTLINE_NOT_VISIBLE == sightline::kAnswerNotVisible);
static_assert(SIGHTLINE_NO_SITE == sightline::kNoSite);

constexpr int kBadArgument = static_cast<int>(ErrorCode::kBadArgument);

// Without a map its longest range is not known: infinity.
RangeAnswer default_answer(const sightline_map* map) {
  RangeAnswer answer;
  answer.range_m =
      map == nullptr ? std::numeric_limits<double>::infinity() : map->reader.info().ranges_m.back();
  answer.mean_error_m = std::numeric_limits<double>::infinity();
  answer.flags = sightline::kAnswerFar;
  return answer;
}

LookAnswer default_look(const sightline_map* map) {
  const RangeAnswer otherwise = default_answer(map);
  LookAnswer answer;
  answer.look.range_m = otherwise.range_m;
  answer.mean_error_m = otherwise.mean_error_m;
  answer.flags = otherwise.flags;
  return answer;
}

Result<std::array<double, 3>> position_of(const sightline_map* map,
                                          const double position_world_m[3]) {
  if (map == nullptr || position_world_m == nullptr) {
    return sightline::Error{ErrorCode::kBadArgument, {}};
  }
  return std::array{position_world_m[0], position_world_m[1], position_world_m[2]};
}

sightline_look c_look(const LookAnswer& answer) {
  return {answer.look.range_m,
          answer.look.return_count,
          answer.look.even_beyond_m,
          answer.look.point_count,
          answer.look.is_by_normals ? 1 : 0,
          answer.look.settles ? 1 : 0,
          answer.probability,
          answer.mean_error_m,
          answer.distance_m,
          answer.flags,
          answer.site};
}

// MapReader::open or MapReader::open_in_memory.
using Opener = Result<MapReader> (*)(const std::string&, std::string_view);

int open_by(Opener opener, const char* path, const char* localizer, sightline_map** map,
            char* message, size_t message_size) {
  copy_message("", message, message_size);
  if (map != nullptr) *map = nullptr;
  if (map == nullptr || path == nullptr) {
    copy_message("no path, or no place for the map (NULL)", message, message_size);
    return kBadArgument;
  }
  try {
    Result<MapReader> reader = opener(path, localizer == nullptr ? "" : localizer);
    if (reader) {
      const std::string parameters(reader->info().localizer_parameters);
      *map = new sightline_map{std::move(*reader), parameters};
      return 0;
    }
    copy_message(to_string(reader.error()), message, message_size);
    return static_cast<int>(reader.error().code);
  } catch (const std::bad_alloc&) {
    copy_message("out of memory", message, message_size);
    return static_cast<int>(ErrorCode::kOutOfMemory);
  }
}

}  // namespace

extern "C" {

int sightline_open(const char* path, const char* localizer, sightline_map** map, char* message,
                   size_t message_size) {
  return open_by(&MapReader::open, path, localizer, map, message, message_size);
}

int sightline_open_in_memory(const char* path, const char* localizer, sightline_map** map,
                             char* message, size_t message_size) {
  return open_by(&MapReader::open_in_memory, path, localizer, map, message, message_size);
}

void sightline_close(sightline_map* map) { delete map; }

void sightline_get_info(const sightline_map* map, sightline_info* info) {
  if (info == nullptr) return;
  *info = {};
  if (map == nullptr) {
    info->map_id = info->version = info->localizer = info->localizer_parameters = info->world = "";
    return;
  }
  const MapInfo& from = map->reader.info();
  info->map_id = from.map_id.data();  // FlatBuffers ends its strings with a zero
  info->version = from.version.data();
  info->release = from.release;
  std::copy(from.origin_world_m.begin(), from.origin_world_m.end(), info->origin_world_m);
  info->reach_m = from.reach_m;
  info->ranges_m = from.ranges_m.data();
  info->limits_m = from.limits_m.data();
  info->range_count = from.ranges_m.size();
  info->limit_count = from.limits_m.size();
  info->site_count = from.site_count;
  info->localizer = from.localizer.data();
  info->localizer_version = from.localizer_version;
  info->localizer_parameters = map->parameters.c_str();
  info->is_for_caller = from.is_for_caller ? 1 : 0;
  info->world = from.world.data();
  std::copy(from.export_origin_world_m.begin(), from.export_origin_world_m.end(),
            info->export_origin_world_m);
}

int sightline_get_promise(const sightline_map* map, size_t limit, sightline_promise* promise) {
  if (promise == nullptr) return kBadArgument;
  *promise = {0.0, 0.0, 0, 0, 0, 0, ""};
  if (map == nullptr) return kBadArgument;
  const std::span<const MapPromise> promises = map->reader.info().promises;
  if (limit >= promises.size()) return kBadArgument;
  const MapPromise& from = promises[limit];
  *promise = {
      from.limit_m,     from.coverage,    from.is_earned ? 1 : 0, from.is_of_next_drive ? 1 : 0,
      from.place_count, from.drive_count, from.statement.data()};
  return 0;
}

int sightline_observation_range(const sightline_map* map, const double position_world_m[3],
                                double limit_m, sightline_range* range) {
  if (range == nullptr) return kBadArgument;
  const Result<std::array<double, 3>> p_m = position_of(map, position_world_m);
  const Result<RangeAnswer> found =
      p_m ? map->reader.observation_range(*p_m, limit_m) : Result<RangeAnswer>(p_m.error());
  const RangeAnswer answer = found ? *found : default_answer(map);
  *range = {answer.range_m,    answer.probability, answer.mean_error_m,
            answer.distance_m, answer.flags,       answer.site};
  return found ? 0 : static_cast<int>(found.error().code);
}

int sightline_get_reasons(const sightline_map* map, const double position_world_m[3],
                          double limit_m, sightline_reasons* reasons) {
  if (reasons == nullptr) return kBadArgument;
  *reasons = {};
  const Result<std::array<double, 3>> p_m = position_of(map, position_world_m);
  if (!p_m) return kBadArgument;
  const Result<RangeAnswer> range = map->reader.observation_range(*p_m, limit_m);
  if (!range) return static_cast<int>(range.error().code);
  const Result<LookAnswer> look = map->reader.look(*p_m, limit_m);
  if (!look) return static_cast<int>(look.error().code);
  *reasons = {static_cast<uint32_t>(range->reason), static_cast<uint32_t>(look->reason)};
  return 0;
}

const char* sightline_reason_name(uint32_t reason) {
  // Names are literals, so they end in a zero.
  const auto& names = sightline::kNamesOf<sightline::Reason>;
  return reason < names.size() ? names[reason].data() : "unknown";
}

int sightline_get_look(const sightline_map* map, const double position_world_m[3], double limit_m,
                       double visible_m, sightline_look* look) {
  if (look == nullptr) return kBadArgument;
  const Result<std::array<double, 3>> p_m = position_of(map, position_world_m);
  const Result<LookAnswer> found =
      p_m ? map->reader.look(*p_m, limit_m, visible_m) : Result<LookAnswer>(p_m.error());
  *look = c_look(found ? *found : default_look(map));
  return found ? 0 : static_cast<int>(found.error().code);
}

int sightline_get_look_plan(const sightline_map* map, const double position_world_m[3],
                            double limit_m, int is_tracking, double visible_m,
                            sightline_look_plan* plan) {
  if (plan == nullptr) return kBadArgument;
  const Result<std::array<double, 3>> p_m = position_of(map, position_world_m);
  const Result<LookPlanAnswer> found =
      p_m ? map->reader.look_plan(*p_m, limit_m, is_tracking != 0, visible_m)
          : Result<LookPlanAnswer>(p_m.error());
  LookPlanAnswer answer;
  answer.first = default_look(map);
  if (found) answer = *found;
  *plan = {};
  plan->first = c_look(answer.first);
  if (answer.has_second) {
    plan->has_second = 1;
    std::copy(answer.weights.begin(), answer.weights.end(), plan->weights);
    plan->constant = answer.constant;
    plan->doubt_above = answer.doubt_above;
    LookAnswer second = answer.first;  // whose place and flags it shares
    second.look = answer.second;
    plan->second = c_look(second);
  }
  return found ? 0 : static_cast<int>(found.error().code);
}

int sightline_get_sites(const sightline_map* map, size_t limit, sightline_site* sites,
                        size_t site_count) {
  if (map == nullptr || (sites == nullptr && site_count != 0)) return kBadArgument;
  try {
    if (site_count != map->reader.info().site_count) return kBadArgument;
    const Result<std::vector<MapSite>> found = map->reader.sites(limit);
    if (!found) return static_cast<int>(found.error().code);
    std::ranges::transform(*found, sites, [](const MapSite& site) -> sightline_site {
      const auto& [x_m, y_m, z_m] = site.position_world_m;
      return {{x_m, y_m, z_m},         site.range.range_m, site.range.probability,
              site.range.mean_error_m, site.range.flags,   site.range.site};
    });
    return 0;
  } catch (const std::bad_alloc&) {
    return static_cast<int>(ErrorCode::kOutOfMemory);
  }
}

size_t sightline_column_count(const sightline_map* map) {
  return map == nullptr ? 0 : map->reader.info().columns.size();
}

int sightline_get_column(const sightline_map* map, size_t index, sightline_column* column) {
  if (column == nullptr) return kBadArgument;
  *column = {"", "", nullptr, 0};
  if (map == nullptr) return kBadArgument;
  try {
    const std::span<const std::string_view> names = map->reader.info().columns;
    if (index >= names.size()) return kBadArgument;
    column->name = names[index].data();
    const Result<MapColumn> found = map->reader.column(names[index]);
    if (!found) return static_cast<int>(found.error().code);
    std::span<const float> values = found->values;
    if (found->decoded) {
      const std::scoped_lock lock(map->kept.mutex);
      values = *map->kept.columns.try_emplace(index, found->decoded).first->second;
    }
    *column = {found->name.data(), found->unit.data(), values.data(), values.size()};
    return 0;
  } catch (const std::bad_alloc&) {
    return static_cast<int>(ErrorCode::kOutOfMemory);
  }
}

int sightline_get_errors(const sightline_map* map, uint32_t site, int is_sample,
                         sightline_errors* errors) {
  if (errors == nullptr) return kBadArgument;
  const auto set = [&](const PoseErrors& from) {
    *errors = {from.longitudinal_m, from.lateral_m, from.yaw_rad, from.kept_longitudinal};
  };
  set({});
  if (map == nullptr) return kBadArgument;
  try {
    const std::scoped_lock lock(map->kept.mutex);
    if (!map->kept.errors) {
      Result<MapErrors> found = map->reader.errors();
      if (!found) return static_cast<int>(found.error().code);
      map->kept.errors = *found;
    }
    set(is_sample != 0 ? map->kept.errors->of_sample(site) : map->kept.errors->of_range(site));
    return 0;
  } catch (const std::bad_alloc&) {
    return static_cast<int>(ErrorCode::kOutOfMemory);
  }
}

int sightline_get_protection(const sightline_map* map, uint32_t site, double risk, int is_sample,
                             sightline_protection* protection) {
  if (protection == nullptr) return kBadArgument;
  const auto set = [&](const SiteProtection& from) {
    const auto& [forward_m, left_m, up_m, yaw_rad] = from.levels;
    *protection = {{forward_m, left_m, up_m}, yaw_rad, from.place_kind, from.block_count};
  };
  set({});
  if (map == nullptr || !(risk > 0.0 && risk < 1.0)) return kBadArgument;
  try {
    const std::scoped_lock lock(map->kept.mutex);
    if (!map->kept.protection) {
      Result<MapProtection> found = sightline::protection_of(map->reader);
      if (!found) return static_cast<int>(found.error().code);
      map->kept.protection = *found;
    }
    set(map->kept.protection->at(site, risk, is_sample != 0));
    return 0;
  } catch (const std::bad_alloc&) {
    return static_cast<int>(ErrorCode::kOutOfMemory);
  }
}

const char* sightline_reader_version(void) {
  static const std::string kVersion = sightline::program_version();
  return kVersion.c_str();
}

const char* sightline_error_name(int error) {
  return sightline::error_name(static_cast<ErrorCode>(error)).data();
}

}  // extern "C"
