#include <algorithm>
#include <functional>

#include "formats/model/error_model.h"
#include "formats/model/place_count.h"
#include "formats/record/cells.h"
#include "formats/text/numbers.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

void add_figure(const std::string& name, CardFigureKind kind, const std::string& of, double value,
                CardFacts& card) {
  card.figures.push_back({static_cast<std::uint32_t>(card.facts.size()), kind, of, value});
  card.facts.emplace_back(name, value);
}

}  // namespace

std::string same_place(const TrainingCard& card, std::size_t i) {
  const PlaceCard& place = card.places[i];
  for (std::size_t k = 0; k < i && !place.recording_numbers.empty(); ++k) {
    const PlaceCard& earlier = card.places[k];
    if (!earlier.recording_numbers.empty() && earlier.number == place.number) return earlier.name;
  }
  return "";
}

std::size_t place_count(const TrainingCard& card) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < card.places.size(); ++i) count += same_place(card, i).empty() ? 1 : 0;
  return count;
}

std::string places_text(const TrainingCard& card) {
  const std::size_t count = place_count(card);
  const std::string text = concat(count, count == 1 ? " place" : " places");
  for (std::size_t i = 0; i < card.places.size(); ++i) {
    const std::string same = same_place(card, i);
    if (same.empty()) continue;
    const std::size_t more = card.places.size() - count - 1;
    return concat(text, " (", card.places[i].name, " is the same place as ", same,
                  more > 0 ? concat("; ", more, " more") : "", ")");
  }
  return text;
}

CardFacts card_facts(const ErrorModel& model, std::size_t training_row_count) {
  CardFacts found;
  const TrainingCard& card = model.card;
  std::string places;
  std::string drives;
  for (const PlaceCard& place : card.places) {
    places += (places.empty() ? "" : ", ") + place.name;
    for (const std::string& drive : place.drives) drives += (drives.empty() ? "" : ", ") + drive;
  }
  found.facts = {{"places", places},
                 {"drives", drives},
                 {"worlds", card.worlds},
                 {"reference", cell_of(card.reference)},
                 {"localizer", to_text(card.localizer)},
                 {"feature_set", card.feature_set},
                 {"hold_out", card.hold_out},
                 {"knows_history", std::int64_t{card.knows_history ? 1 : 0}},
                 {"seed", std::to_string(card.seed)},
                 {"tree_count", std::int64_t{card.tree_count}},
                 {"least_leaf_rows", std::int64_t{card.least_leaf_rows}},
                 {"feature_share", card.feature_share},
                 {"training_rows", static_cast<std::int64_t>(training_row_count)},
                 {"block_m", card.block_m},
                 {"buffer_m", card.buffer_m},
                 {"labelled_route_m", card.labelled_route_m},
                 {"block_count", std::int64_t{card.block_count}},
                 {"fold_count", std::int64_t{card.fold_count}},
                 {"probability_offset", card.curve.offset},
                 {"probability_slope", card.curve.slope}};
  for (const RangeCard& range : model.ranges) {
    const std::string range_m = format_double(range.range_m);
    const std::string name = concat("range_", range_m, "_m_");
    add_figure(name + "r_squared", CardFigureKind::kRSquared, range_m, range.r_squared, found);
    add_figure(name + "rmse_m", CardFigureKind::kRmse_m, range_m, range.rmse_m, found);
    if (!card.knows_history) continue;
    found.facts.emplace_back(name + "history_r_squared", range.history_r_squared);
    found.facts.emplace_back(name + "history_rmse_m", range.history_rmse_m);
  }
  for (const KindCard& type : model.kinds) {
    found.facts.emplace_back(
        concat("coverage_of_", format_double(type.limit_m), "_m_in_", name_of(type.kind)),
        type.coverage);
  }
  for (const FeatureCard& feature : model.features) {
    add_figure(concat("importance_", feature.name, "_m"), CardFigureKind::kImportance_m,
               feature.name, feature.importance_m, found);
  }
  for (const PlaceCard& place : card.places) {
    for (const RecordingCard& recording : place.recordings.cards) {
      found.facts.emplace_back(concat("sha256_of_", recording.role, "_of_", place.name),
                               to_hex(recording.digest));
    }
  }
  return found;
}

namespace {

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
  const std::vector<const float*> rows = training_rows(model.forest);
  for (std::size_t t = 0; t < model.forest.trees.size(); ++t) {
    std::vector<std::uint32_t> leaves(rows.size());
    find_leaves(model.forest.trees[t].nodes, rows, leaves);
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      table.rows.push_back(
          {static_cast<std::int64_t>(t), std::int64_t{leaves[i]}, model.forest.labels[i]});
    }
  }
  return table;
}

std::string folds_text(const TrainingCard& card) {
  const std::string text = concat(card.fold_count, " folds of ");
  if (card.hold_out == "places") return text + "whole places";
  return concat(
      text, "blocks of ", fixed(card.block_m, 0), " m",
      (card.hold_out == "drives" ? ", each drive predicted by trees of the other drives" : ""));
}

std::string card_text(const ErrorModel& model) {
  const TrainingCard& card = model.card;
  std::string text = "Model card\n";
  if (card.is_of_generated_worlds()) text += "of generated worlds, not of recorded drives\n";
  TextGrid grid = {{"place", "same as", "centre (m, world)", "drives", "route (m)", "blocks"}};
  for (std::size_t i = 0; i < card.places.size(); ++i) {
    const PlaceCard& place = card.places[i];
    const std::string same = same_place(card, i);
    grid.push_back(
        {place.name, same.empty() ? "-" : same,
         concat(fixed(place.centre_world_m.x(), 0), ", ", fixed(place.centre_world_m.y(), 0)),
         std::to_string(place.drives.size()), fixed(place.labelled_route_m, 0),
         std::to_string(place.block_count)});
  }
  text += aligned(grid) + "\n" + places_text(card) + "; ";
  text += concat(model.forest.trees.size(), " trees, ", model.forest.labels.size(),
                 " training rows, features: ", card.feature_set, "; ", folds_text(card),
                 (card.knows_history ? "; with earlier drives\n" : "; map only\n"));
  return text;
}

std::string recordings_text(const ErrorModel& model) {
  const Table table = recordings_table(model);
  TextGrid grid = {table.columns};
  for (const std::vector<Cell>& row : table.rows) {
    std::vector<std::string> line;
    for (const Cell& cell : row) line.push_back(std::get<std::string>(cell));
    grid.push_back(std::move(line));
  }
  return "Recordings that it was trained on\n" + aligned(grid);
}

// "50 m"; looks that take a sample by their number, since their texts are long.
std::string told_name(std::size_t number, const ErrorModel& model) {
  const Look& look = model.out_of_fold.looks[number];
  return takes_every_return(look) ? to_text(look) : concat("look ", number + 1);
}

std::string fit_text(const ErrorModel& model) {
  TextGrid grid = {{"look"}, {"measured error (cm)"}, {"R^2"}, {"RMSE (cm)"}};
  if (model.card.knows_history) {
    grid.push_back({"R^2, with history"});
    grid.push_back({"RMSE, with history (cm)"});
  }
  for (std::size_t number = 0; number < model.ranges.size(); ++number) {
    const RangeCard& range = model.ranges[number];
    const std::string column[] = {
        told_name(number, model),          fixed(100.0 * range.mean_error_m, 1),
        fixed(range.r_squared, 2),         fixed(100.0 * range.rmse_m, 1),
        fixed(range.history_r_squared, 2), fixed(100.0 * range.history_rmse_m, 1)};
    for (std::size_t i = 0; i < grid.size(); ++i) grid[i].push_back(column[i]);
  }
  return "Prediction of the mean error, cross-validated\n" + aligned(grid);
}

// Of the model within, where there is one.
std::string looks_text(const ErrorModel& model) {
  std::string text = "\nLooks that take a sample\n";
  for (std::size_t i = 0; i < model.out_of_fold.looks.size(); ++i) {
    text += concat("look ", i + 1, ": ", to_text(model.out_of_fold.looks[i]), "\n");
  }
  return text + fit_text(model);
}

std::string kind_text(const ErrorModel& model) {
  TextGrid grid = {{"limit (cm)"}, {"kind"},           {"cases"},
                   {"coverage %"}, {"mean range (m)"}, {"mean error (cm)"}};
  for (const KindCard& card : model.kinds) {
    const std::string column[] = {
        fixed(100.0 * card.limit_m, 0),  std::string(name_of(card.kind)),
        std::to_string(card.case_count), fixed(100.0 * card.coverage, 1),
        fixed(card.mean_range_m, 1),     fixed(100.0 * card.mean_error_m, 1)};
    for (std::size_t i = 0; i < grid.size(); ++i) grid[i].push_back(column[i]);
  }
  return "The mean rule by kind of place, cross-validated\n" + aligned(grid);
}

std::string importance_text(const ErrorModel& model) {
  std::vector<const FeatureCard*> order;
  for (const FeatureCard& feature : model.features) order.push_back(&feature);
  std::ranges::stable_sort(order, std::greater(), &FeatureCard::importance_m);
  TextGrid grid;
  for (const FeatureCard* feature : order) {
    grid.push_back({feature->name, fixed(100.0 * feature->importance_m, 2)});
  }
  return "Importance: by how much the RMSE rises when a feature is shuffled (cm)\n" + aligned(grid);
}

}  // namespace

Table recordings_table(const ErrorModel& model) {
  Table table{"error-model-recordings", {"place", "role", "name", "sha256"}, {}, {}};
  for (const PlaceCard& place : model.card.places) {
    for (const RecordingCard& card : place.recordings.cards) {
      table.rows.push_back({place.name, card.role, card.name, to_hex(card.digest)});
    }
  }
  return table;
}

Table dump(const ErrorModel& model) {
  Table table = dump(model.out_of_fold);
  table.name = "error-model";
  table.facts = card_facts(model, model.forest.labels.size()).facts;
  table.columns.insert(table.columns.begin() + 1, {"place", "drive", "run", "s_m", "block",
                                                   "has_history", "measured_mean_error_m"});
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const TrainedSite& site = model.sites[model.shape().site_of(i)];
    const Cell measured =
        site.has_label == 1 ? Cell(model.measured_mean_m[i]) : Cell(std::string());
    const PlaceCard& place = model.card.places[site.place];
    table.rows[i].insert(table.rows[i].begin() + 1,
                         {place.name, place.drives[site.drive], std::int64_t{site.run}, site.s_m,
                          std::int64_t{site.block}, std::int64_t{site.has_history}, measured});
  }
  return table;
}

std::vector<Table> tables(const ErrorModel& model) {
  return {table_of("error-model-ranges", model.ranges),
          features_table(model),
          nodes_table(model),
          leaves_table(model),
          table_of("error-model-kinds", model.kinds),
          recordings_table(model)};
}

Table dump(const ByFamily<ErrorModel>& model) { return dump(model.ranges); }

std::string to_text(const ByFamily<ErrorModel>& model) {
  const ErrorModel& ranges = model.ranges;
  return concat(card_text(ranges), "\n", recordings_text(ranges), "\n", fit_text(ranges), "\n",
                (ranges.kinds.empty() ? "" : kind_text(ranges) + "\n"), importance_text(ranges),
                (model.samples ? looks_text(*model.samples) : ""));
}

}  // namespace sightline
