#include "tests/golden/towns.h"

#include "compiler/base/atomic_file.h"
#include "examples/town/write_town.h"

namespace sightline::golden {
namespace {

struct GoldenTown {
  std::string name;
  int beams = 16;
  int drives = 0;  // beside the one that maps
};

const std::vector<GoldenTown> kTowns = {{"town16", 16, 1}, {"town64", 64, 0}};

town::WriteTownOptions options_of(const GoldenTown& golden, const std::filesystem::path& folder) {
  town::WriteTownOptions options;
  options.town.seed = 3;
  options.town.length_m = 60.0;
  options.out = folder / golden.name;
  options.drives = golden.drives;
  options.beams = golden.beams;
  options.replaces = true;
  return options;
}

}  // namespace

std::vector<std::string> town_names() {
  std::vector<std::string> names;
  for (const GoldenTown& town : kTowns) names.push_back(town.name);
  return names;
}

Result<void> write_towns(const std::filesystem::path& configs,
                         const std::filesystem::path& folder) {
  for (const GoldenTown& golden : kTowns) {
    const Result<void> written = town::write_town(options_of(golden, folder));
    if (!written) return written;
    const Result<std::string> config = read_text_file(configs / (golden.name + ".yaml"));
    if (!config) return config.error();
    const Result<void> copied =
        write_file_atomically(folder / golden.name / "town.yaml", *config, IfExists::kReplace);
    if (!copied) return copied;
  }
  return {};
}

}  // namespace sightline::golden
