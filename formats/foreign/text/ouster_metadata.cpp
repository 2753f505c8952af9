#include "formats/foreign/text/ouster_metadata.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "formats/foreign/text/file_bytes.h"
#include "formats/foreign/text/text_lines.h"

namespace sightline {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMostBeams = 1024;
constexpr std::size_t kMostColumns = 4096;

// Reads members; the first fault is kept.
class Reader {
 public:
  Reader(const FileBytes& file, const Json& json) : file_(file), json_(json) {}

  // The member of that name, also one level deeper. nullptr: there is none.
  [[nodiscard]] const Json* member(const std::string& name) const {
    if (!json_.is_object()) return nullptr;
    if (json_.contains(name)) return &json_[name];
    for (const auto& [key, value] : json_.items()) {
      if (value.is_object() && value.contains(name)) return &value[name];
    }
    return nullptr;
  }

  std::vector<double> numbers(const std::string& name) {
    std::vector<double> values;
    const Json* list = member(name);
    if (list == nullptr) return values;
    if (!list->is_array()) fail(ErrorCode::kMalformedText, name + ": expected a list of numbers");
    for (const Json& value : *list) {
      if (!value.is_number()) {
        fail(ErrorCode::kMalformedText, name + ": expected numbers");
        break;
      }
      values.push_back(value.get<double>());
    }
    return values;
  }

  std::optional<double> number(const std::string& name) {
    const Json* value = member(name);
    if (value == nullptr) return std::nullopt;
    if (value->is_number()) return value->get<double>();
    fail(ErrorCode::kMalformedText, name + ": expected a number");
    return std::nullopt;
  }

  std::optional<std::string> text(const std::string& name) {
    const Json* value = member(name);
    if (value == nullptr || !value->is_string()) return std::nullopt;
    return value->get<std::string>();
  }

  // A whole number from 1 to `most`; `otherwise` where there is none.
  std::size_t count(const std::string& name, std::size_t otherwise, std::size_t most) {
    const std::optional<double> value = number(name);
    if (!value) return otherwise;
    return checked_count(name, *value, 1, most);
  }

  std::size_t checked_count(const std::string& name, double value, std::size_t least,
                            std::size_t most) {
    const bool is_right = value >= static_cast<double>(least) &&
                          value <= static_cast<double>(most) && value == std::floor(value);
    if (is_right) return static_cast<std::size_t>(value);
    fail(ErrorCode::kBadValue,
         concat(name, ": expected a whole number from ", least, " to ", most));
    return least;
  }

  void fail(ErrorCode code, const std::string& message) {
    if (!fault_) fault_ = file_.error(code, message, "");
  }
  [[nodiscard]] const std::optional<Error>& fault() const { return fault_; }

 private:
  const FileBytes& file_;
  const Json& json_;
  std::optional<Error> fault_;
};

bool are_all_finite(const std::vector<double>& values) {
  for (const double value : values) {
    if (!(std::abs(value) < 1e6)) return false;
  }
  return true;
}

void read_columns(Reader& reader, OusterMetadata& metadata) {
  metadata.columns_per_packet = reader.count("columns_per_packet", 16, kMostColumns);
  metadata.columns_per_frame = reader.count("columns_per_frame", 0, kMostColumns);
  if (const std::optional<std::string> mode = reader.text("lidar_mode");
      mode && metadata.columns_per_frame == 0) {  // "1024x10"
    const std::optional<double> columns = to_number<double>(mode->substr(0, mode->find('x')));
    if (columns)
      metadata.columns_per_frame = reader.checked_count("lidar_mode", *columns, 1, kMostColumns);
  }
  if (metadata.columns_per_frame == 0) return;
  metadata.last_column = metadata.columns_per_frame - 1;
  const std::vector<double> window = reader.numbers("column_window");
  if (window.size() != 2) return;
  metadata.first_column =
      reader.checked_count("column_window", window[0], 0, metadata.columns_per_frame - 1);
  metadata.last_column =
      reader.checked_count("column_window", window[1], 0, metadata.columns_per_frame - 1);
}

void read_geometry(Reader& reader, OusterMetadata& metadata) {
  metadata.beam_radius_mm = reader.number("lidar_origin_to_beam_origin_mm");
  const std::vector<double> beam = reader.numbers("beam_to_lidar_transform");
  if (beam.size() == 16) {
    metadata.beam_radius_mm = beam[3];
    metadata.beam_height_mm = beam[11];
  }
  const std::vector<double> to_sensor = reader.numbers("lidar_to_sensor_transform");
  if (to_sensor.size() == 16) {
    metadata.lidar_to_sensor =
        Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(to_sensor.data());
  }
  if (!are_all_finite(beam) || !are_all_finite(to_sensor) ||
      !are_all_finite({metadata.beam_radius_mm.value_or(0.0)})) {
    reader.fail(ErrorCode::kBadValue, "found a length of more than 1 km");
  }
}

void read_beams(Reader& reader, OusterMetadata& metadata) {
  metadata.altitudes_deg = reader.numbers("beam_altitude_angles");
  metadata.azimuths_deg = reader.numbers("beam_azimuth_angles");
  const std::size_t beams = metadata.altitudes_deg.size();
  const bool has_azimuths = !metadata.azimuths_deg.empty();
  if (beams == 0 || beams > kMostBeams || (has_azimuths && metadata.azimuths_deg.size() != beams)) {
    reader.fail(ErrorCode::kBadValue, "expected 1 to 1024 beams, and as many azimuths");
  }
  if (!are_all_finite(metadata.altitudes_deg) || !are_all_finite(metadata.azimuths_deg)) {
    reader.fail(ErrorCode::kBadValue, "found an angle that is not finite");
  }
}

}  // namespace

Result<OusterMetadata> parse_ouster_metadata(std::string_view text,
                                             const std::filesystem::path& path) {
  const FileBytes file = FileBytes::of_text(text, path.string());
  constexpr std::size_t kMostDepth = 64;  // the library reads as deep as memory goes
  std::size_t depth = 0;
  for (const char c : text) {
    if (c == '{' || c == '[') ++depth;
    if ((c == '}' || c == ']') && depth > 0) --depth;
    if (depth > kMostDepth) {
      return file.error(ErrorCode::kMalformedText,
                        "this is not the metadata of a LiDAR: its JSON is nested too deeply", "");
    }
  }
  const Json json = Json::parse(text, nullptr, false);
  Reader reader(file, json);
  const Json* angles = json.is_discarded() ? nullptr : reader.member("beam_altitude_angles");
  if (angles == nullptr || !angles->is_array()) {
    return file.error(ErrorCode::kMalformedText,
                      "found no list beam_altitude_angles, which Ouster's metadata contains", "");
  }
  OusterMetadata metadata;
  read_beams(reader, metadata);
  read_columns(reader, metadata);
  read_geometry(reader, metadata);
  metadata.profile = reader.text("udp_profile_lidar").value_or(metadata.profile);
  metadata.product = reader.text("prod_line").value_or("");
  if (reader.fault()) return *reader.fault();
  return metadata;
}

}  // namespace sightline
