#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "compiler/pipeline/runner.h"

namespace sightline {

// How long a run will still take: its step by the share that is done, later steps by what is
// expected of them, corrected by how far off that was so far. Not safe for several threads.
class RemainingTime {
 public:
  // What each step of the run is expected to take, in running order; empty: not known.
  explicit RemainingTime(std::vector<double> expected_s) : expected_s_(std::move(expected_s)) {}

  void start(std::size_t step) { step_ = step; }
  void finish(const StepReport& report);

  // Of the present step, of which `done` above 0 are counted after elapsed_s: at the same speed. As
  // long as expected where the count says less than a third of that: then work follows that is not
  // counted. 0 when all is done.
  [[nodiscard]] double of_step_s(double elapsed_s, std::size_t done, std::size_t total) const;
  // Of the whole run, whose present step has taken elapsed_s and takes step_left_s more; nothing
  // where that is not known.
  [[nodiscard]] std::optional<double> of_run_s(double step_left_s, double elapsed_s = 0.0) const;

 private:
  // Measured over expected time of the steps that ran.
  [[nodiscard]] double slowness() const;

  std::vector<double> expected_s_;
  std::size_t step_ = 0;
  double taken_s_ = 0.0;     // by the steps that ran
  double foreseen_s_ = 0.0;  // of these
};

// Of a step that has done this share in this time, at the same speed; `done` above 0.
double seconds_left(double elapsed_s, std::size_t done, std::size_t total);

// "1:05", "2:03:00"
std::string clock_text(double seconds);

}  // namespace sightline
