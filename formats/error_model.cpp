#include "formats/error_model.h"

#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

Error invalid(const std::string& place, const std::string& message) {
  return {ErrorCode::kInvalidArtifact, message, "", place};
}

bool are_finite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(),
                     [](double value) { return std::isfinite(value); });
}

Result<void> validate_card(const ErrorModel& model) {
  const TrainingCard& card = model.card;
  const std::vector<double> numbers = {card.feature_share, card.block_m, card.buffer_m,
                                       card.labelled_route_m};
  if (!are_finite(numbers) || *std::min_element(numbers.begin(), numbers.end()) < 0.0) {
    return invalid("model card", "found a number that is negative or not finite");
  }
  if (card.reference != ErrorReference::kKnownPose &&
      card.reference != ErrorReference::kFullRangeMatch) {
    return invalid("model card", "found an unknown reference");
  }
  if (card.tree_count != model.forest.trees.size()) {
    return invalid("model card", "found " + std::to_string(model.forest.trees.size()) +
                                     " trees, expected " + std::to_string(card.tree_count));
  }
  return {};
}

Result<void> validate_features(const ErrorModel& model) {
  if (model.features.size() != model.forest.feature_count ||
      model.features.back().name != "range_m") {
    return invalid("", "found " + std::to_string(model.features.size()) + " features, expected " +
                           std::to_string(model.forest.feature_count) + " that end in range_m");
  }
  for (const FeatureCard& feature : model.features) {
    const std::size_t count = model.ranges.size();
    if (feature.support_min.size() != count || feature.support_max.size() != count ||
        !are_finite(feature.support_min) || !are_finite(feature.support_max) ||
        !std::isfinite(feature.importance_m)) {
      return invalid("feature " + feature.name, "its support or importance makes no sense");
    }
    for (std::size_t range = 0; range < count; ++range) {
      if (feature.support_min[range] > feature.support_max[range]) {
        return invalid("feature " + feature.name, "its support ends before it begins");
      }
    }
  }
  return {};
}

Result<void> validate_ranges(const ErrorModel& model) {
  if (model.ranges.size() != model.out_of_fold.ranges_m.size()) {
    return invalid("", "the model card and the predictions name other ranges");
  }
  for (std::size_t range = 0; range < model.ranges.size(); ++range) {
    const RangeCard& card = model.ranges[range];
    if (card.range_m != model.out_of_fold.ranges_m[range] ||
        !are_finite({card.mean_error_m, card.r_squared, card.rmse_m})) {
      return invalid("range " + std::to_string(range), "its card makes no sense");
    }
  }
  return {};
}

Result<void> validate_sites(const ErrorModel& model) {
  const std::size_t count = model.sites.size();
  if (model.out_of_fold.site_count != count ||
      model.measured_mean_m.size() != count * model.ranges.size() ||
      !are_finite(model.measured_mean_m)) {
    return invalid("", "predictions or labels do not fill " + std::to_string(count) + " sites");
  }
  std::size_t labelled_count = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const TrainedSite& site = model.sites[i];
    const bool follows = i == 0 || model.sites[i - 1].run < site.run ||
                         (model.sites[i - 1].run == site.run && model.sites[i - 1].s_m < site.s_m);
    if (!site.p_world_m.allFinite() || !std::isfinite(site.s_m) || !follows || site.has_label > 1 ||
        site.block >= model.card.block_count) {
      return invalid("site " + std::to_string(i), "its place, order or block makes no sense");
    }
    labelled_count += site.has_label;
  }
  if (labelled_count * model.ranges.size() != model.forest.labels.size()) {
    return invalid("", "found " + std::to_string(model.forest.labels.size()) +
                           " training rows, expected " + std::to_string(model.ranges.size()) +
                           " for each of " + std::to_string(labelled_count) + " sites");
  }
  return {};
}

void append_card(const ErrorModel& model, Table& table) {
  const TrainingCard& card = model.card;
  const bool is_known = card.reference == ErrorReference::kKnownPose;
  table.facts = {{"drive", card.drive},
                 {"reference", std::string(is_known ? "known-pose" : "full-range-match")},
                 {"feature_set", card.feature_set},
                 {"seed", std::to_string(card.seed)},
                 {"tree_count", std::int64_t{card.tree_count}},
                 {"least_leaf_rows", std::int64_t{card.least_leaf_rows}},
                 {"feature_share", card.feature_share},
                 {"training_rows", static_cast<std::int64_t>(model.forest.labels.size())},
                 {"block_m", card.block_m},
                 {"buffer_m", card.buffer_m},
                 {"labelled_route_m", card.labelled_route_m},
                 {"block_count", std::int64_t{card.block_count}},
                 {"fold_count", std::int64_t{card.fold_count}}};
  for (const RangeCard& range : model.ranges) {
    const std::string name = "range_" + format_double(range.range_m) + "_m_";
    table.facts.emplace_back(name + "r_squared", range.r_squared);
    table.facts.emplace_back(name + "rmse_m", range.rmse_m);
  }
  for (const FeatureCard& feature : model.features) {
    table.facts.emplace_back("importance_" + feature.name + "_m", feature.importance_m);
  }
}

Table ranges_table(const ErrorModel& model) {
  Table table{"error-model-ranges", {"range_m", "mean_error_m", "r_squared", "rmse_m"}, {}, {}};
  for (const RangeCard& range : model.ranges) {
    table.rows.push_back({range.range_m, range.mean_error_m, range.r_squared, range.rmse_m});
  }
  return table;
}

Table features_table(const ErrorModel& model) {
  Table table{"error-model-features",
              {"feature", "importance_m", "range_m", "support_min", "support_max"},
              {},
              {}};
  for (const FeatureCard& feature : model.features) {
    for (std::size_t range = 0; range < model.ranges.size(); ++range) {
      table.rows.push_back({feature.name, feature.importance_m, model.ranges[range].range_m,
                            feature.support_min[range], feature.support_max[range]});
    }
  }
  return table;
}

Table nodes_table(const ErrorModel& model) {
  Table table{
      "error-model-nodes", {"tree", "node", "feature", "threshold", "left", "right"}, {}, {}};
  for (std::size_t t = 0; t < model.forest.trees.size(); ++t) {
    const std::vector<TreeNode>& nodes = model.forest.trees[t].nodes;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      table.rows.push_back({static_cast<std::int64_t>(t), static_cast<std::int64_t>(i),
                            model.features[nodes[i].feature].name, double{nodes[i].threshold},
                            std::int64_t{nodes[i].left}, std::int64_t{nodes[i].right}});
    }
  }
  return table;
}

Table leaves_table(const ErrorModel& model) {
  Table table{"error-model-leaves", {"tree", "leaf", "label_m"}, {}, {}};
  for (std::size_t t = 0; t < model.forest.trees.size(); ++t) {
    const std::vector<std::uint32_t>& leaves = model.forest.trees[t].leaf_of_label;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      table.rows.push_back(
          {static_cast<std::int64_t>(t), std::int64_t{leaves[i]}, model.forest.labels[i]});
    }
  }
  return table;
}

void encode_card(const TrainingCard& card, ByteWriter& writer) {
  writer.put_string(card.drive);
  writer.put(card.reference);
  writer.put_string(card.feature_set);
  writer.put(card.seed);
  writer.put(card.tree_count);
  writer.put(card.least_leaf_rows);
  writer.put(card.feature_share);
  writer.put(card.block_m);
  writer.put(card.buffer_m);
  writer.put(card.labelled_route_m);
  writer.put(card.block_count);
  writer.put(card.fold_count);
}

void decode_card(ByteReader& reader, TrainingCard& card) {
  reader.get_string(card.drive);
  reader.get(card.reference);
  reader.get_string(card.feature_set);
  reader.get(card.seed);
  reader.get(card.tree_count);
  reader.get(card.least_leaf_rows);
  reader.get(card.feature_share);
  reader.get(card.block_m);
  reader.get(card.buffer_m);
  reader.get(card.labelled_route_m);
  reader.get(card.block_count);
  reader.get(card.fold_count);
}

void decode_sites(ByteReader& reader, std::vector<TrainedSite>& sites) {
  constexpr std::size_t kBytesPerSite = 4 * sizeof(double) + 4 + 4 + 1 + 8;
  sites.resize(reader.get_count(kBytesPerSite));
  for (TrainedSite& site : sites) {
    for (int axis = 0; axis < 3; ++axis) reader.get(site.p_world_m[axis]);
    reader.get(site.run);
    reader.get(site.s_m);
    reader.get(site.block);
    reader.get(site.has_label);
    reader.get(site.factor_digest);
  }
}

}  // namespace

Result<void> validate(const ErrorModel& model) {
  Result<void> valid = validate(model.forest);
  if (valid) valid = validate(model.out_of_fold);
  if (valid) valid = validate_card(model);
  if (valid) valid = validate_ranges(model);
  if (valid) valid = validate_features(model);
  if (valid) valid = validate_sites(model);
  return valid;
}

Table dump(const ErrorModel& model) {
  Table table = dump(model.out_of_fold);
  table.name = "error-model";
  append_card(model, table);
  table.columns.insert(table.columns.begin() + 1, {"run", "s_m", "block", "measured_mean_error_m"});
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const TrainedSite& site = model.sites[i / model.ranges.size()];
    const Cell measured =
        site.has_label == 1 ? Cell(model.measured_mean_m[i]) : Cell(std::string());
    table.rows[i].insert(table.rows[i].begin() + 1,
                         {std::int64_t{site.run}, site.s_m, std::int64_t{site.block}, measured});
  }
  return table;
}

std::vector<Table> tables(const ErrorModel& model) {
  return {ranges_table(model), features_table(model), nodes_table(model), leaves_table(model)};
}

void encode(const ErrorModel& model, ByteWriter& writer) {
  encode_card(model.card, writer);
  writer.put<std::uint64_t>(model.features.size());
  for (const FeatureCard& feature : model.features) {
    writer.put_string(feature.name);
    writer.put(feature.importance_m);
    writer.put_array(feature.support_min);
    writer.put_array(feature.support_max);
  }
  writer.put<std::uint64_t>(model.ranges.size());
  for (const RangeCard& range : model.ranges) {
    writer.put(range.range_m);
    writer.put(range.mean_error_m);
    writer.put(range.r_squared);
    writer.put(range.rmse_m);
  }
  encode(model.forest, writer);
  writer.put<std::uint64_t>(model.sites.size());
  for (const TrainedSite& site : model.sites) {
    for (int axis = 0; axis < 3; ++axis) writer.put(site.p_world_m[axis]);
    writer.put(site.run);
    writer.put(site.s_m);
    writer.put(site.block);
    writer.put(site.has_label);
    writer.put(site.factor_digest);
  }
  encode(model.out_of_fold, writer);
  writer.put_array(model.measured_mean_m);
}

void decode(ByteReader& reader, ErrorModel& model) {
  constexpr std::size_t kBytesPerFeature = 4 * sizeof(std::uint64_t);
  constexpr std::size_t kBytesPerRange = 4 * sizeof(double);
  decode_card(reader, model.card);
  model.features.resize(reader.get_count(kBytesPerFeature));
  for (FeatureCard& feature : model.features) {
    reader.get_string(feature.name);
    reader.get(feature.importance_m);
    reader.get_array(feature.support_min);
    reader.get_array(feature.support_max);
  }
  model.ranges.resize(reader.get_count(kBytesPerRange));
  for (RangeCard& range : model.ranges) {
    reader.get(range.range_m);
    reader.get(range.mean_error_m);
    reader.get(range.r_squared);
    reader.get(range.rmse_m);
  }
  decode(reader, model.forest);
  decode_sites(reader, model.sites);
  decode(reader, model.out_of_fold);
  reader.get_array(model.measured_mean_m);
}

}  // namespace sightline
