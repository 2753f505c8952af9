#include "tests/system/exported_town.h"

#include <gtest/gtest.h>

#include "formats/base/files/atomic_file.h"
#include "tests/support/scratch_folder.h"
#include "tests/system/program.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr const char* kConfig = R"(
annotation: {ranges_m: [10, 30], split: auto}
mapping: {scans: mapping/scans, poses: mapping/poses.tum}
localization: {scans: drive_1/scans, poses: drive_1/poses.tum}
measure-error: {offset_count: 3, reference: known}
train-model: {trees: 20}
)";

}  // namespace

const fs::path& compiled_town() {
  static const fs::path kTown = [] {
    const fs::path town = scratch_folder() / "street";
    const ProgramResult made =
        run_command(std::string(SIGHTLINE_TOWN) + " --seed 3 --length-m 90 --drives 1 --origin-m " +
                    "456500,5429500 --output " + town.string());
    EXPECT_EQ(made.status, 0) << made.err;
    EXPECT_TRUE(write_file_atomically(town / "town.yaml", kConfig, IfExists::kReplace));
    const ProgramResult compiled = run_sightline("compile " + (town / "town.yaml").string() +
                                                 " -q -o " + (town / "town.slmap").string());
    EXPECT_EQ(compiled.status, 0) << compiled.err;
    return town;
  }();
  return kTown;
}

std::string map_file() { return (compiled_town() / "town.slmap").string(); }
std::string config_file() { return (compiled_town() / "town.yaml").string(); }

void export_to(const fs::path& output, const std::string& source, const std::string& options) {
  const ProgramResult run =
      run_sightline("export " + source + " -q -o '" + output.string() + "' " + options);
  ASSERT_EQ(run.status, 0) << run.err;
}

}  // namespace sightline
