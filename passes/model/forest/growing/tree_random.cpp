#include "passes/model/forest/growing/tree_random.h"

#include <limits>
#include <string>

namespace sightline {
namespace {

// dlib lets this many numbers pass after seeding.
constexpr unsigned long long kDiscarded = 10'000;

std::uint32_t engine_seed(const std::string& text) {
  std::uint32_t seed = 0;
  for (const char c : text) seed = seed * 37 + static_cast<std::uint32_t>(c);
  return seed;
}

std::uint64_t draw_64_bits(std::mt19937& engine) {
  const std::uint64_t high = engine();
  return high << 32 | engine();
}

}  // namespace

TreeRandom::TreeRandom(std::uint64_t seed) : engine_(engine_seed(std::to_string(seed) + "/0")) {
  engine_.discard(kDiscarded);
}

std::size_t TreeRandom::in_range(std::size_t begin, std::size_t end) {
  if (begin == end) return begin;
  const std::uint64_t size = end - begin;
  // Numbers of the last, incomplete run of `size` numbers are rejected: the first ones would be
  // likelier.
  const std::uint64_t limit = std::numeric_limits<std::uint64_t>::max() / size * size;
  std::uint64_t number = draw_64_bits(engine_);
  while (number >= limit) number = draw_64_bits(engine_);
  return begin + number % size;
}

}  // namespace sightline
