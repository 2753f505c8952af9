#include "compiler/pipeline/process_cost.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

namespace sightline {
namespace {

double resident_mib() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmRSS:")) return std::stod(line.substr(6)) / 1024.0;
  }
  return 0.0;
}

std::unique_ptr<std::vector<std::byte>> block(std::size_t mib) {
  return std::make_unique<std::vector<std::byte>>(mib << 20, std::byte{1});
}

TEST(ProcessCost, PeakIsForgottenAndCpuTimeRises) {
  const double before_s = process_cpu_s();
  reset_peak_memory();
  const double before_mib = peak_memory_mib();
  block(64).reset();
  EXPECT_GE(peak_memory_mib(), before_mib + 60.0);
  EXPECT_GT(process_cpu_s(), before_s);
}

TEST(ProcessCost, LargeBlocksGoBackWhenTheyAreFreed) {
#if !defined(__GLIBC__) || defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "another allocator";
#endif
  return_freed_memory();
  block(32).reset();  // after this glibc takes blocks of up to 32 MiB from its heap, left to itself
  std::vector<std::unique_ptr<std::vector<std::byte>>> blocks;
  const double before_mib = resident_mib();
  for (int i = 0; i < 20; ++i) blocks.push_back(block(8));
  ASSERT_GE(resident_mib(), before_mib + 150.0);
  const auto on_top = std::make_unique<std::vector<std::byte>>(1000);
  blocks.clear();
  EXPECT_LE(resident_mib(), before_mib + 16.0);
}

}  // namespace
}  // namespace sightline
