#include <array>
#include <vector>

#include "formats/foreign/clouds/ply_header.h"
#include "formats/foreign/clouds/points/add_point.h"
#include "formats/foreign/clouds/points/point_cloud_file.h"
#include "formats/foreign/clouds/points/point_times.h"
#include "formats/foreign/text/field_names.h"
#include "formats/foreign/text/file_bytes.h"
#include "formats/foreign/text/text_lines.h"

// PLY is read here and not by PCL: its PLY reader takes a damaged file for an empty one, and rounds
// doubles. Elements behind the vertices are walked through as well, since only then is it known
// that the file is whole.

namespace sightline {
namespace {

// Where x, y, z, intensity and time stand among the properties of a vertex; -1: nowhere.
struct VertexLayout {
  std::array<std::ptrdiff_t, 3> position = {-1, -1, -1};
  std::ptrdiff_t intensity = -1;
  std::ptrdiff_t time = -1;
};

Result<VertexLayout> vertex_layout(const FileBytes& file, const PlyHeader& header) {
  VertexLayout layout;
  std::size_t vertex_elements = 0;
  for (const PlyElement& element : header.elements) {
    if (element.name != "vertex") continue;
    if (++vertex_elements > 1) {
      return file.error(ErrorCode::kMalformedHeader, "a second element vertex",
                        at_line(header.lines));
    }
    if (element.count == 0) {
      return file.error(ErrorCode::kEmptyScan, "the header says that there are no points",
                        at_line(header.lines));
    }
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const PlyProperty& property = element.properties[i];
      if (property.is_list) continue;
      const auto place = static_cast<std::ptrdiff_t>(i);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (property.name != std::string_view("xyz").substr(axis, 1)) continue;
        if (layout.position[axis] >= 0) {
          return file.error(ErrorCode::kMalformedHeader, "a second property " + property.name,
                            at_line(header.lines));
        }
        layout.position[axis] = place;
      }
      if (is_intensity_name(property.name)) layout.intensity = place;
      if (is_time_name(property.name)) layout.time = place;
    }
  }
  if (std::ranges::min(layout.position) < 0) {
    return file.error(ErrorCode::kMissingField, "no element vertex with properties x, y and z",
                      at_line(header.lines));
  }
  return layout;
}

// Numbers one after the other, whatever the encoding. Lists are counted and dropped.
class PlyBody {
 public:
  PlyBody(const FileBytes& file, const PlyHeader& header)
      : file_(file),
        encoding_(header.encoding),
        offset_(header.data_offset),
        lines_(file.text(), header.data_offset, header.lines) {}

  // The numbers of one row of an element; lists stand as 0 to keep places.
  Result<void> read_row(const PlyElement& element, std::vector<double>& row) {
    if (encoding_ == PlyEncoding::kAscii && !next_line()) return cut(element);
    row.clear();
    for (const PlyProperty& property : element.properties) {
      double value = 0.0;
      if (!read(property.is_list ? property.count_type : property.type, value)) return cut(element);
      if (property.is_list) {
        if (!skip(value, property.type)) return cut(element);
        value = 0.0;
      }
      row.push_back(value);
    }
    if (encoding_ == PlyEncoding::kAscii && word_ != words_.size()) {
      return file_.error(ErrorCode::kMalformedText, "more numbers than the header speaks of",
                         at_line(lines_.number()));
    }
    return {};
  }

  // Of the element, as much as the file can hold: no row takes less than its fixed part.
  [[nodiscard]] bool can_hold(const PlyElement& element) const {
    std::uint64_t least = 0;
    for (const PlyProperty& property : element.properties) {
      least += encoding_ == PlyEncoding::kAscii ? 2
               : property.is_list               ? property.count_type.size
                                                : property.type.size;
    }
    // The last line may lack its end.
    const std::uint64_t left = file_.bytes.size() - offset_ + 1;
    return least > 0 && element.count <= left / least + 1;
  }

  [[nodiscard]] Error cut(const PlyElement& element) const {
    const std::string place =
        encoding_ == PlyEncoding::kAscii ? at_line(lines_.number()) : at_byte(file_.bytes.size());
    return file_.error(ErrorCode::kTruncatedScan,
                       "fewer or other numbers than the " + std::to_string(element.count) +
                           " rows of element " + element.name + " need",
                       place);
  }

  Result<void> finish() {
    if (encoding_ == PlyEncoding::kAscii) offset_ = lines_.offset();
    if (is_padding(file_.text().substr(offset_))) return {};
    return file_.error(ErrorCode::kMalformedHeader,
                       "data behind the last row that the header speaks of", at_byte(offset_));
  }
  [[nodiscard]] bool may_be_cut() const {
    return encoding_ == PlyEncoding::kAscii && !lines_.last_has_end();
  }

 private:
  bool next_line() {
    std::string_view line;
    do {
      if (!lines_.next(line)) return false;
      split_words(line, words_);
    } while (words_.empty());
    word_ = 0;
    return true;
  }

  bool read(ElementType type, double& value) {
    if (encoding_ == PlyEncoding::kAscii) {
      const std::optional<double> number =
          word_ < words_.size() ? to_number<double>(words_[word_++]) : std::nullopt;
      if (number) value = *number;
      return number.has_value();
    }
    if (file_.bytes.size() - offset_ < type.size) return false;
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(file_.bytes.data()) + offset_;
    value = encoding_ == PlyEncoding::kLittleEndian ? read_element(bytes, type)
                                                    : read_big_endian_element(bytes, type);
    offset_ += type.size;
    return true;
  }

  bool skip(double count, ElementType type) {
    const std::size_t left = encoding_ == PlyEncoding::kAscii
                                 ? words_.size() - word_
                                 : (file_.bytes.size() - offset_) / type.size;
    if (!(count >= 0.0) || count > static_cast<double>(left) || count != std::floor(count)) {
      return false;
    }
    const auto whole = static_cast<std::size_t>(count);
    if (encoding_ == PlyEncoding::kAscii) {
      word_ += whole;
    } else {
      offset_ += whole * type.size;
    }
    return true;
  }

  const FileBytes& file_;
  PlyEncoding encoding_;
  std::size_t offset_;
  LineReader lines_;
  std::vector<std::string_view> words_;
  std::size_t word_ = 0;
};

double value_at(const std::vector<double>& row, std::ptrdiff_t place) {
  return place < 0 ? 0.0 : row[static_cast<std::size_t>(place)];
}

}  // namespace

Result<PointCloudFile> parse_ply(const FileBytes& file) {
  SIGHTLINE_ASSIGN(const PlyHeader header, parse_ply_header(file));
  SIGHTLINE_ASSIGN(const VertexLayout layout, vertex_layout(file, header));
  PlyBody body(file, header);
  PointCloudFile cloud;
  std::vector<double> row;
  std::vector<double> times;
  for (const PlyElement& element : header.elements) {
    if (element.count > 0 && !body.can_hold(element)) return body.cut(element);
    const bool is_vertex = element.name == "vertex";
    for (std::uint64_t i = 0; i < element.count; ++i) {
      SIGHTLINE_TRY(body.read_row(element, row));
      if (!is_vertex) continue;
      const auto& [x, y, z] = layout.position;
      const Eigen::Vector3d point_m(value_at(row, x), value_at(row, y), value_at(row, z));
      const auto intensity = static_cast<float>(value_at(row, layout.intensity));
      if (add_point(cloud, point_m, intensity) && layout.time >= 0) {
        times.push_back(value_at(row, layout.time));
      }
    }
  }
  SIGHTLINE_TRY(body.finish());
  cloud.may_be_cut = body.may_be_cut();
  if (layout.time >= 0) set_point_times(times, cloud);
  return cloud;
}

}  // namespace sightline
