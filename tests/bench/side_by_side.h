#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace sightline {

// One job done by us and by a peer, in turn and in one process, so that a busy machine slows both.
// Prints the medians of the CPU time of the process and their ratio (how many times we are faster).
struct SideBySide {
  std::string job;
  std::size_t items = 0;  // what a rate counts: points
  int rounds = 7;
  std::function<void()> ours;
  std::function<void()> peers;
};
void compare(const SideBySide& work);
void print_heading(const std::string& title);

}  // namespace sightline
