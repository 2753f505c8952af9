#include "compiler/views/text/map_summary_text.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "compiler/views/verdict/verdict_text.h"
#include "formats/text/numbers.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kNameWidth = 11;
constexpr std::size_t kShownLimits = 4;  // of a table: more are wider than a screen

// The name, and beside it the value in as many lines as it needs.
std::string field(const std::string& name, const std::string& value) {
  std::string text = wrapped(value, 120 - kNameWidth, 0);
  for (std::size_t at = text.find('\n'); at + 1 < text.size(); at = text.find('\n', at + 1)) {
    text.insert(at + 1, kNameWidth, ' ');
  }
  return fmt::format("{:<{}}{}", name, kNameWidth, text);
}

std::string centimetres(double limit_m) {
  return format_double(std::round(1e6 * limit_m) / 1e4) + " cm";
}

std::size_t run_count(const Sites& sites) {
  return sites.sites.empty() ? 0 : sites.sites.back().run + std::size_t{1};
}

std::uint64_t rows_of(const MapSummary& summary, const std::string& block) {
  const auto found = std::ranges::find(summary.blocks, block, &MapSummary::Blocks::name);
  return found == summary.blocks.end() ? 0 : found->row_count;
}

std::string_view source_name(PoseSource source) {
  static constexpr std::array<std::string_view, 3> kNames = {"given", "refined", "estimated"};
  return kNames[static_cast<std::size_t>(source)];
}

std::string drives_text(const MeasurementCard& card) {
  if (card.reference == ErrorReference::kSimulated) {
    return card.mapping_drive + " was a finished map; no drive was localized, errors are simulated";
  }
  return fmt::format("{} ({} scans) made the map, {} ({} scans) was localized in it, against {}",
                     card.mapping_drive, card.mapping_scans, card.localization_drive,
                     card.localization_scans, reference_text(card.reference));
}

// How far poses that nothing measured can be relied on.
std::string doubt_text(const TrajectoryQuality& trajectory) {
  if (trajectory.source != PoseSource::kEstimated) return "";
  std::string text;
  if (trajectory.overlap_count > 0) {
    text = fmt::format(
        "; {:.0f} % of the walls in a scan meet those of the scans before (median; least {:.0f} %)",
        100.0 * trajectory.median_overlap, 100.0 * trajectory.least_overlap);
  }
  return trajectory.loop_edges > 0
             ? text
             : text + "; no place is passed twice, so errors add up along the route";
}

std::string poses_text(const TrajectoryQuality& trajectory) {
  std::string text(source_name(trajectory.source));
  if (trajectory.pieces.size() > 1) {
    text += fmt::format(", in {} pieces that are not connected", trajectory.pieces.size());
  }
  if (trajectory.odometry_edges > 0) {
    text += fmt::format(", pose graph of {} steps and {} loops", trajectory.odometry_edges,
                        trajectory.loop_edges);
  }
  return text + doubt_text(trajectory);
}

// The one that leaves most of the way open: an assumed one before others, of these the longest.
const UnconstrainedStretch& worst_of(const std::vector<UnconstrainedStretch>& stretches) {
  return *std::ranges::max_element(stretches, {}, [](const UnconstrainedStretch& stretch) {
    return std::pair(stretch.is_assumed(), stretch.way_m);
  });
}

std::string unconstrained_text(const std::vector<UnconstrainedStretch>& stretches) {
  const UnconstrainedStretch& worst = worst_of(stretches);
  if (stretches.size() == 1) return to_text(worst);
  double way_m = 0.0;
  for (const UnconstrainedStretch& stretch : stretches) way_m += stretch.way_m;
  return fmt::format("{} m of the way on {} stretches; {} (--all lists them)", fixed(way_m, 1),
                     stretches.size(), to_text(worst));
}

// "given-poses-disagree (5 places, most 69.1 m at scans 113 to 114)"
std::string notice_text(const Notice& notice) {
  std::string facts;
  if (notice.count > 1) facts = fmt::format("{} places", notice.count);
  if (!notice.unit.empty()) {
    facts += fmt::format("{}{}{} {}", facts.empty() ? "" : ", ", notice.count > 1 ? "most " : "",
                         fixed(notice.amount, notice.amount < 10.0 ? 2 : 1), notice.unit);
  }
  if (notice.last_scan > 0) {
    facts += fmt::format(" at scans {} to {}", notice.first_scan, notice.last_scan);
  }
  return facts.empty() ? notice.code : concat(notice.code, " (", facts, ")");
}

std::string notices_text(const std::vector<Notice>& notices) {
  std::string text;
  for (const Notice& notice : notices) text += (text.empty() ? "" : "; ") + notice_text(notice);
  return text + " (--all explains them)";
}

// What positions in the map are relative to.
std::string world_text(const CompiledMap& map) {
  if (map.world != kLocalWorld) return map.world;
  const bool is_estimated = map.trajectory && map.trajectory->source == PoseSource::kEstimated;
  return is_estimated ? "starts at the first scan (no poses were given)"
                      : "the coordinates of the recording's poses";
}

std::string facts_text(const InspectedMap& inspected) {
  const CompiledMap& map = inspected.map;
  const MapSummary& summary = inspected.summary;
  std::string text = field(
      "map", fmt::format("{}, {} bytes, format {}, version {}, release {}", inspected.file.string(),
                         summary.file_size, summary.format, map.version, map.release));
  const std::size_t runs = run_count(map.sites);
  text += field("route", fmt::format("{}, a place every {:g} m, in {} {}", extent_text(map.sites),
                                     map.sites.spacing_m, runs, runs == 1 ? "run" : "runs"));
  text += field(
      "content",
      fmt::format("{} NDs of {:g} m{} in {} tiles; factors {}, model {}", rows_of(summary, "ndt"),
                  map.ndt.cell_m, map.size == MapSize::kFull ? "" : " (a small map)",
                  summary.tile_count, map.factors.factors.empty() ? "stripped" : "included",
                  map.model.bytes.empty() ? "stripped" : "included"));
  text += field("world", world_text(map));
  text += field("drives", drives_text(map.measurement));
  if (map.trajectory) text += field("poses", poses_text(*map.trajectory));
  if (map.trajectory && !map.trajectory->unconstrained.empty()) {
    text += field("unobserved", unconstrained_text(map.trajectory->unconstrained));
  }
  if (!map.notices.empty()) text += field("doubts", notices_text(map.notices));
  text += field("sensor", fmt::format("{}, {} beams", map.sensor.name, map.sensor.ring_count()));
  text += field("localizer", localizer_title(map.model.localizer) +
                                 ": ranges, looks and probabilities are for it alone");
  if (map.looks && map.looks->ranges.plan) {
    text += field("plan", to_text(*map.looks->ranges.plan));
  }
  return text;
}

std::string share_cell(const CompiledMap& map, std::uint32_t count) {
  const std::size_t sites = std::max<std::size_t>(1, map.sites.sites.size());
  return percent(1.0 - static_cast<double>(count) / static_cast<double>(sites));
}

void append_quality(const CompiledMap& map, const std::vector<LimitQuality>& quality,
                    std::vector<std::string>& row) {
  for (std::size_t limit = 0; limit < std::min(quality.size(), kShownLimits); ++limit) {
    row.push_back(share_cell(map, quality[limit].unmet_count));
    row.push_back(percent(quality[limit].expected_coverage));
    if (map.measurement.measured_site_count > 0) {
      row.push_back(percent(quality[limit].measured_coverage));
    }
  }
}

constexpr const char* kWords =
    "\nA look is a small sample of a scan, a range all points up to a distance; a plan is a look, "
    "a "
    "test, and a larger look.\n";

// The figures of the map about its own answers.
std::string map_table(const CompiledMap& map) {
  TextGrid grid = {{"places"}};
  for (std::size_t limit = 0; limit < std::min(map.quality.size(), kShownLimits); ++limit) {
    grid[0].push_back(centimetres(map.ranges.promises[limit].limit_m) + ": answered");
    grid[0].emplace_back("predicted");
    if (map.measurement.measured_site_count > 0) grid[0].emplace_back("own drive");
  }
  if (map.looks) append_quality(map, map.looks->quality, grid.emplace_back(1, "look"));
  append_quality(map, map.quality, grid.emplace_back(1, "range"));
  std::string text = aligned(grid) + "Mean range: ";
  for (std::size_t limit = 0; limit < std::min(map.quality.size(), kShownLimits); ++limit) {
    text += concat(limit > 0 ? ", " : "", fixed(map.quality[limit].mean_range_m, 1), " m for ",
                   centimetres(map.ranges.promises[limit].limit_m));
  }
  return text + (map.looks ? kWords : "\n");
}

std::string lost_cell(const std::optional<std::uint32_t>& count) {
  return count ? std::to_string(*count) : "-";
}

std::string kind_title(AnswerKind kind) { return concat("the map's ", name_of(kind)); }

// Cells of one kind of answer; "-" where it was not judged.
std::vector<std::string> answer_row(const EvaluationFigures& evaluation, AnswerKind kind,
                                    std::size_t limits) {
  std::vector<std::string> row = {kind_title(kind)};
  for (std::size_t i = 0; i < limits; ++i) {
    const std::vector<AnswerScore>& answers = evaluation.limits[i].answers;
    const auto score = std::ranges::find(answers, kind, &AnswerScore::kind);
    if (score == answers.end()) {
      row.insert(row.end(), {"-", "-", "-", "-"});
    } else {
      row.insert(row.end(), {percent(score->coverage), lost_cell(score->lost_count),
                             fixed(score->work_ratio, 3), fixed(score->time_ratio, 3)});
    }
  }
  return row;
}

bool is_judged(const EvaluationFigures& evaluation, AnswerKind kind) {
  return std::ranges::any_of(evaluation.limits, [&](const LimitFigures& limit) {
    return std::ranges::find(limit.answers, kind, &AnswerScore::kind) != limit.answers.end();
  });
}

// ": 30 m", or " within 10 cm: 30 m; within 25 cm: 15 m" where they differ.
std::string constants_text(const MapJudgement& judgement, std::size_t limits) {
  std::string text;
  std::set<std::string> looks;
  for (std::size_t i = 0; i < limits; ++i) {
    const LimitVerdict& limit = judgement.limits[i];
    if (!limit.constant) continue;
    looks.insert(limit.constant->look);
    text += concat(text.empty() ? "" : ";", " within ", centimetres(limit.limit_m), ": ",
                   limit.constant->look);
  }
  return looks.size() == 1 ? ": " + *looks.begin() : text;
}

Json quality_json(const CompiledMap& map, const RangeTable& table, const LimitQuality& quality,
                  std::size_t limit) {
  const LimitPromise& promise = table.promises[limit];
  const std::size_t sites = std::max<std::size_t>(1, map.sites.sites.size());
  Json json = {{"answered_share",
                1.0 - static_cast<double>(quality.unmet_count) / static_cast<double>(sites)},
               {"extrapolated_share",
                static_cast<double>(quality.extrapolated_count) / static_cast<double>(sites)},
               {"expected_coverage", quality.expected_coverage},
               {"measured_coverage", nullptr},
               {"mean_range_m", quality.mean_range_m},
               {"promise",
                {{"is_earned", promise.is_earned},
                 {"alpha", promise.alpha},
                 {"calibration_miss_share", promise.calibration_miss_share},
                 {"calibration_answered_share", promise.answered_share},
                 {"block_count", promise.block_count},
                 {"method", promise.method},
                 {"statement", promise.statement}}}};
  if (map.measurement.measured_site_count > 0) {
    json["measured_coverage"] = quality.measured_coverage;
  }
  return json;
}

Json limits_json(const CompiledMap& map) {
  Json limits = Json::array();
  for (std::size_t i = 0; i < map.ranges.promises.size(); ++i) {
    Json limit = {{"limit_m", map.ranges.promises[i].limit_m},
                  {"range", quality_json(map, map.ranges, map.quality[i], i)},
                  {"look", nullptr}};
    if (map.looks) {
      limit["look"] = quality_json(map, map.looks->ranges, map.looks->quality[i], i);
    }
    limits.push_back(std::move(limit));
  }
  return limits;
}

Json stretches_json(const std::vector<UnconstrainedStretch>& stretches) {
  Json json = Json::array();
  for (const UnconstrainedStretch& stretch : stretches) {
    const auto& [along, across, heading, substitute] = stretch.directions;
    json.push_back({{"first_scan", stretch.first_scan},
                    {"last_scan", stretch.last_scan},
                    {"way_m", stretch.way_m},
                    {"along", along},
                    {"across", across},
                    {"heading", heading},
                    {"substitute", name_of(substitute)},
                    {"sigma_m", stretch.sigma_m ? Json(*stretch.sigma_m) : Json()}});
  }
  return json;
}

Json notices_json(const std::vector<Notice>& notices) {
  Json json = Json::array();
  for (const Notice& notice : notices) {
    json.push_back({{"code", notice.code},
                    {"text", notice.text},
                    {"count", notice.count},
                    {"first_scan", notice.first_scan},
                    {"last_scan", notice.last_scan},
                    {"amount", notice.unit.empty() ? Json() : Json(notice.amount)},
                    {"unit", notice.unit}});
  }
  return json;
}

Json trajectory_json(const CompiledMap& map) {
  if (!map.trajectory) return {};
  return {{"source", source_name(map.trajectory->source)},
          {"pieces", map.trajectory->pieces.size()},
          {"odometry_edges", map.trajectory->odometry_edges},
          {"loop_edges", map.trajectory->loop_edges},
          {"unconstrained", stretches_json(map.trajectory->unconstrained)}};
}

Json drives_json(const MeasurementCard& card) {
  return {{"mapping", card.mapping_drive},
          {"localization", card.localization_drive},
          {"reference", name_of(card.reference)},
          {"measured_site_count", card.measured_site_count}};
}

}  // namespace

std::string extent_text(const Sites& sites) {
  return fmt::format("{} places, {:.0f} m of route", sites.sites.size(), route_length_m(sites));
}

std::string summary_text(const InspectedMap& inspected) {
  const CompiledMap& map = inspected.map;
  std::string text = to_text(inspected.judgement) + "\n" + facts_text(inspected);
  if (!map.quality.empty()) text += "\n" + map_table(map);
  if (inspected.evaluation != nullptr) {
    text += "\n" + answers_table(*inspected.evaluation, inspected.judgement);
  }
  return text +
         "\nMore: --all prints promises, histograms, model and sizes; --site N explains one "
         "site; words: schemas/glossary.md\n";
}

Json to_json(const InspectedMap& inspected) {
  const CompiledMap& map = inspected.map;
  const MapSummary& summary = inspected.summary;
  const Eigen::Vector3d& origin_m = map.ndt.frame.origin_world_m;
  return {{"schema", 1},
          {"file",
           {{"path", inspected.file.string()},
            {"size", summary.file_size},
            {"format", summary.format},
            {"root_digest", to_hex(summary.root_digest)},
            {"tiles", summary.tile_count}}},
          {"map",
           {{"id", map.map_id},
            {"version", map.version},
            {"release", map.release},
            {"writer", map.writer},
            {"world", map.world},
            {"size", name_of(map.size)},
            {"origin_world_m", {origin_m.x(), origin_m.y(), origin_m.z()}}}},
          {"sites",
           {{"count", map.sites.sites.size()},
            {"spacing_m", map.sites.spacing_m},
            {"runs", run_count(map.sites)},
            {"route_m", route_length_m(map.sites)}}},
          {"nds", {{"count", rows_of(summary, "ndt")}, {"cell_m", map.ndt.cell_m}}},
          {"sensor", map.sensor.name},
          {"localizer", to_text(map.model.localizer)},
          {"drives", drives_json(map.measurement)},
          {"trajectory", trajectory_json(map)},
          {"notices", notices_json(map.notices)},
          {"limits", limits_json(map)},
          {"plan",
           map.looks && map.looks->ranges.plan ? Json(to_text(*map.looks->ranges.plan)) : Json()},
          {"verdict", to_json(inspected.judgement)}};
}

nlohmann::ordered_json model_json(const ByFamily<ErrorModel>& model) {
  const ModelRecord record = record_of(model);
  nlohmann::ordered_json card = nlohmann::ordered_json::object();
  for (const auto& [name, value] : record.card) card[name] = value;
  return {{"schema", 1},
          {"model",
           {{"sha256", to_hex(record.digest)},
            {"encoding", record.encoding_version},
            {"localizer", to_text(record.localizer)},
            {"card", card}}}};
}

std::string answers_table(const EvaluationFigures& evaluation, const MapJudgement& judgement) {
  const std::size_t limits = std::min(evaluation.limits.size(), kShownLimits);
  TextGrid grid = {{evaluation.scan_count > 0 ? "share of scans" : "share of places"}};
  std::vector<std::string> constant = {"best fixed choice"};
  for (std::size_t i = 0; i < limits; ++i) {
    const std::string limit = "within " + centimetres(evaluation.limits[i].limit_m);
    grid[0].insert(grid[0].end(), {limit, "lost", "work", "time"});
    const std::optional<ConstantScore>& best = judgement.limits[i].constant;
    if (best) {
      constant.insert(constant.end(), {percent(best->coverage), lost_cell(best->lost_count),
                                       fixed(best->work_ratio, 3), fixed(best->time_ratio, 3)});
    } else {
      constant.insert(constant.end(), {"-", "-", "-", "-"});
    }
  }
  for (const AnswerKind kind : {AnswerKind::kPlan, AnswerKind::kLook, AnswerKind::kRange}) {
    if (is_judged(evaluation, kind)) grid.push_back(answer_row(evaluation, kind, limits));
  }
  grid.push_back(constant);
  return aligned(grid) + wrapped(
                             "Work (points times iterations) and time 1 are those of the longest "
                             "range everywhere. Best fixed choice, by work" +
                             constants_text(judgement, limits) + ".");
}

}  // namespace sightline
