#pragma once

#include <string>
#include <string_view>

#include "compiler/cli/verb.h"
#include "formats/base/result.h"
#include "passes/weakness/weak_stretches.h"

namespace sightline {

// What `export` writes of answers of the vehicle's reader, at places that are not the map's sites.
struct ExportAnswersFlags {
  std::string output;
  bool is_forced = false;
  std::string world;                                       // --world
  std::string lanes;                                       // --lanes: a Lanelet2 map
  double area_limit_m = 0.0;                               // --area-limit; 0: the widest of the map
  double weak_margin = WeakStretchOptions().least_margin;  // --weak-margin
  double cell_m = 2.0;                                     // --cell
};

// --lanes, --area-limit, --weak-margin, --cell; `flags` outlives the verb.
void add_answers_flags(Verb& verb, ExportAnswersFlags& flags);

// A paragraph for the help of `export`.
extern const std::string_view kLanelet2Details;

// Whether export_answers() writes a format: lanelet2 and cells.
bool asks_the_reader(std::string_view format);

// Errors: those of to_lanelet2() and answers_by_cell(), of reading the map and the lanes, and of
// write_file_atomically(); bad-argument (lanelet2 without --lanes).
Result<void> export_answers(std::string_view format, const std::string& map_file,
                            const ExportAnswersFlags& flags);

}  // namespace sightline
