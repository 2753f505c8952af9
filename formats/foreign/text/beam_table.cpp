#include "formats/foreign/text/beam_table.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>

#include "formats/foreign/text/file_bytes.h"
#include "formats/foreign/text/text_lines.h"

namespace sightline {
namespace {

constexpr std::size_t kMostBeams = 1024;

class TableReader {
 public:
  TableReader(std::string_view text, std::string_view file)
      : file_{std::as_bytes(std::span(text.data(), text.size())), std::string(file)} {}

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
      return error("found " + std::to_string(words_.size()) + " columns, expected more");
    }
    const std::optional<double> value = to_number<double>(words_[at]);
    if (value && std::isfinite(*value)) return *value;
    return error("found " + in_quotes(words_[at]) + ", expected a finite number");
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

Result<std::vector<BeamRow>> parse_beam_table(std::string_view text, std::string_view file) {
  return TableReader(text, file).read();
}

}  // namespace sightline
