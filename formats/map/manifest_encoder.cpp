#include "formats/map/manifest.h"

#include "formats/map/site_columns.h"
#include "map_generated.h"

namespace sightline {
namespace {

using Builder = flatbuffers::FlatBufferBuilder;

static_assert(static_cast<int>(schema::Reference::KnownPose) ==
                  static_cast<int>(ErrorReference::kKnownPose) &&
              static_cast<int>(schema::Reference::FullRangeMatch) ==
                  static_cast<int>(ErrorReference::kFullRangeMatch) &&
              static_cast<int>(schema::Reference::Simulated) ==
                  static_cast<int>(ErrorReference::kSimulated));
static_assert(static_cast<int>(schema::Rule::Mean) == static_cast<int>(Selection::kMean) &&
              static_cast<int>(schema::Rule::Probability) ==
                  static_cast<int>(Selection::kProbability));

schema::Rigid to_schema(const Pose& pose) {
  std::array<double, 12> values{};
  for (int i = 0; i < 12; ++i) values[static_cast<std::size_t>(i)] = pose(i / 4, i % 4);
  return schema::Rigid(flatbuffers::span<const double, 12>(values));
}

flatbuffers::Offset<schema::Sensor> encode_sensor(const SensorProfile& sensor, Builder& builder) {
  const schema::Rigid vehicle_from_lidar = to_schema(sensor.T_vehicle_lidar);
  return schema::CreateSensorDirect(builder, sensor.name.c_str(), &sensor.beam_elevations_deg,
                                    sensor.azimuth_step_deg, sensor.min_range_m, sensor.max_range_m,
                                    sensor.height_m, &vehicle_from_lidar, sensor.azimuth_view_deg);
}

flatbuffers::Offset<schema::LocalizerProfile> encode_localizer(const LocalizerProfile& profile,
                                                               Builder& builder) {
  std::vector<flatbuffers::Offset<schema::Fact>> parameters;
  for (const auto& [name, value] : profile.parameters) {
    parameters.push_back(schema::CreateFactDirect(builder, name.c_str(), value.c_str()));
  }
  return schema::CreateLocalizerProfileDirect(builder, profile.name.c_str(), profile.version,
                                              &parameters);
}

flatbuffers::Offset<schema::Look> encode_look(const Look& look, Builder& builder) {
  return schema::CreateLook(builder, look.range_m, look.return_count, look.even_beyond_m,
                            look.point_count, look.is_by_normals,
                            static_cast<schema::LookMode>(look.mode));
}

std::vector<schema::Offset> to_schema(const std::vector<InitialOffset>& offsets) {
  std::vector<schema::Offset> encoded;
  for (const InitialOffset& offset : offsets) {
    encoded.emplace_back(offset.x_m, offset.y_m, offset.z_m, offset.yaw_rad);
  }
  return encoded;
}

flatbuffers::Offset<schema::Measurement> encode_measurement(const MeasurementCard& card,
                                                            Builder& builder) {
  const std::vector<schema::Offset> offsets = to_schema(card.offsets);
  const std::vector<schema::Offset> tracking = to_schema(card.tracking_offsets);
  std::vector<flatbuffers::Offset<schema::Look>> looks;
  for (const Look& look : card.tracking_looks) looks.push_back(encode_look(look, builder));
  return schema::CreateMeasurementDirect(
      builder, card.mapping_drive.c_str(), card.mapping_scans.c_str(),
      card.localization_drive.c_str(), card.localization_scans.c_str(),
      static_cast<schema::Reference>(card.reference), &offsets, card.measured_site_count,
      encode_localizer(card.localizer, builder), card.coarse_cells, card.leaf_m,
      card.tracking_offsets.empty() ? nullptr : &tracking, looks.empty() ? nullptr : &looks);
}

std::vector<flatbuffers::Offset<schema::Promise>> encode_promises(const RangeTable& ranges,
                                                                  Builder& builder) {
  std::vector<flatbuffers::Offset<schema::Promise>> promises;
  for (const LimitPromise& promise : ranges.promises) {
    promises.push_back(schema::CreatePromiseDirect(
        builder, promise.limit_m, promise.probability_threshold, promise.alpha, promise.delta,
        promise.block_count, promise.is_earned, promise.calibration_miss_share,
        promise.method.c_str(), promise.statement.c_str(), promise.history_threshold,
        promise.place_count, promise.drive_count, static_cast<schema::Scope>(promise.scope),
        promise.answered_share));
  }
  return promises;
}

std::vector<flatbuffers::Offset<schema::LimitQuality>> encode_quality(
    const std::vector<LimitQuality>& quality, Builder& builder) {
  std::vector<flatbuffers::Offset<schema::LimitQuality>> encoded;
  for (const LimitQuality& limit : quality) {
    encoded.push_back(schema::CreateLimitQuality(builder, limit.unmet_count,
                                                 limit.extrapolated_count, limit.mean_range_m,
                                                 limit.expected_coverage, limit.measured_coverage));
  }
  return encoded;
}

flatbuffers::Offset<flatbuffers::Vector<flatbuffers::Offset<schema::Look>>> encode_looks(
    const std::vector<Look>& looks, Builder& builder) {
  std::vector<flatbuffers::Offset<schema::Look>> encoded;
  for (const Look& look : looks) encoded.push_back(encode_look(look, builder));
  return builder.CreateVector(encoded);
}

flatbuffers::Offset<schema::LookPlan> encode_plan(const LookPlan& plan, Builder& builder) {
  const auto first = encode_look(plan.first, builder);
  const auto second = encode_look(plan.second, builder);
  const auto weights = builder.CreateVector(plan.test.weights.data(), plan.test.weights.size());
  return schema::CreateLookPlan(builder, plan.limit_m, first, weights, plan.test.constant,
                                plan.doubt_above, second);
}

std::vector<flatbuffers::Offset<schema::NamedVersion>> encode_definitions(
    const std::vector<NamedVersion>& definitions, Builder& builder) {
  std::vector<flatbuffers::Offset<schema::NamedVersion>> encoded;
  for (const NamedVersion& definition : definitions) {
    encoded.push_back(
        schema::CreateNamedVersionDirect(builder, definition.name.c_str(), definition.version));
  }
  return encoded;
}

flatbuffers::Offset<schema::Model> encode_model(const ModelRecord& model, Builder& builder) {
  std::vector<flatbuffers::Offset<schema::Fact>> card;
  for (const auto& [name, value] : model.card) {
    card.push_back(schema::CreateFactDirect(builder, name.c_str(), value.c_str()));
  }
  std::vector<flatbuffers::Offset<schema::CardFigure>> figures;
  for (const CardFigure& figure : model.figures) {
    figures.push_back(schema::CreateCardFigureDirect(
        builder, figure.fact, static_cast<schema::CardFigureKind>(figure.kind), figure.of.c_str(),
        figure.value));
  }
  const schema::Digest digest(flatbuffers::span<const std::uint8_t, 32>(model.digest));
  return schema::CreateModelDirect(builder, model.encoding_version, &digest, &card,
                                   model.mean_r_squared, encode_localizer(model.localizer, builder),
                                   &figures);
}

flatbuffers::Offset<schema::SharpnessFigures> encode_figures(const SharpnessFigures& figures,
                                                             Builder& builder) {
  return schema::CreateSharpnessFigures(builder, figures.mean_entropy_nat, figures.entropy_points,
                                        figures.mean_plane_variance_m2, figures.plane_points);
}

// No offset where there is nothing to say.
flatbuffers::Offset<schema::Sharpness> encode_sharpness(const std::optional<Sharpness>& sharpness,
                                                        Builder& builder) {
  if (!sharpness) return 0;
  const auto of_map = encode_figures(sharpness->of_map, builder);
  flatbuffers::Offset<schema::SharpnessFigures> of_given = 0;
  if (sharpness->of_given) of_given = encode_figures(*sharpness->of_given, builder);
  return schema::CreateSharpness(builder, of_map, of_given);
}

schema::Vector3 to_schema(const Eigen::Vector3d& point_m) {
  return {point_m.x(), point_m.y(), point_m.z()};
}

using EncodedStretches = flatbuffers::Vector<flatbuffers::Offset<schema::UnconstrainedStretch>>;

flatbuffers::Offset<EncodedStretches> encode_unconstrained(
    const std::vector<UnconstrainedStretch>& stretches, Builder& builder) {
  if (stretches.empty()) return 0;
  std::vector<flatbuffers::Offset<schema::UnconstrainedStretch>> encoded;
  for (const UnconstrainedStretch& stretch : stretches) {
    const schema::Vector3 begin_map_m = to_schema(stretch.begin_map_m);
    const schema::Vector3 end_map_m = to_schema(stretch.end_map_m);
    const auto& [along, across, heading, substitute] = stretch.directions;
    encoded.push_back(schema::CreateUnconstrainedStretch(
        builder, stretch.first_scan, stretch.last_scan, stretch.way_m, along, across, heading,
        static_cast<schema::Substitute>(substitute), stretch.sigma_m.value_or(-1.0), &begin_map_m,
        &end_map_m));
  }
  return builder.CreateVector(encoded);
}

using EncodedNotices = flatbuffers::Vector<flatbuffers::Offset<schema::Notice>>;

flatbuffers::Offset<EncodedNotices> encode_notices(const std::vector<Notice>& notices,
                                                   Builder& builder) {
  if (notices.empty()) return 0;
  std::vector<flatbuffers::Offset<schema::Notice>> encoded;
  for (const Notice& notice : notices) {
    encoded.push_back(schema::CreateNoticeDirect(builder, notice.code.c_str(), notice.text.c_str(),
                                                 notice.count, notice.first_scan, notice.last_scan,
                                                 notice.amount, notice.unit.c_str()));
  }
  return builder.CreateVector(encoded);
}

flatbuffers::Offset<schema::TrajectoryQuality> encode_trajectory(
    const std::optional<TrajectoryQuality>& trajectory, Builder& builder) {
  if (!trajectory) return 0;
  std::vector<flatbuffers::Offset<schema::TrajectoryPiece>> pieces;
  for (const TrajectoryPiece& piece : trajectory->pieces) {
    const schema::Vector3 begin_map_m = to_schema(piece.begin_map_m);
    pieces.push_back(schema::CreateTrajectoryPiece(builder, piece.first_scan, piece.stamp_ns,
                                                   piece.scan_count, piece.way_m, &begin_map_m));
  }
  const auto all_pieces = builder.CreateVector(pieces);
  const auto unconstrained = encode_unconstrained(trajectory->unconstrained, builder);
  return schema::CreateTrajectoryQuality(
      builder, static_cast<schema::PoseSource>(trajectory->source), trajectory->odometry_edges,
      trajectory->loop_edges, trajectory->prior_edges, trajectory->rms_translation_residual_m,
      trajectory->rms_rotation_residual_rad, all_pieces, trajectory->overlap_count,
      trajectory->median_overlap, trajectory->least_overlap, unconstrained);
}

using EncodedColumns = flatbuffers::Vector<flatbuffers::Offset<schema::SiteColumn>>;

flatbuffers::Offset<EncodedColumns> encode_columns(const std::vector<SiteColumn>& columns,
                                                   Builder& builder) {
  if (columns.empty()) return 0;
  std::vector<flatbuffers::Offset<schema::SiteColumn>> encoded;
  for (const SiteColumn& column : columns) {
    const Digest bytes = sha256(encode_column(column));
    const flatbuffers::span<const std::uint8_t, 32> all(bytes);
    const schema::Digest digest(all);
    encoded.push_back(
        schema::CreateSiteColumnDirect(builder, column.name.c_str(), column.unit.c_str(), &digest,
                                       column.steps.empty() ? nullptr : &column.steps));
  }
  return builder.CreateVector(encoded);
}

// What the manifest says of the looks that take a sample; absent where there are none.
struct EncodedLooks {
  flatbuffers::Offset<flatbuffers::Vector<flatbuffers::Offset<schema::Look>>> looks = 0;
  flatbuffers::Offset<flatbuffers::Vector<flatbuffers::Offset<schema::Promise>>> promises = 0;
  flatbuffers::Offset<flatbuffers::Vector<flatbuffers::Offset<schema::LimitQuality>>> quality = 0;
  flatbuffers::Offset<schema::LookPlan> plan = 0;
};

EncodedLooks encode_choice_of_looks(const CompiledMap& map, Builder& builder) {
  EncodedLooks encoded;
  if (!map.looks) return encoded;
  const RangeTable& ranges = map.looks->ranges;
  encoded.looks = encode_looks(ranges.looks, builder);
  encoded.promises = builder.CreateVector(encode_promises(ranges, builder));
  encoded.quality = builder.CreateVector(encode_quality(map.looks->quality, builder));
  if (ranges.plan) encoded.plan = encode_plan(*ranges.plan, builder);
  return encoded;
}

}  // namespace

std::vector<std::byte> encode_manifest(const CompiledMap& map) {
  return encode_manifest(map, map.ndt.nds.size());
}

std::vector<std::byte> encode_manifest(const CompiledMap& map, std::uint64_t nd_count) {
  Builder builder;
  const Eigen::Vector3d& origin_m = map.ndt.frame.origin_world_m;
  const schema::Vector3 origin = to_schema(origin_m);
  const std::vector<double> ranges_m = ranges_of(map.ranges.looks);
  const auto promises = encode_promises(map.ranges, builder);
  const auto quality = encode_quality(map.quality, builder);
  const auto definitions = encode_definitions(map.definitions, builder);
  const auto sensor = encode_sensor(map.sensor, builder);
  const auto measurement = encode_measurement(map.measurement, builder);
  const auto model = encode_model(map.model, builder);
  const auto sharpness = encode_sharpness(map.sharpness, builder);
  const auto trajectory = encode_trajectory(map.trajectory, builder);
  const EncodedLooks looks = encode_choice_of_looks(map, builder);
  const auto map_id = builder.CreateString(map.map_id);
  const auto version = builder.CreateString(map.version);
  const auto writer = builder.CreateString(map.writer);
  const auto ranges = builder.CreateVector(ranges_m);
  const auto all_promises = builder.CreateVector(promises);
  const auto all_quality = builder.CreateVector(quality);
  const auto all_definitions = builder.CreateVector(definitions);
  const auto columns = encode_columns(map.columns, builder);
  const auto notices = encode_notices(map.notices, builder);
  flatbuffers::Offset<flatbuffers::String> world = 0;  // none where it is local
  if (map.world != kLocalWorld) world = builder.CreateString(map.world);
  builder.Finish(schema::CreateManifest(
      builder, map_id, version, map.release, writer, &origin, map.ndt.cell_m, map.ndt.tile_m,
      map.sites.spacing_m, map.reach_m, nd_count, map.ndt.sparse_cell_count,
      map.ndt.degenerate_cell_count, map.ndt.point_count, map.ranges.site_count, ranges,
      static_cast<schema::Rule>(map.ranges.selection), map.ranges.dilation_m, all_promises,
      all_quality, sensor, measurement, all_definitions, model, sharpness, trajectory,
      map.predicted.support_margin, map.ranges.extrapolated_takes_static, looks.looks,
      looks.promises, looks.quality, looks.plan, simulated_site_count(map.ranges), world, columns,
      notices, static_cast<schema::MapSize>(map.size)));
  const std::span<const std::uint8_t> bytes(builder.GetBufferPointer(), builder.GetSize());
  return {std::as_bytes(bytes).begin(), std::as_bytes(bytes).end()};
}

}  // namespace sightline
