#include "compiler/driver/provenance.h"

#include <unistd.h>

#include <chrono>
#include <ctime>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "formats/base/version.h"
#include "formats/text/json_text.h"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

std::string utc_now() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

std::string host_name() {
  char name[256] = {};
  ::gethostname(name, sizeof name - 1);
  return name;
}

Json pass_json(const StepReport& report) {
  return {{"name", report.name},        {"from_cache", report.from_cache},
          {"reason", report.reason},    {"wall_s", report.wall_s},
          {"cpu_s", report.cpu_s},      {"peak_memory_mib", report.peak_memory_mib},
          {"warnings", report.warnings}};
}

Json config_json(const CompileConfig& config) {
  Json json = Json::object();
  for (const EffectiveValue& value : effective_values(config)) {
    json[value.section][value.key] = value.value;
  }
  return json;
}

}  // namespace

std::vector<std::string> command_line() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  std::vector<std::string> words;
  for (std::size_t begin = 0; begin < bytes.size();) {
    words.emplace_back(bytes.c_str() + begin);
    begin += words.back().size() + 1;
  }
  return words;
}

std::string provenance_json(const CompileConfig& config,
                            const std::vector<std::string>& command_line,
                            const RecordingCards& recordings,
                            const std::vector<StepReport>& reports) {
  Json json = {{"program", "sightline " + program_version()},
               {"time_utc", utc_now()},
               {"host", host_name()},
               {"command_line", command_line},
               {"inputs", Json::object()},
               {"configuration", config_json(config)},
               {"passes", Json::array()}};
  for (const RecordingCard& card : recordings.cards) {
    json["inputs"][card.role + "/recording"] = to_hex(card.digest);
  }
  for (const StepReport& report : reports) json["passes"].push_back(pass_json(report));
  return json_text(json);
}

}  // namespace sightline
