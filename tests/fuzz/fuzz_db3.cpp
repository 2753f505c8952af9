#include "tests/fuzz/bag_checks.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  sightline::check_bag(std::as_bytes(std::span(data, size)), /*may_miss=*/true);
  return 0;
}
