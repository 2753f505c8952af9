// A YAML configuration with its recordings and the gate's section: refused with a line, or fit to
// be written down again.

#include "compiler/config/compile_config.h"
#include "tests/fuzz/fuzz.h"
#include "tests/support/test_files.h"

namespace sightline {
namespace {

void check(const Error& error) {
  check_refusal(error, {}, /*may_be_usage=*/true);
  SIGHTLINE_CHECK(!error.file.empty());
}

Result<void> read(const std::string& path, CompileConfig& config) {
  std::vector<ConfigSection> sections = drive_sections(config);
  static const ConfigSection gate = gate_section();  // its schema takes long to write
  sections.push_back(gate);
  return read_compile_config(path, {}, sections, config);
}

}  // namespace
}  // namespace sightline

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline;
  const MemoryFile file(std::as_bytes(std::span(data, size)));
  CompileConfig config;
  const Result<void> done = read(file.path(), config);
  if (!done) {
    check(done.error());
    return 0;
  }
  // What `sightline passes --config` writes is read back and says the same.
  const std::string written = to_yaml(drive_sections(config));
  if (written.find("\xEF\xBF\xBD") != std::string::npos) return 0;  // a path that is no UTF-8
  const MemoryFile again(std::as_bytes(std::span(written)));
  CompileConfig second;
  SIGHTLINE_CHECK(read(again.path(), second).has_value());
  SIGHTLINE_CHECK(to_yaml(drive_sections(second)) == written);
  SIGHTLINE_CHECK(!effective_values(config).empty());
  return 0;
}
