#pragma once

#include <map>
#include <string>
#include <string_view>

#include "formats/base/check.h"
#include "passes/pass/pass.h"

namespace sightline {

// Values for the options of passes, as texts that were checked when they were read. What is not
// named keeps the default of the pass.
struct PassSettings {
  std::map<std::string, std::string> shared;  // by field: for every pass with a shared field of it
  std::map<std::string, std::map<std::string, std::string>> own;  // by pass, by field

  // The options of a pass by these settings.
  template <class Output, class Options, class... Parameters>
  [[nodiscard]] Options options(const Pass<Output, Options, Parameters...>& pass) const {
    Options options{};
    for (OptionField& field : option_fields(options)) set(pass.name, field);
    return options;
  }

 private:
  void set(std::string_view pass, OptionField& field) const;
};

}  // namespace sightline
