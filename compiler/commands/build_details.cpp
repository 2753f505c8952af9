#include "compiler/commands/build_details.h"

#include "built_with.h"
#include "commit.h"
#include "formats/model/error_model.h"
#include "formats/reader/map_layout.h"
#include "passes/matching/kernel_score.h"

namespace sightline {
namespace {

std::string kernels() {
  std::string names(kernel_name(fastest_kernel()));
  for (const MatchKernel kernel :
       {MatchKernel::kAvx512, MatchKernel::kAvx2, MatchKernel::kPortable}) {
    if (kernel == fastest_kernel() || !is_supported(kernel)) continue;
    names += ", " + std::string(kernel_name(kernel));
  }
  return names;
}

std::string line(std::string name, const std::string& value) {
  constexpr std::size_t kWidth = 15;
  name.resize(kWidth, ' ');
  return name + value + "\n";
}

}  // namespace

std::string build_details() {
  return line("commit", SIGHTLINE_COMMIT) + line("map format", to_string(kFormatVersion)) +
         line("model format", std::to_string(ArtifactTraits<ErrorModel>::kVersion)) +
         line("configuration", "schema " SIGHTLINE_CONFIG_SCHEMA) + line("kernels", kernels()) +
         line("libraries", SIGHTLINE_LIBRARIES);
}

}  // namespace sightline
