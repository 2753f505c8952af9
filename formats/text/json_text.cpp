#include "formats/text/json_text.h"

#include <nlohmann/json.hpp>

#include "formats/base/printable.h"

namespace sightline {

std::string json_text(const nlohmann::ordered_json& json, int indent) {
  const std::string text = printable_json(
      json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  return indent < 0 ? text : text + "\n";
}

}  // namespace sightline
