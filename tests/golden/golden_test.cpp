// Every artifact of two small towns against the texts kept beside this file.
// usage: golden_test --write-towns FOLDER            makes the towns
//        golden_test --towns FOLDER [--update] [--threads N] [--kernel NAME] [--embree sse2]
//                    [--other-libm]
// --update rewrites the texts. The flags after it change how a compile computes, never what it
// gives;
// --other-libm fails where the C library computes as it did when the towns were made.

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "formats/base/files/atomic_file.h"
#include "formats/base/hash.h"
#include "passes/matching/kernel_score.h"
#include "passes/rays/surface_caster.h"
#include "tests/golden/compare.h"
#include "tests/golden/step_outputs.h"
#include "tests/golden/towns.h"
#include "tests/support/value_of.h"

namespace sightline::golden {
namespace {

namespace fs = std::filesystem;

// SHA-256 of what the C library makes of some thousand numbers: it has several variants of its
// functions, of which the processor and GLIBC_TUNABLES choose one, and their last bits differ.
std::string libm_digest() {
  std::vector<double> values;
  for (int i = 1; i <= 5000; ++i) {
    const double x = 0.01 * i + 1e-7 * i * i;
    values.insert(values.end(), {std::sin(x), std::cos(x), std::exp(-x), std::log(x),
                                 std::atan2(x, 3.0), std::pow(x, 1.7)});
  }
  return to_hex(sha256(std::as_bytes(std::span(values))));
}

struct Flags {
  fs::path write_towns;
  fs::path towns;
  bool updates = false;
  int threads = 0;
  bool has_other_libm = false;
};
Flags flags;  // of the command line

const fs::path kGoldenFolder = SIGHTLINE_GOLDEN_FOLDER;

GoldenFiles kept_files(const std::string& town) {
  GoldenFiles files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kGoldenFolder)) {
    const std::string name = fs::relative(entry.path(), kGoldenFolder).string();
    if (!entry.is_regular_file() || !name.starts_with(town) || !name.ends_with(".txt")) continue;
    files[name] = value_of(read_text_file(entry.path()));
  }
  return files;
}

void rewrite(const GoldenFiles& kept, const GoldenFiles& made) {
  for (const auto& [name, text] : kept) fs::remove(kGoldenFolder / name);
  for (const auto& [name, text] : made) {
    EXPECT_TRUE(write_file_atomically(kGoldenFolder / name, text, IfExists::kReplace).has_value())
        << name;
  }
}

class Golden : public testing::TestWithParam<std::string> {};

TEST_P(Golden, EveryArtifactIsAsItWas) {
  const std::string& town = GetParam();
  const std::vector<RunOutput> runs =
      value_of(run_town(town, flags.towns / town / "town.yaml", flags.threads));
  const GoldenFiles kept = kept_files(town);
  const std::string differences = compare(runs, kept);
  if (!flags.updates) {
    EXPECT_TRUE(differences.empty()) << differences;
  } else if (!differences.empty()) {
    rewrite(kept, golden_files(runs));
    std::printf("%s", differences.c_str());
  }
}

// Or a run with --other-libm would show nothing.
TEST(GoldenVariant, OfTheCLibraryIsOne) {
  if (!flags.has_other_libm) GTEST_SKIP() << "the C library's usual variant";
  if (!__builtin_cpu_supports("fma")) GTEST_SKIP() << "this processor has one variant only";
  EXPECT_NE(value_of(read_text_file(flags.towns / "libm.txt")), libm_digest());
}

INSTANTIATE_TEST_SUITE_P(Towns, Golden, testing::ValuesIn(town_names()),
                         [](const auto& town) { return town.param; });

int write_towns_to(const fs::path& folder) {
  Result<void> written = write_towns(kGoldenFolder, folder);
  if (written) {
    written = write_file_atomically(folder / "libm.txt", libm_digest(), IfExists::kReplace);
  }
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

bool choose_instruction_set(const std::string& name) {
  if (name != "sse2") return false;
  replace_caster_isa(CasterIsa::kSse2);
  return true;
}

bool read_flag(const std::string& flag, const std::string& value) {
  if (flag == "--write-towns") flags.write_towns = value;
  if (flag == "--towns") flags.towns = value;
  if (flag == "--threads") flags.threads = std::stoi(value);
  if (flag == "--kernel") return choose_kernel(value);
  if (flag == "--embree") return choose_instruction_set(value);
  return flag == "--write-towns" || flag == "--towns" || flag == "--threads";
}

bool read_flags(const std::vector<std::string>& arguments) {
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i] == "--update") {
      flags.updates = true;
    } else if (arguments[i] == "--other-libm") {
      flags.has_other_libm = true;
    } else {
      const bool has_value = i + 1 < arguments.size();
      if (!has_value || !read_flag(arguments[i], arguments[i + 1])) return false;
      ++i;
    }
  }
  return true;
}

}  // namespace
}  // namespace sightline::golden

int main(int argc, char** argv) {
  using namespace sightline::golden;
  testing::InitGoogleTest(&argc, argv);
  if (!read_flags({argv + 1, argv + argc})) {
    std::fprintf(stderr, "golden_test: a flag that it does not know, or a value is wrong\n");
    return 64;
  }
  if (!flags.write_towns.empty()) return write_towns_to(flags.write_towns);
  // As many as were asked for, on a machine with fewer processors too.
  const oneapi::tbb::global_control workers(
      oneapi::tbb::global_control::max_allowed_parallelism,
      static_cast<std::size_t>(std::max(flags.threads, oneapi::tbb::info::default_concurrency())));
  return RUN_ALL_TESTS();
}
