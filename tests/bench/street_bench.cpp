#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "formats/base/files/atomic_file.h"
#include "passes/model/forest/same_street.h"

// Which maps of drives are called one street. The maps have axes of their own.
// usage: street_bench FACTORS.csv...   (`sightline dump CONFIG --what map-factors --format csv`)
// Files are of one street whose names are equal up to the last "-".

namespace sightline {
namespace {

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts = {""};
  for (const char c : text) {
    if (c == at) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

void add_row(const std::vector<std::string>& cells, DrivenPlace& place) {
  const auto site = static_cast<std::size_t>(std::stoul(cells[0]));
  if (site >= place.sites.sites.size()) place.sites.sites.resize(site + 1);
  if (site == 0) place.factors.looks.push_back(Look{.range_m = std::stod(cells[1])});
  for (std::size_t i = 2; i < cells.size(); ++i) {
    place.factors.values.push_back(std::stod(cells[i]));
  }
}

DrivenPlace read_place(const std::string& file) {
  DrivenPlace place;
  place.name = file.substr(0, file.rfind('-'));
  const Result<std::vector<std::byte>> bytes = read_file(file);
  if (!bytes) return place;
  const std::string text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  for (const std::string& line : split(text, '\n')) {
    if (line.empty() || line.front() == '#') continue;
    const std::vector<std::string> cells = split(line, ',');
    if (place.factors.factors.empty()) {
      place.factors.factors.assign(cells.begin() + 2, cells.end());
    } else {
      add_row(cells, place);
    }
  }
  place.factors.site_count = static_cast<std::uint32_t>(place.sites.sites.size());
  return place;
}

struct Pairs {
  int count = 0, called_one = 0;
  double least = 1.0, greatest = 0.0;
};

void print(const char* what, const Pairs& pairs) {
  std::printf("%s: %d of %d pairs called one street; likeness %.3f to %.3f\n", what,
              pairs.called_one, pairs.count, pairs.least, pairs.greatest);
}

}  // namespace
}  // namespace sightline

int main(int argc, char** argv) {
  using namespace sightline;
  std::vector<DrivenPlace> places;
  for (int i = 1; i < argc; ++i) places.push_back(read_place(argv[i]));
  std::map<bool, Pairs> pairs;
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const bool is_one = places[i].name == places[j].name;
      const double likeness = street_likeness(places[i], places[j]);
      Pairs& of_kind = pairs[is_one];
      ++of_kind.count;
      of_kind.called_one += likeness >= kOneStreet ? 1 : 0;
      of_kind.least = std::min(of_kind.least, likeness);
      of_kind.greatest = std::max(of_kind.greatest, likeness);
      if (is_one == (likeness >= kOneStreet)) continue;
      std::printf("%s %s and %s: %.3f\n", is_one ? "missed" : "wrong", argv[j + 1], argv[i + 1],
                  likeness);
    }
  }
  print("drives of one street", pairs[true]);
  print("different streets", pairs[false]);
}
