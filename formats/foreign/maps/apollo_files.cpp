#include "formats/foreign/maps/apollo_files.h"

#include <tinyxml2.h>
#include <zlib.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "formats/base/bytes.h"
#include "formats/base/check.h"
#include "formats/foreign/text/text_lines.h"
#include "formats/symmetric_eigen.h"

namespace sightline {
namespace {

constexpr std::uint32_t kInverseFrom_points = 6;
constexpr std::size_t kLeastCellSize = 17 * sizeof(float);  // number, and what every cell has
constexpr std::size_t kMostCellSize = 27 * sizeof(float);   // with the inverse covariance

std::string at_byte_of_body(std::size_t offset) { return concat("byte ", offset, " of the body"); }

// Bytes that the body of a node may have, which a packed one does not say itself.
std::size_t most_bytes(const ApolloConfig& config) {
  constexpr std::size_t kMost = std::size_t{1} << 30U;
  constexpr std::size_t kCellsOfColumn = 64;  // on average, with as many on the road
  constexpr std::size_t kColumn = 4 * sizeof(std::uint32_t);
  const std::size_t columns = std::size_t{config.node_rows} * config.node_columns;
  return std::min(kMost, columns * (kColumn + kCellsOfColumn * (kMostCellSize + kColumn)));
}

Result<std::vector<std::byte>> unpack(std::span<const std::byte> packed, std::size_t most,
                                      const std::string& file) {
  z_stream stream{};
  SIGHTLINE_CHECK(inflateInit(&stream) == Z_OK);
  std::vector<std::byte> body;
  std::vector<std::byte> buffer(std::size_t{1} << 17U);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  int status = Z_OK;
  while (status == Z_OK && body.size() <= most) {
    stream.next_out = reinterpret_cast<Bytef*>(buffer.data());
    stream.avail_out = static_cast<uInt>(buffer.size());
    status = inflate(&stream, Z_NO_FLUSH);
    body.insert(body.end(), buffer.begin(), buffer.end() - stream.avail_out);
  }
  const std::size_t rest = stream.avail_in;
  inflateEnd(&stream);
  if (body.size() > most) {
    return Error{ErrorCode::kUnsupportedFormat,
                 concat("unpacks to more than ", most, " bytes, expected a node"), file, "byte 20"};
  }
  if (status != Z_STREAM_END) {
    return Error{ErrorCode::kTruncatedScan, "the zlib stream is cut or damaged", file,
                 concat("byte ", 20 + packed.size() - rest)};
  }
  if (rest == 0) return body;
  return Error{ErrorCode::kMalformedHeader, concat("found ", rest, " bytes after the zlib stream"),
               file, concat("byte ", 20 + packed.size() - rest)};
}

// Checks the header, and returns what stands behind it.
Result<std::span<const std::byte>> packed_body(std::span<const std::byte> bytes,
                                               const ApolloNodeIndex& index,
                                               const std::string& file) {
  ByteReader reader(bytes);
  ApolloNodeIndex found;
  reader.get(found.resolution);
  reader.get(found.zone);
  reader.get(found.m);
  reader.get(found.n);
  const auto body_size = reader.get<std::uint32_t>();
  if (!reader.ok()) {
    return Error{ErrorCode::kTruncatedScan,
                 concat("found ", bytes.size(), " bytes, expected a header of 20"), file, "byte 0"};
  }
  const auto text_of = [](const ApolloNodeIndex& node) {
    return concat("resolution ", node.resolution, ", zone ", node.zone, ", m ", node.m, ", n ",
                  node.n);
  };
  if (!(found == index)) {
    return Error{ErrorCode::kMalformedHeader,
                 concat("found ", text_of(found), ", expected ", text_of(index),
                        " as in the names of its folders"),
                 file, "byte 0"};
  }
  if (body_size == reader.remaining()) return bytes.subspan(reader.offset());
  return Error{
      body_size > reader.remaining() ? ErrorCode::kTruncatedScan : ErrorCode::kMalformedHeader,
      concat("found a body of ", reader.remaining(), " bytes, expected ", body_size), file,
      "byte 16"};
}

// Along one axis: the cell of a coordinate that is relative to the corner of cell `key`.
struct AxisPlace {
  double key = 0.0;
  double in_cell_m = 0.0;
};

AxisPlace place_of(double key, double from_corner_m, double cell_m) {
  const double steps = std::floor(from_corner_m / cell_m);
  AxisPlace place{key + steps, from_corner_m - steps * cell_m};
  place.in_cell_m = std::clamp(place.in_cell_m, 0.0, std::nextafter(cell_m, 0.0));
  return place;
}

// Of float32 sums: what rounding may leave below 0, of the square of a cell.
constexpr double kRoundingShare = 1e-4;

bool is_covariance(const Eigen::Matrix3d& covariance_m2, double cell_m) {
  const double square_m2 = cell_m * cell_m;
  // Two cells along z.
  if (covariance_m2.diagonal().maxCoeff() > 4.0 * square_m2) return false;
  return symmetric_eigen<3>(covariance_m2).values[0] >= -kRoundingShare * square_m2;
}

class BodyReader {
 public:
  BodyReader(std::span<const std::byte> body, const ApolloConfig& config,
             const ApolloNodeIndex& index, const std::string& file)
      : reader_(body), config_(config), index_(index), file_(file) {
    cell_m_ = config.cells_m[index.resolution];
  }

  Result<ApolloNode> read() {
    const auto rows = reader_.get<std::uint32_t>();
    const auto columns = reader_.get<std::uint32_t>();
    if (!reader_.ok()) return cut();
    if (rows != config_.node_rows || columns != config_.node_columns) {
      return Error{ErrorCode::kMalformedHeader,
                   concat("found ", rows, " rows of ", columns, ", expected ", config_.node_rows,
                          " of ", config_.node_columns, " as in config.xml"),
                   file_, at_byte_of_body(0)};
    }
    for (std::uint32_t row = 0; row < rows; ++row) {
      for (std::uint32_t column = 0; column < columns; ++column) {
        if (!read_column(corner_key(config_.min_x_m, index_.n, columns) + column,
                         corner_key(config_.min_y_m, index_.m, rows) + row)) {
          return cut();
        }
      }
    }
    if (reader_.at_end()) return std::move(node_);
    return Error{ErrorCode::kMalformedHeader,
                 concat("found ", reader_.remaining(), " bytes after the last column"), file_,
                 at_byte_of_body(reader_.offset())};
  }

 private:
  [[nodiscard]] Error cut() const {
    return {ErrorCode::kTruncatedScan, "the body ends within a column", file_,
            at_byte_of_body(reader_.offset())};
  }

  // Of a node's first cell; open_apollo_map has checked that it is whole.
  [[nodiscard]] double corner_key(double from_m, std::uint32_t node, std::uint32_t size) const {
    return std::round(from_m / cell_m_) + static_cast<double>(node) * size;
  }

  bool read_column(double key_x, double key_y) {
    const auto count = reader_.get<std::uint32_t>();
    if (!reader_.ok() || count > reader_.remaining() / kLeastCellSize) return false;
    for (std::uint32_t i = 0; i < count && reader_.ok(); ++i) read_cell(key_x, key_y);
    reader_.get<std::int32_t>();  // highest
    reader_.get<std::int32_t>();  // lowest
    const auto road_count = reader_.get<std::uint32_t>();
    if (!reader_.ok() || road_count > reader_.remaining() / sizeof(std::int32_t)) return false;
    for (std::uint32_t i = 0; i < road_count; ++i) reader_.get<std::int32_t>();
    return reader_.ok();
  }

  Eigen::Matrix3d matrix() {
    Eigen::Matrix3d values;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) values(i, j) = reader_.get<float>();
    }
    return values;
  }

  void read_cell(double key_x, double key_y) {
    const auto key_z = reader_.get<std::int32_t>();
    reader_.get<float>();          // intensity
    reader_.get<float>();          // its variance
    reader_.get<std::uint32_t>();  // points on the road
    ForeignNd nd;
    reader_.get(nd.point_count);
    Eigen::Vector3d mean_m;
    for (int i = 0; i < 3; ++i) mean_m[i] = reader_.get<float>();
    const Eigen::Matrix3d products_m2 = matrix();
    if (nd.point_count >= kInverseFrom_points) {
      matrix();
      reader_.get<std::uint8_t>();
    }
    if (reader_.ok()) add(nd, {key_x, key_y, static_cast<double>(key_z)}, mean_m, products_m2);
  }

  void add(ForeignNd& nd, const Eigen::Vector3d& key, const Eigen::Vector3d& mean_m,
           const Eigen::Matrix3d& products_m2) {
    // A grid of CellKey, with the cells beside it.
    constexpr double kMostKey = 0x1.0p30;
    const bool is_count = nd.point_count <= std::numeric_limits<std::int32_t>::max();
    const bool is_near = mean_m.allFinite() && mean_m.cwiseAbs().maxCoeff() <= 2.0 * cell_m_ &&
                         key.cwiseAbs().maxCoeff() < kMostKey;
    if (!is_count || !is_near || !products_m2.allFinite()) {
      ++node_.damaged_count;
      return;
    }
    node_.point_count += nd.point_count;
    if (nd.point_count < 2) {
      ++node_.single_point_count;
      return;
    }
    const auto count = static_cast<double>(nd.point_count);
    const Eigen::Matrix3d raw_m2 =
        count / (count - 1.0) * (products_m2 - mean_m * mean_m.transpose());
    nd.covariance_m2 = 0.5 * (raw_m2 + raw_m2.transpose());
    if (!is_covariance(nd.covariance_m2, cell_m_)) {
      ++node_.damaged_count;
      return;
    }
    AxisPlace places[3];
    for (int i = 0; i < 3; ++i) {
      places[i] = place_of(key[i], mean_m[i], cell_m_);
      nd.mean_in_cell_m[i] = places[i].in_cell_m;
    }
    nd.key_world = {static_cast<std::int32_t>(places[0].key),
                    static_cast<std::int32_t>(places[1].key),
                    static_cast<std::int32_t>(places[2].key)};
    node_.nds.push_back(nd);
  }

  ByteReader reader_;
  const ApolloConfig& config_;
  const ApolloNodeIndex& index_;
  const std::string& file_;
  double cell_m_ = 0.0;
  ApolloNode node_;
};

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
      return error(ErrorCode::kMalformedText, "node_size is not a whole number of cells");
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
                 concat("found ", config.cells_m.size(), " resolutions and ",
                        config.heights_m.size(), " of z, expected equal numbers"));
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
                 concat("found an Apollo map of version '", version.substr(0, 40),
                        "', expected map_ndt_v01. Other maps of Apollo contain intensities and "
                        "heights, but no distributions to match with"));
  }

  [[nodiscard]] Result<double> number_of(std::string_view text, const std::string& name,
                                         double least, double most) const {
    const std::optional<double> found = finite_number(text);
    if (!found) {
      return error(text.empty() ? ErrorCode::kMissingField : ErrorCode::kMalformedText,
                   concat(name, ": found '", text.substr(0, 40), "', expected a number"));
    }
    if (*found >= least && *found <= most) return *found;
    return error(ErrorCode::kUnsupportedFormat,
                 concat(name, ": found ", text.substr(0, 40), ", which is out of range"));
  }

  [[nodiscard]] Result<double> number(const char* group, const char* name, double least,
                                      double most) const {
    const XMLElement* parent = config_.FirstChildElement(group);
    const XMLElement* child = parent == nullptr ? nullptr : parent->FirstChildElement(name);
    return number_of(text_of(child), concat(group, ".", name), least, most);
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

Result<ApolloNode> parse_apollo_node(std::span<const std::byte> bytes, const ApolloConfig& config,
                                     const ApolloNodeIndex& index, const std::string& file) {
  SIGHTLINE_CHECK(index.resolution < config.cells_m.size());
  SIGHTLINE_ASSIGN(const std::span<const std::byte> packed, packed_body(bytes, index, file));
  if (!config.is_compressed) return BodyReader(packed, config, index, file).read();
  SIGHTLINE_ASSIGN(const std::vector<std::byte> body, unpack(packed, most_bytes(config), file));
  return BodyReader(body, config, index, file).read();
}

Result<ApolloConfig> parse_apollo_config(std::string_view text, const std::string& file) {
  tinyxml2::XMLDocument document;
  if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
    return Error{ErrorCode::kMalformedText,
                 std::string("the file is not valid XML: ") + document.ErrorName(), file,
                 concat("line ", document.ErrorLineNum())};
  }
  const XMLElement* root = document.FirstChildElement("map");
  const XMLElement* config = root == nullptr ? nullptr : root->FirstChildElement("map_config");
  if (config == nullptr) {
    return Error{ErrorCode::kMissingField, "found no map.map_config; expected Apollo's config.xml",
                 file};
  }
  return ConfigReader(*config, file).read();
}

}  // namespace sightline
