#include "tests/system/program.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <string_view>

#include "formats/base/files/atomic_file.h"

#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

constexpr std::string_view kConfig = R"(
annotation: {ranges_m: [10, 30], split: auto}
mapping: {scans: mapping/scans, poses: mapping/poses.tum}
localization: {scans: drive_1/scans, poses: drive_1/poses.tum}
measure-error: {offset_count: 3, reference: known}
train-model: {trees: 20}
)";
constexpr std::string_view kEvaluation =
    "evaluation: {scans: drive_2/scans, poses: drive_2/poses.tum}\n";

struct Scratch {
  Scratch() { std::filesystem::create_directories(scratch_folder()); }
  ~Scratch() { std::filesystem::remove_all(scratch_folder()); }
};

}  // namespace

ProgramResult run_command(const std::string& command) {
  static const Scratch kOwner;
  const std::filesystem::path out = scratch_folder() / "stdout";
  const std::filesystem::path err = scratch_folder() / "stderr";
  const std::string redirected =
      "{ " + command + "; } >'" + out.string() + "' 2>'" + err.string() + "' </dev/null";
  const int status = std::system(redirected.c_str());
  ProgramResult result;
  result.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  result.out = *read_text_file(out);
  result.err = *read_text_file(err);
  return result;
}

ProgramResult run_sightline(const std::string& arguments) {
  return run_command(std::string(SIGHTLINE_PROGRAM) + " " + arguments);
}

ProgramResult run_successfully(const std::string& arguments) {
  const ProgramResult run = run_sightline(arguments);
  EXPECT_EQ(run.status, 0) << arguments << "\n" << run.err;
  return run;
}

void make_town(const std::filesystem::path& folder, const std::string& options) {
  const ProgramResult made =
      run_command(std::string(SIGHTLINE_TOWN) + " " + options + " --output " + folder.string());
  EXPECT_EQ(made.status, 0) << made.err;
  EXPECT_TRUE(write_file_atomically(folder / "town.yaml", kConfig, IfExists::kReplace));
}

const std::filesystem::path& small_town() {
  static const std::filesystem::path kTown = [] {
    const std::filesystem::path town = scratch_folder() / "town";
    make_town(town, "--seed 3 --length-m 100");
    EXPECT_TRUE(write_file_atomically(town / "town.yaml", std::string(kConfig).append(kEvaluation),
                                      IfExists::kReplace));
    return town;
  }();
  return kTown;
}

std::string bytes_of(const std::filesystem::path& path) { return value_of(read_text_file(path)); }

std::filesystem::path fresh_folder() {
  const ::testing::TestInfo* test = ::testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path folder =
      scratch_folder() / (std::string(test->test_suite_name()) + "." + test->name());
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

const std::filesystem::path& compiled_town() {
  static const std::filesystem::path kTown = [] {
    const std::filesystem::path town = scratch_folder() / "street";
    make_town(town, "--seed 3 --length-m 90 --drives 1 --origin-m 456500,5429500");
    run_successfully("compile " + (town / "town.yaml").string() + " -q -o " +
                     (town / "town.slmap").string());
    return town;
  }();
  return kTown;
}

std::string map_file() { return (compiled_town() / "town.slmap").string(); }
std::string config_file() { return (compiled_town() / "town.yaml").string(); }

void export_to(const std::filesystem::path& output, const std::string& source,
               const std::string& options) {
  run_successfully("export " + source + " -q -o '" + output.string() + "' " + options);
}

}  // namespace sightline
