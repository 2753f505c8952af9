// Protection levels from matches of tracking starts: files of integrity_bench --tracking-starts
// --samples. With --fit: the rows of formats/reader/protection_table.cpp. Else the table is judged,
// one row a kind of world and axis:
//   exceeding    blocks of 60 m in which an error exceeds the level of risk 1e-2
//   level        median, m or degrees; q99: 99 % quantile of |error|; ratio: one over the other
// and one line a kind: matches with a doubtful integrity, alarms of the monitor by km.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>

#include "passes/matching/covariance/protection.h"
#include "tests/bench/integrity/protection_samples.h"

namespace {

using namespace sightline;

void print_numbers(const char* name, const ProtectionFactors& numbers) {
  std::printf("     .%s = {", name);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (std::isfinite(numbers[i])) {
      std::printf("%s%.4g", i == 0 ? "" : ", ", numbers[i]);
    } else {
      std::printf("%skUnavailable", i == 0 ? "" : ", ");
    }
  }
  std::printf("},\n");
}

void print_fit(const std::vector<Block>& blocks) {
  for (const ProtectionRow& row : fitted_rows(blocks)) {
    std::printf("    {.place = \"%s\",\n     .block_count = %u,\n     .covariance_factor = %.3g,\n",
                std::string(row.place).c_str(), row.block_count, row.covariance_factor);
    print_numbers("percent_factors", row.percent_factors);
    print_numbers("percent_errors", row.percent_errors);
    std::printf("     .least_likelihood = %.4g,\n     .least_scored_share = %.4g,\n",
                row.least_likelihood, row.least_scored_share);
    std::printf("     .least_raised_share = %.4g},\n", row.least_raised_share);
  }
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::ranges::sort(values);
  const auto index = static_cast<std::size_t>(share * static_cast<double>(values.size()));
  return values[std::min(index, values.size() - 1)];
}

void print_axis(const std::string& kind, const std::vector<const Block*>& blocks,
                std::size_t axis) {
  constexpr const char* kNames[] = {"forward", "left", "up", "yaw"};
  const ProtectionRow& row = protection_row(group_of_world(kind));
  const double unit = axis == 3 ? 180.0 / std::numbers::pi : 1.0;
  std::vector<double> errors;
  std::vector<double> levels;
  std::size_t exceeding = 0;
  std::size_t unavailable = 0;
  for (const Block* block : blocks) {
    bool exceeds = false;
    for (const MatchSample& sample : block->samples) {
      const AxisErrors found = returned_errors(sample, row.covariance_factor);
      const double level = protection_factors(row, 0.01)[axis] * found.sigmas[axis];
      const double error = std::abs(found.errors[axis]);
      exceeds = exceeds || error > level;
      unavailable += std::isfinite(level) ? 0 : 1;
      errors.push_back(unit * error);
      levels.push_back(unit * level);
    }
    exceeding += exceeds ? 1 : 0;
  }
  const double q99 = quantile(errors, 0.99);
  const double level = quantile(levels, 0.5);
  std::printf("%-13s %-8s %6zu %9zu %6.1f | %8.4f %8.4f %6.2f | %zu\n", kind.c_str(), kNames[axis],
              blocks.size(), exceeding,
              100.0 * static_cast<double>(exceeding) / static_cast<double>(blocks.size()), level,
              q99, level / q99, unavailable);
}

Integrity integrity_of_sample(const MatchSample& sample, const ProtectionRow& row) {
  MatchResult match;
  match.nearest_voxel_likelihood = sample.likelihood;
  match.scored_points = sample.scored_points;
  return integrity_of(match, sample.point_count, row);
}

void print_alarms(const std::string& kind, const std::vector<const Block*>& blocks) {
  const ProtectionRow& row = protection_row(group_of_world(kind));
  IntegrityMonitor monitor;
  std::size_t scans = 0;
  std::size_t doubtful = 0;
  std::size_t runs = 0;
  bool was_alarm = false;
  for (const Block* block : blocks) {
    for (const MatchSample& sample : block->samples) {
      const Integrity match = integrity_of_sample(sample, row);
      const Integrity all = monitor.add(match, sample.structure.raised, row);
      const bool is_alarm = all == Integrity::kDoubtful || all == Integrity::kLost;
      ++scans;
      doubtful += match == Integrity::kDoubtful ? 1 : 0;
      runs += is_alarm && !was_alarm ? 1 : 0;
      was_alarm = is_alarm;
    }
  }
  std::printf("%-13s %zu scans, %.2f %% doubtful; %zu runs of alarms in %.2f km\n", kind.c_str(),
              scans, 100.0 * static_cast<double>(doubtful) / static_cast<double>(scans), runs,
              0.001 * static_cast<double>(scans));
}

void print_judgement(const std::vector<Block>& blocks) {
  std::map<std::string, std::vector<const Block*>> by_kind;
  for (const Block& block : blocks) by_kind[block.kind].push_back(&block);
  std::printf("%-13s %-8s %6s %9s %6s | %8s %8s %6s | %s\n", "kind", "axis", "blocks", "exceeding",
              "%", "level", "q99", "ratio", "unavailable");
  for (const auto& [kind, some] : by_kind) {
    for (std::size_t axis = 0; axis < kProtectionAxes; ++axis) print_axis(kind, some, axis);
  }
  for (const auto& [kind, some] : by_kind) print_alarms(kind, some);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> paths;
  bool is_fit = false;
  CLI::App app("Fits and judges protection levels.");
  app.add_option("samples", paths, "files of integrity_bench --samples")->required();
  app.add_flag("--fit", is_fit, "print the table's rows instead");
  CLI11_PARSE(app, argc, argv);
  std::vector<KindSample> samples;
  for (const std::string& path : paths) {
    const Result<std::vector<KindSample>> read = read_samples(path);
    if (!read) {
      std::fprintf(stderr, "%s\n", to_string(read.error()).c_str());
      return 1;
    }
    samples.insert(samples.end(), read->begin(), read->end());
  }
  const std::vector<Block> blocks = blocks_of(samples);
  is_fit ? print_fit(blocks) : print_judgement(blocks);
  return 0;
}
