// A recording of ROS 2 as MCAP: its topics, its poses and every scan of it.

#include "tests/fuzz/bag_checks.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  sightline::check_bag(std::as_bytes(std::span(data, size)));
  return 0;
}
