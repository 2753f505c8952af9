// Every artifact of two small towns against the texts kept beside this file.
// usage: golden_test --write-towns FOLDER            makes the towns
//        golden_test --towns FOLDER [--update] [--threads N] [--kernel NAME] [--embree-isa NAME]
// --update rewrites the texts. The flags after it change how the compile computes, never what.

#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <map>
#include <string>

#include "compiler/base/atomic_file.h"
#include "passes/matching/kernel_score.h"
#include "tests/golden/compare.h"
#include "tests/golden/step_outputs.h"
#include "tests/golden/towns.h"

namespace sightline::golden {
namespace {

namespace fs = std::filesystem;

struct Flags {
  fs::path write_towns;
  fs::path towns;
  bool updates = false;
  int threads = 0;
};
Flags flags;  // of the command line

fs::path golden_folder(const std::string& run) { return fs::path(SIGHTLINE_GOLDEN_FOLDER) / run; }

GoldenFiles kept_files(const fs::path& folder) {
  GoldenFiles files;
  if (!fs::exists(folder)) return files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const Result<std::string> text = read_text_file(entry.path());
    EXPECT_TRUE(text.has_value()) << entry.path();
    if (text) files[entry.path().filename().string()] = *text;
  }
  return files;
}

void rewrite(const RunOutput& run) {
  const fs::path folder = golden_folder(run.name);
  fs::remove_all(folder);
  for (const auto& [name, text] : golden_files(run)) {
    const Result<void> written = write_file_atomically(folder / name, text, IfExists::kReplace);
    EXPECT_TRUE(written.has_value()) << folder / name;
  }
}

class Golden : public testing::TestWithParam<std::string> {};

TEST_P(Golden, EveryArtifactIsAsItWas) {
  const Result<std::vector<RunOutput>> runs =
      run_town(GetParam(), flags.towns / GetParam() / "town.yaml", flags.threads);
  ASSERT_TRUE(runs.has_value()) << to_string(runs.error());
  for (const RunOutput& run : *runs) {
    const std::string differences = compare(run, kept_files(golden_folder(run.name)));
    if (!flags.updates) {
      EXPECT_TRUE(differences.empty()) << run.name << "\n" << differences;
    } else if (!differences.empty()) {
      rewrite(run);
      std::printf("%s\n%s", run.name.c_str(), differences.c_str());
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Towns, Golden, testing::ValuesIn(town_names()),
                         [](const auto& town) { return town.param; });

int write_towns_to(const fs::path& folder) {
  const Result<void> written = write_towns(SIGHTLINE_GOLDEN_FOLDER, folder);
  if (written) return 0;
  std::fprintf(stderr, "%s\n", to_string(written.error()).c_str());
  return 1;
}

bool choose_kernel(const std::string& name) {
  const std::map<std::string, MatchKernel> kernels = {{"portable", MatchKernel::kPortable},
                                                      {"avx2", MatchKernel::kAvx2},
                                                      {"avx512", MatchKernel::kAvx512}};
  if (!kernels.contains(name) || !is_supported(kernels.at(name))) return false;
  replace_fastest_kernel(kernels.at(name));
  return true;
}

// What GoogleTest left of the command line.
bool read_flags(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string flag = argv[i];
    if (flag == "--update") {
      flags.updates = true;
      continue;
    }
    if (++i == argc) return false;
    const std::string value = argv[i];
    if (flag == "--write-towns") {
      flags.write_towns = value;
    } else if (flag == "--towns") {
      flags.towns = value;
    } else if (flag == "--threads") {
      flags.threads = std::stoi(value);
    } else if (flag != "--kernel" || !choose_kernel(value)) {
      return false;
    }
  }
  return true;
}

}  // namespace
}  // namespace sightline::golden

int main(int argc, char** argv) {
  using namespace sightline::golden;
  testing::InitGoogleTest(&argc, argv);
  if (!read_flags(argc, argv)) {
    std::fprintf(stderr, "golden_test: a flag that it does not know, or a value is wrong\n");
    return 64;
  }
  if (!flags.write_towns.empty()) return write_towns_to(flags.write_towns);
  return RUN_ALL_TESTS();
}
