#include "formats/map/compiled_map.h"

#include <algorithm>

#include "formats/annotation/range_rule.h"
#include "formats/base/parallel.h"
#include "formats/base/statistics.h"
#include "formats/map/factor_layer.h"
#include "formats/record/cells.h"

namespace sightline {
namespace {

LimitQuality quality_of_limit(const PredictedError& predicted, const RangeTable& ranges,
                              const MeasuredError* measured, std::size_t limit) {
  LimitQuality quality;
  std::vector<double> ranges_m;
  std::vector<double> probabilities;
  std::size_t measured_count = 0;
  std::size_t within_count = 0;
  for (std::size_t site = 0; site < ranges.site_count; ++site) {
    const Answer answer = answer_of(ranges, predicted, site, limit);
    if ((answer.flags & kUnmet) != 0) ++quality.unmet_count;
    if ((answer.flags & kExtrapolated) != 0) ++quality.extrapolated_count;
    ranges_m.push_back(answer.look.range_m);
    probabilities.push_back(answer.probability);
    if (measured == nullptr || site >= measured->scan_of_site.size() ||
        measured->scan_of_site[site] < 0) {
      continue;
    }
    ++measured_count;
    if (measured->row(site, ranges.range(site, limit)).mean_m <= ranges.promises[limit].limit_m)
      ++within_count;
  }
  const auto count = static_cast<double>(ranges.site_count);
  quality.mean_range_m = ordered_sum(ranges_m) / count;
  quality.expected_coverage = ordered_sum(probabilities) / count;
  if (measured_count > 0) {
    quality.measured_coverage =
        static_cast<double>(within_count) / static_cast<double>(measured_count);
  }
  return quality;
}

// What is behind a member of both families.
template <class X>
ByFamily<X> both_of(const CompiledMap& map, const X& ranges, X LooksOfMap::*member) {
  ByFamily<X> both(ranges);
  if (map.looks) both.samples = (*map.looks).*member;
  return both;
}

double to_multiple(double value, double unit) { return std::round(value / unit) * unit; }

void round_site(Site& site) {
  site.s_m = to_multiple(site.s_m, kSmallLength_m);
  for (int axis = 0; axis < 3; ++axis) {
    site.p_map_m[axis] = to_multiple(site.p_map_m[axis], kSmallLength_m);
    double& place_m = site.T_map_vehicle(axis, 3);
    place_m = to_multiple(place_m, kSmallLength_m);
    for (int column = 0; column < 3; ++column) {
      double& entry = site.T_map_vehicle(axis, column);
      entry = to_multiple(entry, kSmallRotation);
    }
  }
}

void round_predicted(PredictedError& predicted) {
  for (double& mean_m : predicted.mean_m) {
    mean_m = std::min(to_multiple(mean_m, kSmallLength_m), kLongestSmallError_m);
  }
  for (double& share : predicted.within_probability) share = to_multiple(share, kSmallShare);
}

}  // namespace

ByFamily<PredictedError> predicted_of(const CompiledMap& map) {
  return both_of(map, map.predicted, &LooksOfMap::predicted);
}

ByFamily<RangeTable> choice_of(const CompiledMap& map) {
  return both_of(map, map.ranges, &LooksOfMap::ranges);
}

ByFamily<const FactorTable*> factors_in(const CompiledMap& map) {
  ByFamily<const FactorTable*> factors(&map.factors);
  const bool has_samples =
      !map.factors.factors.empty() && map.looks.has_value() && !map.looks->factors.factors.empty();
  if (has_samples) factors.samples = &map.looks->factors;
  return factors;
}

ByFamily<FactorTable> factors_of(const CompiledMap& map) {
  const ByFamily<const FactorTable*> factors = factors_in(map);
  return {*factors.ranges, factors.samples ? std::optional(**factors.samples) : std::nullopt};
}

Table dump(const CompiledMap& map) {
  Table table = dump(map.sites);
  table.name = "map";
  table.facts.insert(table.facts.begin(), {{"map_id", map.map_id},
                                           {"version", map.version},
                                           {"release", static_cast<std::int64_t>(map.release)},
                                           {"writer", map.writer}});
  table.facts.emplace_back("reach_m", map.reach_m);
  if (map.world != kLocalWorld) table.facts.emplace_back("world", map.world);
  const std::size_t limits = map.ranges.promises.size();
  for (const LimitPromise& promise : map.ranges.promises) {
    const std::string limit = format_double(promise.limit_m) + "_m";
    table.columns.push_back("range_m_within_" + limit);
    table.columns.push_back("p_within_" + limit);
    table.columns.push_back("flags_within_" + limit);
    table.columns.push_back("reason_within_" + limit);
    if (!map.looks) continue;
    table.columns.push_back("look_within_" + limit);
    table.columns.push_back("look_p_within_" + limit);
    table.columns.push_back("look_flags_within_" + limit);
    table.columns.push_back("look_reason_within_" + limit);
  }
  for (std::size_t site = 0; site < map.ranges.site_count; ++site) {
    for (std::size_t limit = 0; limit < limits; ++limit) {
      std::vector<Cell>& row = table.rows[site];
      const Answer range = answer_of(map.ranges, map.predicted, site, limit);
      row.insert(row.end(), {range.look.range_m, range.probability, std::int64_t{range.flags},
                             cell_of(range.reason)});
      if (!map.looks) continue;
      const Answer look = answer_of(map.looks->ranges, map.looks->predicted, site, limit);
      row.insert(row.end(), {to_text(look.look), look.probability, std::int64_t{look.flags},
                             cell_of(look.reason)});
    }
  }
  return table;
}

std::vector<std::string> dump_names() {
  return {"nds", "sites", "predicted", "ranges", "factors", "model", "columns", "tile-drives"};
}

Result<Table> dump(const CompiledMap& map, std::string_view name) {
  if (name == "nds") return dump(map.ndt);
  if (name == "sites") return dump(map.sites);
  if (name == "predicted") return dump(predicted_of(map));
  if (name == "ranges") return dump(choice_of(map));
  if (name == "factors") {
    if (map.factors.factors.empty()) {
      return Error{ErrorCode::kBadLayer, "the map contains no factors"};
    }
    return dump(factors_of(map));
  }
  if (name == "model") {
    SIGHTLINE_ASSIGN(const ByFamily<ErrorModel> model, model_of(map.model));
    return dump(model);
  }
  if (name == "columns") return dump(map.columns);
  if (name == "tile-drives") return dump(map.tile_drives.value_or(TileDrives{}));
  return Error{
      ErrorCode::kUnknownName,
      concat("a map has no part \"", name,
             "\"; choose nds, sites, predicted, ranges, factors, model, columns or tile-drives")};
}

ModelRecord card_record_of(const ErrorModel& head, std::size_t training_row_count) {
  ModelRecord record;
  record.encoding_version = ArtifactTraits<ErrorModel>::kVersion;
  record.localizer = head.card.localizer;
  CardFacts card = card_facts(head, training_row_count);
  for (const auto& [name, value] : card.facts) record.card.emplace_back(name, cell_text(value));
  record.figures = std::move(card.figures);
  std::vector<double> r_squared;
  for (const RangeCard& range : head.ranges) r_squared.push_back(range.r_squared);
  record.mean_r_squared = mean_of(r_squared);
  return record;
}

ModelRecord record_of(const ByFamily<ErrorModel>& model) {
  ModelRecord record = card_record_of(model.ranges, model.ranges.forest.labels.size());
  // A model of a large field is a large part of what memory holds.
  ByteWriter writer;
  writer.reserve(payload_size(model));
  encode(model, writer);
  record.bytes = writer.take();
  record.digest = sha256(record.bytes);
  return record;
}

Result<ByFamily<ErrorModel>> model_of(const ModelRecord& record) {
  const std::string place = "section " + std::string(kModelSection);
  if (record.bytes.empty()) {
    return Error{ErrorCode::kBadLayer, "the map has no error model: `sightline strip` removed it",
                 "", place};
  }
  if (sha256(record.bytes) != record.digest) {
    return Error{ErrorCode::kDigestMismatch, "the model's digest differs from the one in the map",
                 "", place};
  }
  constexpr std::uint32_t kKnown = ArtifactTraits<ErrorModel>::kVersion;
  if (record.encoding_version != kKnown) {
    return Error{
        record.encoding_version > kKnown ? ErrorCode::kFutureVersion : ErrorCode::kOldVersion,
        concat("found a model of encoding ", record.encoding_version, ", this program reads ",
               kKnown),
        "", place};
  }
  ByteReader reader(record.bytes);
  ByFamily<ErrorModel> model;
  decode(reader, model);
  if (!reader.at_end()) {
    return Error{ErrorCode::kBadLayer, "the model cannot be decoded", "", place};
  }
  SIGHTLINE_TRY(validate(model));
  const LocalizerProfile& localizer = model.ranges.card.localizer;
  if (!(localizer == record.localizer)) {
    return Error{ErrorCode::kDigestMismatch,
                 concat("the model was trained on errors of ", to_text(localizer),
                        ", the map is for ", to_text(record.localizer)),
                 "", place};
  }
  return model;
}

TrajectoryQuality quality_of(const Trajectory& trajectory) {
  TrajectoryQuality quality{trajectory.source,
                            trajectory.odometry_edges,
                            trajectory.loop_edges,
                            trajectory.prior_edges,
                            trajectory.rms_translation_residual_m,
                            trajectory.rms_rotation_residual_rad};
  quality.pieces = pieces_of(trajectory);
  quality.unconstrained = unconstrained_stretches(trajectory);
  std::vector<double> overlaps;
  for (const TrajectoryPose& pose : trajectory.poses) {
    if (pose.overlap) overlaps.push_back(*pose.overlap);
  }
  if (overlaps.empty()) return quality;
  std::ranges::sort(overlaps);
  quality.overlap_count = static_cast<std::uint32_t>(overlaps.size());
  quality.median_overlap = overlaps[overlaps.size() / 2];
  quality.least_overlap = overlaps.front();
  return quality;
}

std::vector<TrajectoryPiece> pieces_of(const Trajectory& trajectory) {
  std::vector<TrajectoryPiece> pieces;
  const TrajectoryPose* before = nullptr;
  for (const TrajectoryPose& pose : trajectory.poses) {
    const Eigen::Vector3d at_m = pose.T_map_vehicle.translation();
    if (pose.piece >= pieces.size()) {
      pieces.push_back({pose.recording_index, pose.stamp_ns, 0, 0.0, at_m});
    }
    TrajectoryPiece& piece = pieces[pose.piece];
    ++piece.scan_count;
    if (before && before->piece == pose.piece) {
      piece.way_m += (at_m - before->T_map_vehicle.translation()).norm();
    }
    before = &pose;
  }
  return pieces;
}

std::vector<LimitQuality> quality_of(const PredictedError& predicted, const RangeTable& ranges,
                                     const MeasuredError* measured) {
  std::vector<LimitQuality> quality;
  for (std::size_t limit = 0; limit < ranges.promises.size(); ++limit) {
    quality.push_back(quality_of_limit(predicted, ranges, measured, limit));
  }
  return quality;
}

void round_answers(CompiledMap& map) {
  for (Site& site : map.sites.sites) round_site(site);
  round_predicted(map.predicted);
  if (map.looks) round_predicted(map.looks->predicted);
}

}  // namespace sightline
