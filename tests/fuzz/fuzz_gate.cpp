#include <string>

#include "compiler/gate/settings.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline;
  const std::string text(reinterpret_cast<const char*>(data), size);
  const Result<GateSettings> settings = parse_gate_settings(text);
  if (!settings) {
    check_refusal(settings.error(), {}, /*may_be_usage=*/true);
    return 0;
  }
  SIGHTLINE_CHECK(settings->rules.size() == default_gate_settings().rules.size());
  for (const GateException& exception : settings->exceptions) {
    SIGHTLINE_CHECK(is_date(exception.until));
    SIGHTLINE_CHECK(days_between(exception.until, exception.until) == 0);
    SIGHTLINE_CHECK(!exception.reason.empty());
  }
  return 0;
}
