#include "formats/foreign/text/sensor_file.h"

#include <algorithm>
#include <cctype>
#include <string>

#include "formats/base/files/atomic_file.h"
#include "formats/foreign/text/file_bytes.h"
#include "formats/foreign/text/ouster_metadata.h"
#include "formats/foreign/text/text_lines.h"

namespace sightline {
namespace {

constexpr std::size_t kLargestFile = kLargestOusterMetadata;

// A number of a key. Error: malformed-text.
Result<double> number_of(const FileBytes& file, std::size_t line, std::string_view word) {
  if (const std::optional<double> number = finite_number(word)) return *number;
  return file.error(ErrorCode::kMalformedText,
                    concat("found ", in_quotes(word), ", expected a finite number"), at_line(line));
}

// `beams` evenly from `lowest_deg` to `highest_deg`, where no table is given.
struct EvenBeams {
  std::optional<double> count;
  std::optional<double> lowest_deg;
  std::optional<double> highest_deg;
};

struct YamlReader {
  const FileBytes& file;
  SensorProfile profile;
  EvenBeams even;

  Result<void> take(std::size_t line, std::string_view key, std::string_view value) {
    std::vector<std::string_view> words;
    split_words(value, words, " \t,[]");
    if (key == "beams_deg") {
      for (const std::string_view word : words) {
        SIGHTLINE_ASSIGN(const double beam_deg, number_of(file, line, word));
        profile.beam_elevations_deg.push_back(beam_deg);
      }
      return {};
    }
    if (words.size() != 1) {
      return file.error(ErrorCode::kMalformedText,
                        concat("found ", words.size(), " values of ", key, ", expected one"),
                        at_line(line));
    }
    if (key == "name") {
      profile.name = words.front();
      return {};
    }
    SIGHTLINE_ASSIGN(const double number, number_of(file, line, words.front()));
    return take_number(line, key, number);
  }

  Result<void> take_number(std::size_t line, std::string_view key, double number) {
    const auto is_taken = [&](std::string_view name, auto& to) {
      if (key == name) to = number;
      return key == name;
    };
    if (is_taken("beams", even.count) || is_taken("lowest_beam_deg", even.lowest_deg) ||
        is_taken("highest_beam_deg", even.highest_deg) ||
        is_taken("azimuth_step_deg", profile.azimuth_step_deg) ||
        is_taken("azimuth_view_deg", profile.azimuth_view_deg) ||
        is_taken("min_range_m", profile.min_range_m) ||
        is_taken("max_range_m", profile.max_range_m) || is_taken("height_m", profile.height_m)) {
      return {};
    }
    return file.error(ErrorCode::kUnknownKey,
                      concat("found ", in_quotes(key),
                             ", expected name, beams_deg (or beams, lowest_beam_deg, "
                             "highest_beam_deg), azimuth_step_deg, azimuth_view_deg, min_range_m, "
                             "max_range_m or height_m"),
                      at_line(line));
  }
};

Result<void> add_even_beams(const FileBytes& file, const EvenBeams& even, SensorProfile& profile) {
  constexpr double kMostBeams = 1024.0;
  if (!profile.beam_elevations_deg.empty()) return {};
  if (!even.count || !even.lowest_deg || !even.highest_deg) {
    return file.error(ErrorCode::kMissingKey,
                      "found no beams_deg, and not all of beams, lowest_beam_deg and "
                      "highest_beam_deg");
  }
  if (!(*even.count >= 2.0 && *even.count <= kMostBeams)) {
    return file.error(ErrorCode::kBadValue, "beams: expected 2 to 1024");
  }
  const int count = static_cast<int>(*even.count);
  for (int i = 0; i < count; ++i) {
    profile.beam_elevations_deg.push_back(*even.lowest_deg +
                                          (*even.highest_deg - *even.lowest_deg) * i / (count - 1));
  }
  return {};
}

Result<SensorProfile> parse_yaml(const FileBytes& file) {
  YamlReader reader{file, {}, {}};
  LineReader lines(file.text());
  for (std::string_view line; lines.next(line);) {
    line = line.substr(0, line.find('#'));
    std::vector<std::string_view> words;
    split_words(line, words);
    if (words.empty()) continue;
    const std::size_t colon = line.find(':');
    std::vector<std::string_view> key;
    split_words(line.substr(0, colon), key);
    if (colon == std::string_view::npos || key.size() != 1) {
      return file.error(ErrorCode::kMalformedText, "expected 'key: value'",
                        at_line(lines.number()));
    }
    SIGHTLINE_TRY(reader.take(lines.number(), key.front(), line.substr(colon + 1)));
  }
  SIGHTLINE_TRY(add_even_beams(file, reader.even, reader.profile));
  return reader.profile;
}

Result<SensorProfile> parse_csv(const FileBytes& file) {
  SIGHTLINE_ASSIGN(const std::vector<BeamRow> rows, parse_beam_table(file.text(), file.file));
  SensorProfile profile;
  for (const BeamRow& row : rows) profile.beam_elevations_deg.push_back(row.elevation_deg);
  return profile;
}

// "OS-1-128" looks as far as the data sheets say.
double ouster_range_m(const std::string& product) {
  if (product.starts_with("OS-0")) return 100.0;
  return product.starts_with("OS-2") ? 240.0 : 120.0;
}

Result<SensorProfile> parse_json(const FileBytes& file) {
  SIGHTLINE_ASSIGN(const OusterMetadata metadata, parse_ouster_metadata(file.text(), file.file));
  SensorProfile profile;
  profile.name = metadata.product.empty() ? "ouster" : metadata.product;
  profile.beam_elevations_deg = metadata.altitudes_deg;
  const std::size_t columns = metadata.columns_per_frame;
  profile.azimuth_step_deg = 360.0 / static_cast<double>(columns > 0 ? columns : 1024);
  profile.min_range_m = 0.3;
  profile.max_range_m = ouster_range_m(metadata.product);
  return profile;
}

constexpr std::size_t kMostBeams = 1024;

class TableReader {
 public:
  TableReader(std::string_view text, std::string_view file)
      : file_(FileBytes::of_text(text, std::string(file))) {}

  Result<std::vector<BeamRow>> read() {
    LineReader lines(file_.text());
    for (std::string_view line; lines.next(line);) {
      split_words(line, words_, ", ;\t\"");
      if (words_.empty()) continue;
      line_ = lines.number();
      if (!elevation_) {
        SIGHTLINE_TRY(take_names());
        continue;
      }
      SIGHTLINE_TRY(take_row());
    }
    return std::move(rows_);
  }

 private:
  [[nodiscard]] Error error(const std::string& message) const {
    return file_.error(ErrorCode::kMalformedText, message, at_line(line_));
  }

  Result<void> take_names() {
    for (std::size_t i = 0; i < words_.size(); ++i) {
      std::string name(words_[i]);
      std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
      if (!elevation_ && name.starts_with("elevation")) elevation_ = i;
      if (!azimuth_ && name.starts_with("azimuth")) azimuth_ = i;
      if (!channel_ && i == 0 && (name.starts_with("channel") || name.starts_with("laser"))) {
        // "Laser id" are two words, of one column.
        channel_ = 0;
        shift_ = words_.size() > 1 && words_[1] == "id" ? 1 : 0;
      }
    }
    if (elevation_) return {};
    return error(
        "found no column of elevations in the first line, expected e.g. Channel,Elevation,Azimuth");
  }

  Result<double> number(std::size_t column) const {
    const std::size_t at = column - std::min(column, shift_);
    if (at >= words_.size()) {
      return error(concat("found ", words_.size(), " columns, expected more"));
    }
    if (const std::optional<double> value = finite_number(words_[at])) return *value;
    return error(concat("found ", in_quotes(words_[at]), ", expected a finite number"));
  }

  Result<void> take_row() {
    if (rows_.size() == kMostBeams) return error("found more than 1024 beams");
    BeamRow row;
    SIGHTLINE_ASSIGN(row.elevation_deg, number(*elevation_));
    if (azimuth_) {
      SIGHTLINE_ASSIGN(row.azimuth_deg, number(*azimuth_));
    }
    if (channel_) {
      SIGHTLINE_ASSIGN(const double channel, number(*channel_));
      if (!(channel >= 0.0 && channel <= 1e6)) return error("expected the number of a channel");
      row.channel = static_cast<int>(channel);
    }
    rows_.push_back(row);
    return {};
  }

  FileBytes file_;
  std::vector<std::string_view> words_;
  std::size_t line_ = 0;
  std::optional<std::size_t> elevation_, azimuth_, channel_;
  std::size_t shift_ = 0;
  std::vector<BeamRow> rows_;
};

}  // namespace

bool is_sensor_file(std::string_view name) {
  const std::string ending = lower_extension(std::filesystem::path(name));
  return ending == ".yaml" || ending == ".yml" || ending == ".csv" || ending == ".json";
}

Result<SensorProfile> read_sensor_file(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(const std::string text, read_short_text(path, kLargestFile));
  return parse_sensor_file(text, path);
}

Result<SensorProfile> parse_sensor_file(std::string_view text, const std::filesystem::path& path) {
  const FileBytes file = FileBytes::of_text(text, path.string());
  const std::string ending = lower_extension(path);
  SIGHTLINE_ASSIGN(SensorProfile profile, ending == ".csv"    ? parse_csv(file)
                                          : ending == ".json" ? parse_json(file)
                                                              : parse_yaml(file));
  if (profile.name == SensorProfile().name) profile.name = path.stem().string();
  std::vector<double>& beams = profile.beam_elevations_deg;
  std::ranges::sort(beams);
  beams.erase(std::unique(beams.begin(), beams.end()), beams.end());
  const Result<void> valid = validate(profile);
  if (!valid || beams.size() < 2) {
    return file.error(ErrorCode::kBadValue,
                      valid ? "found one beam, expected two or more" : valid.error().message);
  }
  return profile;
}

Result<std::vector<BeamRow>> parse_beam_table(std::string_view text, std::string_view file) {
  return TableReader(text, file).read();
}

}  // namespace sightline
