#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/evaluation/evaluation_scores.h"
#include "formats/text/table.h"

// The numbers of an evaluation's rows, told once for checking, printing and encoding.

namespace sightline {

// Names and places of the numbers of a row, in the order of dump and encoding.
template <class Row>
struct NumberField {
  const char* name;
  double Row::*value;
};
inline constexpr NumberField<StaticScore> kStaticFields[] = {
    {"range_m", &StaticScore::range_m},
    {"mean_error_m", &StaticScore::mean_error_m},
    {"mean_time_ms", &StaticScore::mean_time_ms},
    {"max_site_time_ms", &StaticScore::max_site_time_ms},
    {"max_run_time_ms", &StaticScore::max_run_time_ms},
    {"mean_work", &StaticScore::mean_work},
    {"r_squared", &StaticScore::r_squared},
    {"rmse_m", &StaticScore::rmse_m}};
inline constexpr NumberField<RuleScore> kRuleFields[] = {
    {"limit_m", &RuleScore::limit_m},
    {"coverage", &RuleScore::coverage},
    {"mean_error_m", &RuleScore::mean_error_m},
    {"p95_error_m", &RuleScore::p95_error_m},
    {"mean_range_m", &RuleScore::mean_range_m},
    {"time_ratio", &RuleScore::time_ratio},
    {"work_ratio", &RuleScore::work_ratio},
    {"mean_time_ms", &RuleScore::mean_time_ms},
    {"max_site_time_ms", &RuleScore::max_site_time_ms},
    {"max_run_time_ms", &RuleScore::max_run_time_ms},
    {"unmet_share", &RuleScore::unmet_share},
    {"extrapolated_share", &RuleScore::extrapolated_share},
    {"worst_coverage", &RuleScore::worst_coverage}};
inline constexpr NumberField<JudgedSite> kSiteFields[] = {{"s_m", &JudgedSite::s_m},
                                                          {"p_x_m", &JudgedSite::p_x_map_m},
                                                          {"p_y_m", &JudgedSite::p_y_map_m}};
inline constexpr NumberField<StreetScore> kStreetFields[] = {
    {"limit_m", &StreetScore::limit_m},         {"site_share", &StreetScore::site_share},
    {"coverage", &StreetScore::coverage},       {"mean_error_m", &StreetScore::mean_error_m},
    {"p95_error_m", &StreetScore::p95_error_m}, {"mean_range_m", &StreetScore::mean_range_m},
    {"time_ratio", &StreetScore::time_ratio},   {"work_ratio", &StreetScore::work_ratio}};
inline constexpr NumberField<ReliabilityBin> kBinFields[] = {
    {"limit_m", &ReliabilityBin::limit_m},
    {"promised", &ReliabilityBin::promised},
    {"observed", &ReliabilityBin::observed}};

template <class Row, std::size_t kCount>
bool is_finite(const NumberField<Row> (&fields)[kCount], const Row& row) {
  return std::all_of(std::begin(fields), std::end(fields), [&](const NumberField<Row>& field) {
    return std::isfinite(row.*field.value);
  });
}

template <class Row, std::size_t kCount>
void append_names(const NumberField<Row> (&fields)[kCount], std::vector<std::string>& columns) {
  for (const NumberField<Row>& field : fields) columns.emplace_back(field.name);
}

template <class Row, std::size_t kCount>
void append_cells(const NumberField<Row> (&fields)[kCount], const Row& row,
                  std::vector<Cell>& cells) {
  for (const NumberField<Row>& field : fields) cells.emplace_back(row.*field.value);
}

template <class Row, std::size_t kCount>
void put_numbers(const NumberField<Row> (&fields)[kCount], const Row& row, ByteWriter& writer) {
  for (const NumberField<Row>& field : fields) writer.put(row.*field.value);
}

template <class Row, std::size_t kCount>
void get_numbers(const NumberField<Row> (&fields)[kCount], ByteReader& reader, Row& row) {
  for (const NumberField<Row>& field : fields) reader.get(row.*field.value);
}

}  // namespace sightline
