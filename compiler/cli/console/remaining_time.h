#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "compiler/pipeline/runner.h"

namespace sightline {

// What a step is expected to take.
struct ExpectedTime {
  double wall_s = 0.0;
  double counted = 1.0;  // the share of it that the step's progress counts, from its beginning on
};

// How long a run will still take: its step by the share that is done and by what is expected of it,
// later steps by what is expected of them, corrected by how far off that was so far. Not safe for
// several threads.
class RemainingTime {
 public:
  // What each step of the run is expected to take, in running order; empty: not known.
  explicit RemainingTime(std::vector<ExpectedTime> expected);

  void start(std::size_t step) {
    step_ = step;
    all_counted_s_.reset();
  }
  void finish(const StepReport& report);

  // Of the present step, of which `done` above 0 are counted after elapsed_s: at first as expected,
  // then more and more at the speed so far. Where all is counted, what else the step does is left.
  [[nodiscard]] double of_step_s(double elapsed_s, std::size_t done, std::size_t total);
  // Of the whole run, whose present step has taken elapsed_s and takes step_left_s more; nothing
  // where that is not known.
  [[nodiscard]] std::optional<double> of_run_s(double step_left_s, double elapsed_s = 0.0) const;

 private:
  // Measured over expected time of the steps that ran.
  [[nodiscard]] double slowness() const;

  std::vector<ExpectedTime> expected_;
  double trust_s_ = 0.0;  // the expected speed counts as much as what so much expected time took
  std::size_t step_ = 0;
  std::optional<double> all_counted_s_;  // when the present step had counted all
  double taken_s_ = 0.0;                 // by the steps that ran
  double foreseen_s_ = 0.0;              // of these
};

// Of a step that has done this share in this time, at the same speed; `done` above 0.
double seconds_left(double elapsed_s, std::size_t done, std::size_t total);

// "1:05", "2:03:00"
std::string clock_text(double seconds);

}  // namespace sightline
