#include "compiler/pipeline/settings.h"

namespace sightline {

void PassSettings::set(std::string_view pass, OptionField& field) const {
  const std::map<std::string, std::string>* values = &shared;
  if (!field.is_shared) {
    const auto section = own.find(std::string(pass));
    if (section == own.end()) return;
    values = &section->second;
  }
  const auto value = values->find(field.name);
  if (value == values->end()) return;
  const Result<void> is_set = set_from_text(field, value->second);
  SIGHTLINE_CHECK(is_set.has_value());
}

}  // namespace sightline
