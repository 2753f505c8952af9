#include <bzlib.h>
#include <lz4frame.h>

#include <array>
#include <cstdint>
#include <map>

#include "formats/base/check.h"
#include "tests/formats/foreign/maps/apollo_writer.h"
#include "tests/fuzz/seed.h"

namespace sightline {
namespace {

std::string record(char op, const std::map<std::string, std::string>& fields,
                   const std::string& data) {
  std::string header = sized(std::string("op=") + op);
  for (const auto& [name, value] : fields) header += sized(name + "=" + value);
  return sized(header) + sized(data);
}

std::string ros_header() { return raw(std::array<std::uint32_t, 3>{0, 7, 0}) + sized("lid"); }

std::string cloud() {
  std::string bytes = ros_header() + raw(std::array<std::uint32_t, 3>{1, 2, 4});
  const std::array<std::string, 4> names = {"x", "y", "z", "t"};
  for (std::uint32_t i = 0; i < 4; ++i) {
    bytes += sized(names.at(i)) + raw(4 * i) + '\7' + raw(std::uint32_t{1});
  }
  bytes += '\0' + raw(std::array<std::uint32_t, 2>{16, 32});
  return bytes + sized(raw(std::array<float, 8>{1, 2, 3, 0, 4, 5, 6, 0.1F})) + '\1';
}

std::string pose() { return ros_header() + raw(std::array<double, 7>{1, 2, 3, 0, 0, 0, 1}); }

// About the axes of the scans' frame: sensor_msgs/Imu has 37 numbers, of which three are the rate.
std::string imu() {
  std::array<double, 37> numbers{};
  numbers[13] = 0.5;
  return ros_header() + raw(numbers);
}

std::string connection(std::uint32_t number, const std::string& topic, const std::string& type) {
  return record(7, {{"conn", raw(number)}, {"topic", topic}},
                sized("topic=" + topic) + sized("type=" + type) + sized("md5sum=*") +
                    sized("message_definition="));
}

std::string message(std::uint32_t number, std::uint32_t seconds, const std::string& bytes) {
  return record(2, {{"conn", raw(number)}, {"time", raw(std::uint64_t{seconds})}}, bytes);
}

std::string packed(const std::string& compression, const std::string& bytes) {
  std::string made(bytes.size() + 1000, '\0');
  if (compression == "none") return bytes;
  if (compression == "lz4") {
    const std::size_t size =
        LZ4F_compressFrame(made.data(), made.size(), bytes.data(), bytes.size(), nullptr);
    SIGHTLINE_CHECK(LZ4F_isError(size) == 0);
    return made.substr(0, size);
  }
  auto size = static_cast<unsigned>(made.size());
  std::string source = bytes;
  SIGHTLINE_CHECK(BZ2_bzBuffToBuffCompress(made.data(), &size, source.data(),
                                           static_cast<unsigned>(source.size()), 9, 0, 0) == BZ_OK);
  return made.substr(0, size);
}

// Two chunks: a scan, a pose and a turn rate, then a scan. Not closed: the index is not there.
std::string bag(const std::string& compression, bool is_closed) {
  const std::string connections = connection(0, "/points", "sensor_msgs/PointCloud2") +
                                  connection(1, "/pose", "geometry_msgs/PoseStamped") +
                                  connection(2, "/imu", "sensor_msgs/Imu");
  const std::array<std::string, 2> chunks = {
      connections + message(0, 7, cloud()) + message(1, 7, pose()) + message(2, 7, imu()),
      message(0, 8, cloud())};
  const auto header = [&](std::uint64_t index, std::uint32_t topics, std::uint32_t count) {
    const std::map<std::string, std::string> fields = {
        {"index_pos", raw(index)}, {"conn_count", raw(topics)}, {"chunk_count", raw(count)}};
    return "#ROSBAG V2.0\n" + record(3, fields, std::string(16, ' '));
  };
  std::string file = header(0, 0, 0);
  std::string index = connections;
  for (std::uint32_t i = 0; i < 2; ++i) {
    const std::string counts = i == 0 ? raw(std::array<std::uint32_t, 6>{0, 1, 1, 1, 2, 1})
                                      : raw(std::array<std::uint32_t, 2>{0, 1});
    const auto connection_count = static_cast<std::uint32_t>(counts.size() / 8);
    index += record(6,
                    {{"ver", raw(std::uint32_t{1})},
                     {"chunk_pos", raw(std::uint64_t{file.size()})},
                     {"start_time", raw(std::uint64_t{7})},
                     {"end_time", raw(std::uint64_t{8})},
                     {"count", raw(connection_count)}},
                    counts);
    const auto size = static_cast<std::uint32_t>(chunks.at(i).size());
    file += record(5, {{"compression", compression}, {"size", raw(size)}},
                   packed(compression, chunks.at(i)));
    for (std::uint32_t k = 0; k < connection_count; ++k) {
      const std::map<std::string, std::string> fields = {
          {"ver", raw(std::uint32_t{1})}, {"conn", raw(k)}, {"count", raw(std::uint32_t{1})}};
      file += record(4, fields, raw(std::array<std::uint32_t, 3>{7 + i, 0, 0}));
    }
  }
  if (!is_closed) return file;
  return header(file.size(), 3, 2) + file.substr(header(0, 0, 0).size()) + index;
}

void add_bags(std::vector<Seed>& seeds) {
  for (const char* compression : {"none", "bz2", "lz4"}) {
    add_seed(seeds, std::string("bag/seed_") + compression, bag(compression, true));
  }
  add_seed(seeds, "bag/seed_not_closed", bag("none", false));
}

// ---- Text. The first byte decides fuzz_poses what the file is.

void add_poses(std::vector<Seed>& seeds) {
  add_seed(seeds, "poses/seed_stamps", 0, "# t\n1567410201.7452047\n1567410201845204734\n1.6e9\n");
  add_seed(seeds, "poses/seed_errors", 1, "scan,look,start,error\n0,10,0,0.042\n0,20,1,1e-3\n");
  add_seed(seeds, "poses/seed_kitti", 3,
           "1 0 0 1.5 0 1 0 -2 0 0 1 0.25\n0 -1 0 2 1 0 0 3 0 0 1 4\n");
  add_seed(seeds, "poses/seed_tum", 4, "# tum\n1.5 1 2 3 0 0 0 1\n1.6,1,2,3,0,0,0.6,0.8\n");
  add_seed(seeds, "poses/seed_apollo", 5, "0 1.5 1 2 3 0 0 0 1\n7\t1.6\t1\t2\t3\t1\t0\t0\t0\n");
}

// ---- What lies beside scans: the first byte decides fuzz_sensor what the file is.

void add_beside_scans(std::vector<Seed>& seeds) {
  add_seed(seeds, "sensor/seed_gnss", 0,
           "time,lat,lon,height,roll,pitch,heading\n1.5,49,8.4,115,0.1,-0.2,90\n"
           "2.5,49.00001,8.4,115,0.1,-0.2,91\n");
  add_seed(seeds, "sensor/seed_places", 0, "lat;lon_rad\n49;0.1466\n49.0001;0.1466\n");
  add_seed(seeds, "sensor/seed_nmea", 0,
           "$GPGGA,123519.5,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,\n"
           "$GPRMC,123519.5,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W\n"
           "$GPHDT,274.07,T\n$PASHR,123519.5,84.4,T,0.1,-0.2,0,0,0,0\n");
  add_seed(seeds, "sensor/seed_beams", 1,
           "name: roof\nbeams_deg: [-15, -13.5, 2]\nazimuth_step_deg: 0.2\n");
  add_seed(seeds, "sensor/seed_even", 1,
           "beams: 32\nlowest_beam_deg: -16\nhighest_beam_deg: 15\nheight_m: 2\n");
  add_seed(seeds, "sensor/seed_view", 1,
           "beams: 9\nlowest_beam_deg: -4\nhighest_beam_deg: 4\nazimuth_view_deg: 70.4\n");
  add_seed(seeds, "sensor/seed_hesai", 2, "Channel,Elevation,Azimuth\n1,14.8,-1\n2,11,-1\n");
  add_seed(seeds, "sensor/seed_ouster", 3,
           R"({"beam_intrinsics":{"beam_altitude_angles":[20.1,0.5,-21]},)"
           R"("lidar_mode":"1024x10","prod_line":"OS-1-32"})");
  add_seed(seeds, "sensor/seed_tr", 4, "P0: 1 2\nTr: 0 -1 0 0.1 0 0 -1 -0.2 1 0 0 -0.3\n");
  add_seed(seeds, "sensor/seed_imu", 4, "R: 1 0 0 0 1 0 0 0 1\nT: -0.8 0.3 -0.8\n");
  add_seed(seeds, "sensor/seed_nuscenes", 5,
           R"([{"token":"a","timestamp":1532402927647951,"rotation":[0.8,0,0,0.6],)"
           R"("translation":[411.3,1180.9,0]},{"timestamp":1,"rotation":[1,0,0,0],)"
           R"("translation":[0,0,0]}])");
  const std::string head = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 4), }\n";
  const std::string fields =
      "{'descr': [('x', '<f4'), ('y', '>f4'), ('z', '<f8'), ('i', '|u1')], "
      "'fortran_order': False, 'shape': (1,), }\n";
  const auto npy = [](const std::string& text, const std::string& numbers) {
    return std::string("\3\x93NUMPY\1\0", 9) + raw(static_cast<std::uint16_t>(text.size())) + text +
           numbers;
  };
  add_seed(seeds, "clouds/seed_npy", npy(head, std::string(32, '\x3f')));
  add_seed(seeds, "clouds/seed_npy_fields", npy(fields, std::string(17, '\x3f')));
}

// The first byte decides fuzz_apollo what the rest is.
void add_apollo(std::vector<Seed>& seeds) {
  ApolloTestNode node{2, 2, {}};
  node.cells[{0, 1, 3}] = {12, {0.25, 0.5, 0.75}, Eigen::Matrix3d::Identity()};
  node.cells[{1, 0, -2}] = {2, {0.5, 0.5, -0.5}, Eigen::Matrix3d::Identity()};
  const std::string body = apollo_body(node);
  const ApolloTestIndex index{0, 10, 1, 1};
  add_seed(seeds, "apollo/seed_config", 0, apollo_config(1.0, 128));
  add_seed(seeds, "apollo/seed_plain", 1, apollo_file(index, body));
  add_seed(seeds, "apollo/seed_packed", 2, apollo_file(index, zlib_packed(body)));
}

// The first byte decides fuzz_lanes which form it is, and of which world.
void add_lanes(std::vector<Seed>& seeds) {
  const auto node = [](int id, const std::string& place, const std::string& local) {
    return "<node id=\"" + std::to_string(id) + "\" " + place + ">" + local +
           "<tag k=\"ele\" v=\"5\"/></node>\n";
  };
  const auto lanes = [&](const std::array<std::string, 4>& places,
                         const std::array<std::string, 4>& locals) {
    std::string text = "<?xml version=\"1.0\"?>\n<osm version=\"0.6\"><!-- two lanes -->\n";
    for (std::size_t i = 0; i < 4; ++i) {
      text += node(static_cast<int>(i) + 1, places.at(i), locals.at(i));
    }
    return text +
           "<way id=\"11\"><nd ref=\"1\"/><nd ref=\"2\"/></way>\n"
           "<way id=\"12\"><nd ref=\"4\"/><nd ref=\"3\"/></way>\n"
           "<relation id=\"100\"><member type=\"way\" role=\"left\" ref=\"11\"/>"
           "<member type=\"way\" role=\"right\" ref=\"12\"/><tag k='type' v='lanelet'/>"
           "<tag k=\"one_way\" v=\"no\"/><tag k=\"name\" v=\"A &amp; B\"/></relation>\n"
           "<relation id=\"101\"><member type=\"way\" role=\"left\" ref=\"12\"/>"
           "<member type=\"way\" role=\"right\" ref=\"11\"/><tag k=\"type\" v=\"lanelet\"/>"
           "<tag k=\"subtype\" v=\"crosswalk\"/></relation>\n</osm>\n";
  };
  const auto local = [](const char* x, const char* y) {
    return std::string("<tag k=\"local_x\" v=\"") + x + "\"/><tag k=\"local_y\" v=\"" + y + "\"/>";
  };
  const std::string none = R"(lat="" lon="")";
  add_seed(seeds, "lanes/seed_local", 0,
           lanes({none, none, none, none},
                 {local("0", "2"), local("9", "2"), local("9", "-2"), local("0", "-2")}));
  add_seed(seeds, "lanes/seed_degrees", 1,
           lanes({R"(lat="49.0001" lon="8.4")", R"(lat="49.0001" lon="8.4001")",
                  R"(lat="49" lon="8.4001")", R"(lat="49" lon="8.4")"},
                 {"", "", "", ""}));
  add_seed(seeds, "lanes/seed_geojson", 3,
           R"({"type":"FeatureCollection","features":[{"type":"Feature","geometry":)"
           R"({"type":"LineString","coordinates":[[8.39,48.98,115],[8.391,48.98,116]]}},)"
           R"({"type":"Feature","geometry":{"type":"MultiLineString","coordinates":)"
           R"([[[8.4,49],[8.41,49]],[[8.4,49.1],[8.41,49.1]]]}}]})");
  add_seed(seeds, "lanes/seed_metres", 2,
           R"({"type":"LineString","coordinates":[[0,0],[10,0],[10,5.5]]})");
  add_seed(seeds, "lanes/seed_named", 4, "line,x,y,z\nA,0,0,1\nA,1,0,1\nB,5,5,1\nB,6,5,1\n");
  add_seed(seeds, "lanes/seed_bare", 4, "# lines\n0 0 2\n1 0 2\n\n5 5 2\n6 5 2\n");
}

void add_yaml(std::vector<Seed>& seeds) {
  add_seed(
      seeds, "config/seed_drives",
      "annotation:\n  looks: paper\n  ranges_m: [10, 20.5, 40]\n  limits_m: [0.1, 0.25]\n"
      "mapping: {name: a, scans: velodyne/, poses: poses.txt, pose_format: tum, rate_hz: 10}\n"
      "mapping-2:\n  scans: b.bag\n  topic: /points\n  columns: x y z intensity\n"
      "localization: &other\n  scans: c.pcap\n  sensor: vlp-16\n  lidar_yaw_deg: -1.5\n"
      "evaluation: *other\n"
      "import-errors: {file: e.csv, localizer: ours, parameters: \"a=1, b=2\", reference: known}\n"
      "gate: {rules: {expected-coverage: 0.9}}\n---\n");
  add_seed(
      seeds, "gate/seed_rules",
      "gate:\n  stretch_m: 50\n  fails_at: warning\n"
      "  rules:\n    expected-coverage: {severity: warning, allowed: 0.9, at_limits: {0.1: 0.8}}\n"
      "  exceptions:\n"
      "    - {rule: \"*\", limit_m: 0.1, circle: [1, 2, 3.5], reason: r, until: 2027-02-28}\n"
      "    - {rule: expected-coverage, box: [0, 0, 1, 1], reason: r, until: 2028-02-29}\n"
      "    - rule: expected-coverage\n      route: {run: 0, from_m: 1, to_m: 2}\n"
      "      reason: 'r'\n      until: \"2030-12-31\"\n");
}

}  // namespace

void add_foreign_seeds(std::vector<Seed>& seeds) {
  add_bags(seeds);
  add_poses(seeds);
  add_beside_scans(seeds);
  add_lanes(seeds);
  add_apollo(seeds);
  add_yaml(seeds);
}

}  // namespace sightline
