#pragma once

#include <cstdint>
#include <random>

namespace sightline {

// Random numbers of one tree, from a Mersenne twister (Matsumoto and Nishimura 1998): the same, bit
// for bit, as dlib::rand draws with the seed text "SEED/0", with which dlib grows the first tree of
// a forest.
class TreeRandom {
 public:
  explicit TreeRandom(std::uint64_t seed);

  // Each number of [begin, end) is equally likely; an empty range returns begin and draws nothing.
  std::size_t in_range(std::size_t begin, std::size_t end);

 private:
  std::mt19937 engine_;
};

}  // namespace sightline
