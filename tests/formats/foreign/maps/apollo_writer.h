#pragma once

#include <zlib.h>

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <map>
#include <string>
#include <tuple>
#include <vector>

// Writes Apollo's NDT maps as its own map creator does, for tests; shares nothing with the reader.

namespace sightline {

struct ApolloTestCell {
  std::uint32_t count = 0;
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();       // from the cell's corner
  Eigen::Matrix3d products_m2 = Eigen::Matrix3d::Zero();  // mean of outer products
};

struct ApolloTestNode {
  std::uint32_t rows = 0;
  std::uint32_t columns = 0;
  std::map<std::tuple<std::uint32_t, std::uint32_t, std::int32_t>, ApolloTestCell> cells;
};

template <class T>
void put(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof raw);
}

inline std::string apollo_body(const ApolloTestNode& node) {
  std::string bytes;
  put(bytes, node.rows);
  put(bytes, node.columns);
  auto cell = node.cells.begin();
  for (std::uint32_t row = 0; row < node.rows; ++row) {
    for (std::uint32_t column = 0; column < node.columns; ++column) {
      std::string of_column;
      std::uint32_t count = 0;
      for (; cell != node.cells.end() && std::get<0>(cell->first) == row &&
             std::get<1>(cell->first) == column;
           ++cell, ++count) {
        const ApolloTestCell& values = cell->second;
        put(of_column, std::get<2>(cell->first));
        put(of_column, 17.5F);  // intensity
        put(of_column, 3.25F);
        put(of_column, std::uint32_t{1});  // on the road
        put(of_column, values.count);
        for (int i = 0; i < 3; ++i) put(of_column, static_cast<float>(values.mean_m[i]));
        for (int i = 0; i < 9; ++i) {
          put(of_column, static_cast<float>(values.products_m2(i / 3, i % 3)));
        }
        if (values.count < 6) continue;
        for (int i = 0; i < 9; ++i) put(of_column, i % 4 == 0 ? 1.0F : 0.0F);
        put(of_column, std::uint8_t{1});
      }
      put(bytes, count);
      bytes += of_column;
      put(bytes, std::int32_t{9});
      put(bytes, std::int32_t{-9});
      put(bytes, count);  // on the road
      for (std::uint32_t i = 0; i < count; ++i) put(bytes, std::int32_t{3});
    }
  }
  return bytes;
}

inline std::string zlib_packed(const std::string& bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::string packed(size, '\0');
  compress(reinterpret_cast<Bytef*>(packed.data()), &size,
           reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uLong>(bytes.size()));
  packed.resize(size);
  return packed;
}

struct ApolloTestIndex {
  std::uint32_t resolution = 0;
  std::int32_t zone = 10;
  std::uint32_t m = 0;
  std::uint32_t n = 0;
};

inline std::string apollo_file(const ApolloTestIndex& index, const std::string& body) {
  std::string bytes;
  put(bytes, index.resolution);
  put(bytes, index.zone);
  put(bytes, index.m);
  put(bytes, index.n);
  put(bytes, static_cast<std::uint32_t>(body.size()));
  return bytes + body;
}

inline std::string apollo_path(const ApolloTestIndex& index) {
  char text[64];
  std::snprintf(text, sizeof text, "map/%03u/%s/%02d/%08u/%08u", index.resolution,
                index.zone > 0 ? "north" : "south", std::abs(index.zone), index.m, index.n);
  return text;
}

inline std::string apollo_config(double cell_m, std::uint32_t node_cells,
                                 bool is_compressed = true) {
  char text[600];
  std::snprintf(text, sizeof text,
                "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<map><map_config><version>map_ndt_v01"
                "</version><node_size><x>%u</x><y>%u</y></node_size><range><min_x>0</min_x>"
                "<min_y>0</min_y></range><compression>%s</compression><resolutions><resolution>%g"
                "</resolution></resolutions><resolutions_z><resolution>%g</resolution>"
                "</resolutions_z></map_config></map>",
                node_cells, node_cells, is_compressed ? "true" : "false", cell_m, cell_m);
  return text;
}

// Points of UTM as nodes, by m and n. Altitudes are cut towards zero.
inline std::map<std::pair<std::uint32_t, std::uint32_t>, ApolloTestNode> apollo_nodes(
    const std::vector<Eigen::Vector3d>& points_m, double cell_m, std::uint32_t node_cells) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, ApolloTestNode> nodes;
  const double node_m = cell_m * node_cells;
  for (const Eigen::Vector3d& point_m : points_m) {
    const auto n = static_cast<std::uint32_t>(point_m.x() / node_m);
    const auto m = static_cast<std::uint32_t>(point_m.y() / node_m);
    ApolloTestNode& node = nodes[{m, n}];
    node.rows = node.columns = node_cells;
    const Eigen::Vector2d in_node_m(point_m.x() - n * node_m, point_m.y() - m * node_m);
    const auto column = static_cast<std::uint32_t>(in_node_m.x() / cell_m);
    const auto row = static_cast<std::uint32_t>(in_node_m.y() / cell_m);
    const auto altitude = static_cast<std::int32_t>(point_m.z() / cell_m);
    ApolloTestCell& cell = node.cells[{row, column, altitude}];
    const Eigen::Vector3d in_cell_m(in_node_m.x() - column * cell_m, in_node_m.y() - row * cell_m,
                                    point_m.z() - altitude * cell_m);
    ++cell.count;
    cell.mean_m += (in_cell_m - cell.mean_m) / cell.count;
    const Eigen::Matrix3d product_m2 = in_cell_m * in_cell_m.transpose();
    cell.products_m2 += (product_m2 - cell.products_m2) / cell.count;
  }
  return nodes;
}

// A node of two by two cells of 1 m: one of 12 points, one of a single one.
inline ApolloTestNode small_node() {
  ApolloTestNode node{2, 2, {}};
  ApolloTestCell cell{12, {0.25, 0.5, 0.75}, {}};
  cell.products_m2 = cell.mean_m * cell.mean_m.transpose() +
                     Eigen::Matrix3d(Eigen::Vector3d(0.01, 0.02, 0.03).asDiagonal());
  node.cells[{0, 1, 3}] = cell;
  node.cells[{1, 0, -2}] = {1, {0.5, 0.5, -0.5}, Eigen::Matrix3d::Constant(0.25)};
  return node;
}

}  // namespace sightline
