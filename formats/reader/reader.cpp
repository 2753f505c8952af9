#include "formats/reader/reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "formats/reader/map_checks.h"
#include "map_generated.h"

namespace sightline {
namespace {

template <class T>
T load(const std::byte* column, std::uint64_t i) {
  T value;
  std::memcpy(&value, column + i * sizeof(T), sizeof value);
  return value;
}

bool is_finite(const std::array<double, 3>& values) {
  return std::isfinite(values[0]) && std::isfinite(values[1]) && std::isfinite(values[2]);
}

Error unknown_range(std::uint32_t site) {
  return {ErrorCode::kBadLayer, "a site has a range that the map does not have", "",
          "site " + std::to_string(site)};
}

// Numbers of the file are used only where they can be true.
Result<RangeAnswer> believable(const RangeAnswer& answer, std::uint32_t site_count) {
  const bool is_unknown = (answer.flags & kAnswerUnknownLocalizer) != 0;
  const bool can_be =
      answer.probability >= 0.0 && answer.probability <= 1.0 && answer.mean_error_m >= 0.0;
  if (answer.site < site_count && (is_unknown || can_be)) return answer;
  return Error{ErrorCode::kBadLayer, "a site's number, probability or error is out of range", "",
               "site " + std::to_string(answer.site)};
}

std::vector<char> parameters_text(const schema::LocalizerProfile& profile) {
  std::string text;
  for (const schema::Fact* fact : *profile.parameters()) {
    text += (text.empty() ? "" : ", ") + fact->name()->str() + "=" + fact->value()->str();
  }
  return {text.begin(), text.end()};
}

// "searching", or "searching/3" where the version of its definition is to be that one.
bool is_callers(const schema::LocalizerProfile& profile, std::string_view callers_localizer) {
  const std::size_t slash = callers_localizer.find('/');
  const std::string_view name = callers_localizer.substr(0, slash);
  if (name.empty() || name != profile.name()->string_view()) return false;
  if (slash == std::string_view::npos) return true;
  return callers_localizer.substr(slash + 1) == std::to_string(profile.version());
}

MapPromise promise_of(const schema::Promise& from) {
  const bool is_of_next_drive = from.scope() == schema::Scope::NextDrive;
  const bool is_earned = from.is_earned() && is_of_next_drive;
  return {from.limit_m(),
          is_earned,
          is_earned ? 1.0 - from.alpha() : 0.0,
          is_of_next_drive,
          from.place_count(),
          from.drive_count(),
          from.statement()->string_view()};
}

MapLook look_of(const schema::Look& from) {
  return {from.range_m(),     from.return_count(),  from.even_beyond_m(),
          from.point_count(), from.is_by_normals(), from.mode() == schema::LookMode::Settle};
}

LookPlanAnswer plan_of(const schema::LookPlan& from) {
  LookPlanAnswer plan;
  plan.first.look = look_of(*from.first());
  plan.has_second = true;
  std::ranges::copy(*from.weights(), plan.weights.begin());
  plan.constant = from.constant();
  plan.doubt_above = from.doubt_above();
  plan.second = look_of(*from.second());
  return plan;
}

LookAnswer look_answer(const MapLook& look, const RangeAnswer& numbers) {
  return {look,          numbers.probability, numbers.mean_error_m, numbers.distance_m,
          numbers.flags, numbers.site,        numbers.reason};
}

}  // namespace

MapReader::MapReader(MappedFile file, const MapFront& front, LookUp look_up,
                     std::string_view callers_localizer)
    : file_(std::move(file)), front_(front), look_up_(std::move(look_up)) {
  const schema::Manifest& manifest = *front.manifest;
  ranges_m_.assign(manifest.ranges_m()->begin(), manifest.ranges_m()->end());
  for (const schema::Promise* promise : *manifest.promises()) {
    limits_m_.push_back(promise->limit_m());
    promises_.push_back(promise_of(*promise));
  }
  if (answer_shape(manifest).looks > 0) {
    for (const schema::Look* look : *manifest.looks()) looks_.push_back(look_of(*look));
    for (const schema::Promise* promise : *manifest.look_promises()) {
      look_promises_.push_back(promise_of(*promise));
    }
  }
  if (manifest.look_plan() != nullptr) {
    plan_ = plan_of(*manifest.look_plan());
    plan_limit_m_ = manifest.look_plan()->limit_m();
  }
  if (manifest.columns() != nullptr) {
    for (const schema::SiteColumn* column : *manifest.columns()) {
      columns_.push_back(column->name()->string_view());
    }
  }
  const schema::Vector3& origin_m = *manifest.origin_world_m();
  info_.map_id = manifest.map_id()->string_view();
  info_.version = manifest.version()->string_view();
  info_.release = manifest.release();
  info_.origin_world_m = {origin_m.x(), origin_m.y(), origin_m.z()};
  info_.world = manifest.world() == nullptr ? kLocalWorld : manifest.world()->string_view();
  info_.export_origin_world_m = sightline::export_origin_world_m(info_.origin_world_m);
  info_.tile_m = manifest.tile_m();
  info_.reach_m = manifest.reach_m();
  info_.site_count = manifest.site_count();
  info_.simulated_site_count = manifest.simulated_site_count();
  info_.ranges_m = ranges_m_;
  info_.limits_m = limits_m_;
  info_.promises = promises_;
  info_.looks = looks_;
  info_.look_promises = look_promises_;
  info_.columns = columns_;
  const schema::LocalizerProfile& localizer = *manifest.model()->localizer();
  parameters_ = parameters_text(localizer);
  info_.localizer = localizer.name()->string_view();
  info_.localizer_version = localizer.version();
  info_.localizer_parameters = {parameters_.data(), parameters_.size()};
  info_.is_for_caller = is_callers(localizer, callers_localizer);
}

Result<MapReader> MapReader::open(MappedFile file, std::span<const std::byte> bytes,
                                  std::string_view callers_localizer) {
  SIGHTLINE_ASSIGN(const MapFront front, open_front(bytes));
  SIGHTLINE_ASSIGN(LookUp look_up, LookUp::open(front));
  return MapReader(std::move(file), front, std::move(look_up), callers_localizer);
}

Result<MapReader> MapReader::open(std::span<const std::byte> bytes,
                                  std::string_view callers_localizer) {
  return open(MappedFile(), bytes, callers_localizer);
}

Result<MapReader> MapReader::open(const std::string& path, std::string_view callers_localizer) {
  return open_file(path, MappedFile::Use::kHereAndThere, callers_localizer);
}

Result<MapReader> MapReader::open_in_memory(const std::string& path,
                                            std::string_view callers_localizer) {
  return open_file(path, MappedFile::Use::kCopied, callers_localizer);
}

Result<MapReader> MapReader::open_file(const std::string& path, MappedFile::Use use,
                                       std::string_view callers_localizer) {
  SIGHTLINE_ASSIGN(MappedFile file, MappedFile::open(path, use));
  const std::span<const std::byte> bytes = file.bytes();
  Result<MapReader> reader = open(std::move(file), bytes, callers_localizer);
  if (reader) return reader;
  Error error = reader.error();
  error.file = path;
  return error;
}

// Which of the map's limits serves the one asked for; none where that is tighter than all.
std::optional<std::size_t> MapReader::limit_for(double limit_m) const {
  const auto above = std::upper_bound(limits_m_.begin(), limits_m_.end(), limit_m);
  if (above == limits_m_.begin()) return std::nullopt;
  return static_cast<std::size_t>(above - limits_m_.begin()) - 1;
}

// What a map says where no range can be read from it: look as far as it goes, expect nothing.
RangeAnswer MapReader::default_answer(std::uint32_t flags) const {
  RangeAnswer answer;
  answer.range_m = ranges_m_.back();
  answer.mean_error_m = std::numeric_limits<double>::infinity();
  answer.flags = flags;
  if (info_.is_for_caller) return answer;
  answer.probability = std::numeric_limits<double>::quiet_NaN();
  answer.mean_error_m = answer.probability;
  answer.flags |= kAnswerUnknownLocalizer;
  return answer;
}

Result<RangeAnswer> MapReader::range_of(const Found& found) const {
  const LookUp::Nearest& nearest = found.nearest;
  RangeAnswer answer = default_answer(found.limit ? 0 : kAnswerTighterLimit);
  if (nearest.row == nullptr) {
    answer.flags |= kAnswerFar;
    return answer;
  }
  const LookUpRowLayout& layout = look_up_.row_layout();
  answer.site = nearest.site;
  answer.distance_m = std::sqrt(nearest.distance2_m2);
  if (!info_.is_for_caller) return believable(answer, info_.site_count);
  if (!found.limit) {
    answer.mean_error_m = layout.length_m(nearest.row, layout.longest_error, 0);
    return believable(answer, info_.site_count);
  }
  const auto range = load<std::uint8_t>(nearest.row + layout.range_index, *found.limit);
  if (range >= ranges_m_.size()) return unknown_range(nearest.site);
  answer.range_m = ranges_m_[range];
  answer.flags |= load<std::uint8_t>(nearest.row + layout.range_flags, *found.limit);
  answer.reason = load<Reason>(nearest.row + layout.range_reason, *found.limit);
  answer.probability = layout.share(nearest.row, layout.probability, *found.limit);
  answer.mean_error_m = layout.length_m(nearest.row, layout.mean_error, *found.limit);
  return believable(answer, info_.site_count);
}

Result<MapReader::Found> MapReader::find(const std::array<double, 3>& position_world_m,
                                         double limit_m) const {
  if (!is_finite(position_world_m) || !std::isfinite(limit_m) || limit_m <= 0.0) {
    return Error{ErrorCode::kBadArgument,
                 "a position must be finite, and a limit finite and above 0"};
  }
  std::array<double, 3> p_m{};
  for (std::size_t i = 0; i < 3; ++i) p_m[i] = position_world_m[i] - info_.origin_world_m[i];
  const Found found{look_up_.nearest(p_m), limit_for(limit_m)};
  if (found.nearest.is_damaged) return look_up_.damage(found.nearest);
  return found;
}

Result<RangeAnswer> MapReader::observation_range(const std::array<double, 3>& position_world_m,
                                                 double limit_m) const {
  SIGHTLINE_ASSIGN(const Found found, find(position_world_m, limit_m));
  return range_of(found);
}

Result<std::vector<MapSite>> MapReader::sites(std::size_t limit) const {
  if (limit >= limits_m_.size()) {
    return Error{ErrorCode::kBadArgument, concat("the map has ", limits_m_.size(), " limits")};
  }
  std::vector<MapSite> sites(info_.site_count);
  for (std::uint64_t number = 0; number < look_up_.row_count(); ++number) {
    const Found found{look_up_.row(number), limit};
    if (found.nearest.is_damaged) return look_up_.damage(found.nearest);
    SIGHTLINE_ASSIGN(const RangeAnswer range, range_of(found));
    MapSite& site = sites[range.site];
    if (site.range.site != kNoSite) {
      return Error{ErrorCode::kBadLayer, "two rows have the same site", "",
                   concat("site ", range.site)};
    }
    site.range = range;
    for (std::size_t i = 0; i < 3; ++i) {
      site.position_world_m[i] =
          look_up_.row_layout().place_m(found.nearest.row, i) + info_.origin_world_m[i];
    }
  }
  return sites;
}

Result<std::span<const std::byte>> MapReader::column_bytes(std::size_t number) const {
  const schema::SiteColumn& column =
      *front_.manifest->columns()->Get(static_cast<flatbuffers::uoffset_t>(number));
  const bool has_steps = column.steps() != nullptr;
  SIGHTLINE_ASSIGN(const MapContainer container, open_directory(front_));
  const std::string section = std::string(kColumnSection) + std::string(columns_[number]);
  const schema::Block* block = find_section(container, section);
  const std::uint64_t size = std::uint64_t{info_.site_count} * (has_steps ? 1 : sizeof(float));
  if (block == nullptr || block->version() != column_version(has_steps) ||
      block->codec() != schema::Codec::None || block->raw_size() != size) {
    return Error{ErrorCode::kBadLayer, "the section with one number for each site is missing", "",
                 "section " + section};
  }
  return stored_bytes(container, *block);
}

Result<MapColumn> MapReader::column(std::string_view name) const {
  const auto found = std::ranges::find(columns_, name);
  if (found == columns_.end()) {
    return Error{ErrorCode::kBadArgument, "the map has no column " + std::string(name), "", ""};
  }
  const auto number = static_cast<std::size_t>(found - columns_.begin());
  const schema::SiteColumn& column =
      *front_.manifest->columns()->Get(static_cast<flatbuffers::uoffset_t>(number));
  SIGHTLINE_ASSIGN(const std::span<const std::byte> bytes, column_bytes(number));
  const std::string_view unit = column.unit()->string_view();
  if (column.steps() == nullptr) {
    return MapColumn{
        *found, unit, {reinterpret_cast<const float*>(bytes.data()), info_.site_count}};
  }
  auto values = std::make_shared<std::vector<float>>();
  for (const std::byte step : bytes) {
    const auto number_of_step = static_cast<flatbuffers::uoffset_t>(step);
    if (number_of_step >= column.steps()->size()) {
      return Error{ErrorCode::kBadLayer, "a site has a step that is not listed", "",
                   concat("section ", kColumnSection, name)};
    }
    values->push_back(column.steps()->Get(number_of_step));
  }
  return MapColumn{*found, unit, *values, values};
}

Result<MapErrors::Column> MapReader::stepped_column(std::string_view name) const {
  const auto found = std::ranges::find(columns_, name);
  if (found == columns_.end()) return MapErrors::Column{};
  const auto number = static_cast<std::size_t>(found - columns_.begin());
  const flatbuffers::Vector<float>* steps =
      front_.manifest->columns()->Get(static_cast<flatbuffers::uoffset_t>(number))->steps();
  if (steps == nullptr) return MapErrors::Column{};
  SIGHTLINE_ASSIGN(const std::span<const std::byte> bytes, column_bytes(number));
  return MapErrors::Column{{reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()},
                           {steps->data(), steps->size()}};
}

Result<MapErrors> MapReader::errors() const {
  MapErrors errors;
  for (std::size_t i = 0; i < errors.ranges.size(); ++i) {
    SIGHTLINE_ASSIGN(errors.ranges[i], stepped_column(kTrackingRangeColumns[i]));
    SIGHTLINE_ASSIGN(errors.samples[i], stepped_column(kTrackingSampleColumns[i]));
  }
  return errors;
}

Result<MapPoses> MapReader::poses() const {
  constexpr std::string_view kDirections = "unconstrained";
  constexpr std::string_view kSigma = "pose_sigma_m";
  if (std::ranges::find(columns_, kDirections) == columns_.end()) return MapPoses{};
  SIGHTLINE_ASSIGN(const MapColumn directions, column(kDirections));
  SIGHTLINE_ASSIGN(const MapColumn sigmas, column(kSigma));
  return MapPoses{directions.values, sigmas.values};
}

Result<LookAnswer> MapReader::look(const std::array<double, 3>& position_world_m, double limit_m,
                                   double visible_m) const {
  if (!(visible_m > 0.0)) {
    return Error{ErrorCode::kBadArgument, "the visible distance must be above 0 m"};
  }
  SIGHTLINE_ASSIGN(const Found found, find(position_world_m, limit_m));
  SIGHTLINE_ASSIGN(RangeAnswer range, range_of(found));
  const std::byte* row = found.nearest.row;
  if (found.limit && row != nullptr && info_.is_for_caller && !looks_.empty()) {
    const LookUpRowLayout& layout = look_up_.row_layout();
    const auto number = load<std::uint8_t>(row + layout.look_index, *found.limit);
    if (number >= looks_.size()) return unknown_range(found.nearest.site);
    if (looks_[number].range_m <= visible_m) {
      RangeAnswer numbers = range;
      numbers.flags = load<std::uint8_t>(row + layout.look_flags, *found.limit);
      numbers.reason = load<Reason>(row + layout.look_reason, *found.limit);
      numbers.probability = layout.share(row, layout.look_probability, *found.limit);
      numbers.mean_error_m = layout.length_m(row, layout.look_mean_error, *found.limit);
      SIGHTLINE_ASSIGN(numbers, believable(numbers, info_.site_count));
      return look_answer(looks_[number], numbers);
    }
  }
  if (!(range.range_m <= visible_m)) {
    range.flags |= kAnswerNotVisible;
    range.range_m = ranges_m_.back();
    range.reason = Reason::kNone;
    if (info_.is_for_caller) range.probability = 0.0;
  }
  return look_answer({.range_m = range.range_m}, range);
}

Result<LookPlanAnswer> MapReader::look_plan(const std::array<double, 3>& position_world_m,
                                            double limit_m, bool is_tracking,
                                            double visible_m) const {
  SIGHTLINE_ASSIGN(const LookAnswer look, this->look(position_world_m, limit_m, visible_m));
  constexpr std::uint32_t kNoPlan = kAnswerFar | kAnswerTighterLimit | kAnswerUnknownLocalizer;
  const bool goes_by_plan = is_tracking && plan_ && limit_m >= plan_limit_m_ &&
                            (look.flags & kNoPlan) == 0 &&
                            std::max(plan_->first.look.range_m, plan_->second.range_m) <= visible_m;
  LookPlanAnswer answer;
  LookAnswer from_tracking = look;
  if (is_tracking) {
    SIGHTLINE_ASSIGN(from_tracking, tracking_look(look, limit_m, visible_m));
  }
  if (!goes_by_plan) {
    answer.first = from_tracking;
    return answer;
  }
  answer = *plan_;
  const MapLook usual = answer.first.look;
  const bool is_cheaper = look.look.return_count > 0 && look.look.point_count > 0 &&
                          look.look.return_count <= usual.return_count &&
                          look.look.point_count < usual.point_count;
  answer.first = look;
  answer.first.flags = from_tracking.flags;
  if (!is_cheaper) answer.first.look = usual;
  answer.first.look.settles = true;
  answer.first.probability = std::numeric_limits<double>::quiet_NaN();
  answer.first.mean_error_m = answer.first.probability;
  return answer;
}

}  // namespace sightline
