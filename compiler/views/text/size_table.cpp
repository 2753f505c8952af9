#include "compiler/views/text/size_table.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <string_view>
#include <utility>
#include <vector>

namespace sightline {
namespace {

struct Part {
  std::string name;
  std::uint64_t bytes = 0;
};

constexpr std::string_view kFrame = "header, gaps";

// Begins with: a map without it.
std::string_view lost_without(std::string_view name) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 10> kParts = {
      {{"ndt", "cannot be matched with"},
       {"range", "has no answers"},
       {"contents", "is as good, but slower to open (derived)"},
       {"look-up", "is as good, but slower to open (derived)"},
       {"factors", "explains no prediction"},
       {"look-factors", "explains no prediction"},
       {"factor-names", "explains no prediction"},
       {"look-factor-names", "explains no prediction"},
       {"drives", "does not name the drives of a tile"},
       {"error-model", "cannot predict the errors of other places"}}};
  const auto found = std::ranges::find(kParts, name, &decltype(kParts)::value_type::first);
  if (found != kParts.end()) return found->second;
  if (name.starts_with("column.")) return "lacks this figure at each place";
  if (name == "manifest" || name == "directory" || name == kFrame) return "cannot be read";
  return "lacks a part of another version";
}

std::vector<Part> parts_of(const MapSummary& summary) {
  std::vector<Part> parts = {{"manifest", summary.manifest_size},
                             {"directory", summary.directory_size}};
  for (const MapSummary::Blocks& blocks : summary.blocks) {
    parts.push_back({blocks.name, blocks.stored_size});
  }
  std::uint64_t rest = summary.file_size;
  for (const Part& part : parts) rest -= part.bytes;
  parts.push_back({std::string(kFrame), rest});
  std::ranges::stable_sort(parts, std::ranges::greater{}, &Part::bytes);
  return parts;
}

bool is_stripped(std::string_view name) {
  return name == "error-model" || name.find("factor") != std::string_view::npos;
}

}  // namespace

std::string size_table(const MapSummary& summary, double route_m) {
  const double route_km = route_m > 0.0 ? route_m / 1000.0 : 1.0;
  const auto per_km = [&](std::uint64_t bytes) { return static_cast<double>(bytes) / route_km; };
  std::string text =
      fmt::format("{} bytes{}\n{:<28} {:>12} {:>7}  a map without it\n", summary.file_size,
                  route_m > 0.0 ? fmt::format(", {:.0f} for each km of {:.3f} km of route",
                                              per_km(summary.file_size), route_km)
                                : "",
                  "part", route_m > 0.0 ? "bytes/km" : "bytes", "share");
  std::uint64_t stripped = 0;
  for (const Part& part : parts_of(summary)) {
    const double share = static_cast<double>(part.bytes) / static_cast<double>(summary.file_size);
    text += fmt::format("{:<28} {:>12.0f} {:>5.1f} %  {}\n", part.name, per_km(part.bytes),
                        100.0 * share, lost_without(part.name));
    if (is_stripped(part.name)) stripped += part.bytes;
  }
  if (stripped == 0) return text;
  return text + fmt::format(
                    "`sightline strip` leaves out model and factors: about {:.0f} bytes{} "
                    "remain.\n",
                    per_km(summary.file_size - stripped), route_m > 0.0 ? "/km" : "");
}

}  // namespace sightline
