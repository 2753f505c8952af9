#include "compiler/work/plan_file.h"

#include <nlohmann/json.hpp>

#include "formats/base/files/atomic_file.h"
#include "formats/base/version.h"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kVersion = 1;
constexpr std::size_t kLongest = std::size_t{1} << 24;  // bytes; a plan names drives, not scans

// Values of a JSON object, with the first that is missing or of another type remembered.
class Fields {
 public:
  explicit Fields(const Json& json) : json_(json) {}

  [[nodiscard]] std::string text(const char* name) {
    const auto found = json_.find(name);
    if (found != json_.end() && found->is_string()) return found->get<std::string>();
    miss(name);
    return {};
  }
  [[nodiscard]] const Json& list(const char* name) {
    static const Json kEmpty = Json::array();
    const auto found = json_.find(name);
    if (found != json_.end() && found->is_array()) return *found;
    miss(name);
    return kEmpty;
  }
  void miss(const std::string& name) {
    if (missing_.empty()) missing_ = name;
  }
  [[nodiscard]] const std::string& missing() const { return missing_; }

 private:
  const Json& json_;
  std::string missing_;
};

}  // namespace

std::filesystem::path plan_file_in(const std::filesystem::path& plan) { return plan / "plan.json"; }

std::filesystem::path store_in(const std::filesystem::path& plan) { return plan / "store"; }

std::string to_json(const PlanFile& plan) {
  Json json = {{"sightline_plan", kVersion},     {"program", "sightline " + program_version()},
               {"folder", plan.folder.string()}, {"configuration", plan.configuration.string()},
               {"overrides", plan.overrides},    {"model", plan.model.string()},
               {"values", plan.values},          {"recordings", Json::array()}};
  for (const PlannedRecording& recording : plan.recordings) {
    json["recordings"].push_back({{"role", recording.role}, {"digest", recording.digest}});
  }
  return json.dump(2) + "\n";
}

Result<PlanFile> read_plan_file(const std::filesystem::path& plan) {
  const std::filesystem::path file = plan_file_in(plan);
  SIGHTLINE_ASSIGN(const std::string text, read_short_text(file, kLongest));
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object() || !json.contains("sightline_plan")) {
    return Error{ErrorCode::kMalformedText, "this is no plan of `sightline plan`", file.string()};
  }
  const Json& version = json["sightline_plan"];
  if (!version.is_number_integer() || version.get<std::int64_t>() != kVersion) {
    return Error{ErrorCode::kFutureVersion,
                 "found a plan of version " + version.dump() + ", this program reads version " +
                     std::to_string(kVersion),
                 file.string()};
  }
  Fields fields(json);
  PlanFile read;
  read.folder = fields.text("folder");
  read.configuration = fields.text("configuration");
  read.model = fields.text("model");
  read.values = fields.text("values");
  for (const Json& override_text : fields.list("overrides")) {
    if (override_text.is_string()) {
      read.overrides.push_back(override_text.get<std::string>());
    } else {
      fields.miss("overrides");
    }
  }
  for (const Json& recording : fields.list("recordings")) {
    Fields of_recording(recording);
    read.recordings.push_back({of_recording.text("role"), of_recording.text("digest")});
    if (!of_recording.missing().empty()) fields.miss("recordings." + of_recording.missing());
  }
  if (fields.missing().empty()) return read;
  return Error{ErrorCode::kMissingKey, "'" + fields.missing() + "' is missing or is no such value",
               file.string()};
}

}  // namespace sightline
