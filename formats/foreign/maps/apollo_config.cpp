#include "formats/foreign/maps/apollo_config.h"

#include <tinyxml2.h>

#include <cmath>
#include <optional>

#include "formats/foreign/text/text_lines.h"

namespace sightline {
namespace {

using tinyxml2::XMLElement;

// Apollo's largest are 4096 cells of 0.03 m.
constexpr double kMostNodeCells = 16384.0;
constexpr double kLeastCell_m = 0.01;
constexpr double kMostCell_m = 100.0;
constexpr double kFarthest_m = 1e8;

// Reads one document; refers into it.
class ConfigReader {
 public:
  ConfigReader(const XMLElement& config, const std::string& file) : config_(config), file_(file) {}

  Result<ApolloConfig> read() const {
    SIGHTLINE_TRY(check_version());
    ApolloConfig config;
    SIGHTLINE_ASSIGN(const double columns, number("node_size", "x", 1.0, kMostNodeCells));
    SIGHTLINE_ASSIGN(const double rows, number("node_size", "y", 1.0, kMostNodeCells));
    if (columns != std::floor(columns) || rows != std::floor(rows)) {
      return error(ErrorCode::kMalformedText, "node_size is no whole number of cells");
    }
    config.node_columns = static_cast<std::uint32_t>(columns);
    config.node_rows = static_cast<std::uint32_t>(rows);
    SIGHTLINE_ASSIGN(config.min_x_m, number("range", "min_x", -kFarthest_m, kFarthest_m));
    SIGHTLINE_ASSIGN(config.min_y_m, number("range", "min_y", -kFarthest_m, kFarthest_m));
    const std::string_view compression = text_of(config_.FirstChildElement("compression"));
    config.is_compressed = compression != "false" && compression != "0";
    SIGHTLINE_ASSIGN(config.cells_m, numbers("resolutions"));
    SIGHTLINE_ASSIGN(config.heights_m, numbers("resolutions_z"));
    if (config.cells_m.size() == config.heights_m.size()) return config;
    return error(ErrorCode::kMalformedText,
                 "found " + std::to_string(config.cells_m.size()) + " resolutions and " +
                     std::to_string(config.heights_m.size()) + " of z, expected as many");
  }

 private:
  [[nodiscard]] Error error(ErrorCode code, std::string message) const {
    return {code, std::move(message), file_, "map_config"};
  }

  static std::string_view text_of(const XMLElement* element) {
    const char* text = element == nullptr ? nullptr : element->GetText();
    return text == nullptr ? std::string_view() : std::string_view(text);
  }

  [[nodiscard]] Result<void> check_version() const {
    const std::string_view version = text_of(config_.FirstChildElement("version"));
    if (version.starts_with("map_ndt")) return {};
    return error(ErrorCode::kUnsupportedFormat,
                 "found an Apollo map of version '" + std::string(version.substr(0, 40)) +
                     "', expected map_ndt_v01: other maps of Apollo hold intensities and heights, "
                     "and no distributions to match with");
  }

  [[nodiscard]] Result<double> number_of(std::string_view text, const std::string& name,
                                         double least, double most) const {
    const std::optional<double> found = to_number<double>(text);
    if (!found || !std::isfinite(*found)) {
      return error(text.empty() ? ErrorCode::kMissingField : ErrorCode::kMalformedText,
                   name + ": found '" + std::string(text.substr(0, 40)) + "', expected a number");
    }
    if (*found >= least && *found <= most) return *found;
    return error(ErrorCode::kUnsupportedFormat,
                 name + ": found " + std::string(text.substr(0, 40)) + ", which no map has");
  }

  [[nodiscard]] Result<double> number(const char* group, const char* name, double least,
                                      double most) const {
    const XMLElement* parent = config_.FirstChildElement(group);
    const XMLElement* child = parent == nullptr ? nullptr : parent->FirstChildElement(name);
    return number_of(text_of(child), std::string(group) + "." + name, least, most);
  }

  [[nodiscard]] Result<std::vector<double>> numbers(const char* group) const {
    constexpr std::size_t kMost = 100;
    std::vector<double> found;
    const XMLElement* parent = config_.FirstChildElement(group);
    const XMLElement* child = parent == nullptr ? nullptr : parent->FirstChildElement();
    for (; child != nullptr && found.size() < kMost; child = child->NextSiblingElement()) {
      SIGHTLINE_ASSIGN(const double edge_m,
                       number_of(text_of(child), group, kLeastCell_m, kMostCell_m));
      found.push_back(edge_m);
    }
    if (!found.empty()) return found;
    return error(ErrorCode::kMissingField, std::string(group) + " is missing");
  }

  const XMLElement& config_;
  const std::string& file_;
};

}  // namespace

Result<ApolloConfig> parse_apollo_config(std::string_view text, const std::string& file) {
  tinyxml2::XMLDocument document;
  if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
    return Error{ErrorCode::kMalformedText, std::string("found no XML: ") + document.ErrorName(),
                 file, "line " + std::to_string(document.ErrorLineNum())};
  }
  const XMLElement* root = document.FirstChildElement("map");
  const XMLElement* config = root == nullptr ? nullptr : root->FirstChildElement("map_config");
  if (config == nullptr) {
    return Error{ErrorCode::kMissingField, "found no map.map_config, expected Apollo's config.xml",
                 file};
  }
  return ConfigReader(*config, file).read();
}

}  // namespace sightline
