#pragma once

#include <filesystem>
#include <string>

#include "compiler/config/compile_config.h"
#include "compiler/driver/plans.h"
#include "formats/base/result.h"

// Which error model a compile uses.

namespace sightline {

struct ChosenModel {
  std::filesystem::path file;  // empty: it is trained on the drives of this compile
  std::string why_own;         // why it is, though the configuration names the generated one

  [[nodiscard]] ModelSource source() const {
    return file.empty() ? ModelSource::kTrained : ModelSource::kGiven;
  }
};

// The model that comes with the program: below ../share of the folder of `program`.
std::filesystem::path shipped_model(const std::filesystem::path& program);
// That of the running program.
std::filesystem::path shipped_model();

// `given`, where it is not empty; else by annotation.model. The model that comes with the program
// is used where drives make the map and ranges, looks, limits and localizer are those that it
// knows. Errors: file-not-found where it is missing, those of read_model.
Result<ChosenModel> choose_model(const CompileConfig& config, const std::filesystem::path& given,
                                 const std::filesystem::path& shipped = shipped_model());

}  // namespace sightline
