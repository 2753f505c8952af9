#include <lz4frame.h>
#include <sqlite3.h>
#include <zstd.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "formats/base/check.h"
#include "tests/fuzz/seed.h"

namespace sightline {
namespace {

// ---- Messages in CDR. Texts are as long as the alignment of what follows asks for.

const std::string kCdr("\0\1\0\0", 4);

std::string header(std::uint32_t seconds) {
  return raw(seconds) + raw(std::uint32_t{0}) + sized(std::string("lid\0", 4));
}

std::string cloud(std::uint32_t seconds) {
  std::string bytes = kCdr + header(seconds) + raw(std::array<std::uint32_t, 3>{1, 2, 4});
  for (std::uint32_t i = 0; i < 4; ++i) {
    bytes += sized(std::string{"xyzt"[i], '\0', '\0', '\0'}) + raw(4 * i);
    bytes += std::string("\7\0\0\0", 4) + raw(std::uint32_t{1});
  }
  bytes += std::string(4, '\0') + raw(std::array<std::uint32_t, 2>{16, 32});
  return bytes + sized(raw(std::array<float, 8>{1, 2, 3, 0, 4, 5, 6, 0.1F})) + '\1';
}

std::string pose(std::uint32_t seconds) {
  return kCdr + header(seconds) + raw(std::array<double, 7>{1, 2, 3, 0, 0, 0, 1});
}

// "map" to "bas": the position begins at a multiple of 8 behind the two frames.
std::string transforms(std::uint32_t seconds) {
  const std::string frames = sized(std::string("map\0", 4)) + sized(std::string("base_link\0", 10));
  std::string bytes = raw(std::uint32_t{1}) + raw(seconds) + raw(std::uint32_t{0}) + frames;
  bytes += std::string((8 - bytes.size() % 8) % 8, '\0');
  return kCdr + bytes + raw(std::array<double, 7>{seconds * 1.0, 2, 3, 0, 0, 0, 1});
}

std::string livox(std::uint32_t seconds) {
  std::string bytes = kCdr + header(seconds) + raw(std::uint64_t{7}) + raw(std::uint32_t{2});
  bytes += std::string(4, '\1') + raw(std::uint32_t{2});
  for (std::uint32_t i = 0; i < 2; ++i) {
    bytes += raw(5'000'000 * i) + raw(std::array<float, 3>{1, 2, 3}) + std::string(4, '\1');
  }
  return bytes;
}

// About the axes of the scans' frame: sensor_msgs/Imu has 37 numbers, of which three are the rate.
std::string imu(std::uint32_t seconds) {
  std::array<double, 37> numbers{};
  numbers[13] = 0.5;
  return kCdr + header(seconds) + raw(numbers);
}

struct Topic {
  std::string name;
  std::string type;
  std::string (*message)(std::uint32_t seconds);
};
const std::array<Topic, 5> kTopics = {{{"/points", "sensor_msgs/msg/PointCloud2", &cloud},
                                       {"/pose", "geometry_msgs/msg/PoseStamped", &pose},
                                       {"/tf", "tf2_msgs/msg/TFMessage", &transforms},
                                       {"/livox", "livox_ros_driver2/msg/CustomMsg", &livox},
                                       {"/imu", "sensor_msgs/msg/Imu", &imu}}};

std::string record(char op, const std::string& data) {
  return std::string(1, op) + raw(std::uint64_t{data.size()}) + data;
}

std::string descriptions() {
  std::string bytes;
  for (std::uint16_t i = 0; i < kTopics.size(); ++i) {
    const auto id = static_cast<std::uint16_t>(i + 1);
    bytes += record(3, raw(id) + sized(kTopics.at(i).type) + sized("ros2msg") + sized(""));
    bytes += record(4, raw(i) + raw(id) + sized(kTopics.at(i).name) + sized("cdr") + sized(""));
  }
  return bytes;
}

std::string messages(std::uint32_t seconds) {
  std::string bytes;
  for (std::uint16_t i = 0; i < kTopics.size(); ++i) {
    const std::string times = raw(std::array<std::uint64_t, 2>{seconds, seconds});
    bytes += record(5, raw(i) + raw(seconds) + times + kTopics.at(i).message(seconds));
  }
  return bytes;
}

std::string packed(const std::string& compression, const std::string& bytes) {
  std::string made(bytes.size() + 1000, '\0');
  if (compression.empty()) return bytes;
  const std::size_t size =
      compression == "lz4"
          ? LZ4F_compressFrame(made.data(), made.size(), bytes.data(), bytes.size(), nullptr)
          : ZSTD_compress(made.data(), made.size(), bytes.data(), bytes.size(), 3);
  SIGHTLINE_CHECK(size <= made.size());
  return made.substr(0, size);
}

std::string chunk(const std::string& compression, const std::string& records, bool is_indexed) {
  const std::string data = packed(compression, records);
  std::string bytes =
      record(6, raw(std::array<std::uint64_t, 3>{7, 8, records.size()}) + raw(std::uint32_t{0}) +
                    sized(compression) + raw(std::uint64_t{data.size()}) + data);
  for (std::uint16_t i = 0; is_indexed && i < kTopics.size(); ++i) {
    bytes += record(7, raw(i) + sized(raw(std::array<std::uint64_t, 2>{7, 0})));
  }
  return bytes;
}

std::string mcap(const std::string& data, bool is_closed) {
  const std::string magic("\x89MCAP0\r\n");
  const std::string begin = magic + record(1, sized("ros2") + sized("tests")) + data;
  if (!is_closed) return begin;
  return begin + record(15, raw(std::uint32_t{0})) + descriptions() +
         record(2, std::string(20, '\0')) + magic;
}

void add_mcaps(std::vector<Seed>& seeds) {
  for (const char* compression : {"", "lz4", "zstd"}) {
    const std::string name = *compression == '\0' ? "none" : compression;
    add_seed(seeds, "mcap/seed_" + name,
             mcap(chunk(compression, descriptions() + messages(7), true) +
                      chunk(compression, messages(8), true),
                  true));
  }
  add_seed(seeds, "mcap/seed_without_index",
           mcap(chunk("", descriptions() + messages(7), false), true));
  add_seed(seeds, "mcap/seed_without_chunks",
           mcap(descriptions() + messages(7) + messages(8), true));
  add_seed(seeds, "mcap/seed_not_closed",
           mcap(chunk("", descriptions() + messages(7), true), false));
}

void run(sqlite3* database, const std::string& sql) {
  SIGHTLINE_CHECK(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK);
}

std::string hex(const std::string& bytes) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text;
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    text += {kDigits[byte / 16], kDigits[byte % 16]};
  }
  return text;
}

std::string db3(bool is_packed) {
  sqlite3* made = nullptr;
  SIGHTLINE_CHECK(sqlite3_open(":memory:", &made) == SQLITE_OK);
  const std::unique_ptr<sqlite3, decltype(&sqlite3_close)> database(made, &sqlite3_close);
  run(made, "PRAGMA page_size = 512");
  run(made,
      "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,"
      "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);"
      "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,"
      "timestamp INTEGER NOT NULL, data BLOB NOT NULL);"
      "CREATE INDEX timestamp_idx ON messages (timestamp ASC);");
  for (std::size_t i = 0; i < kTopics.size(); ++i) {
    const Topic& topic = kTopics.at(i);
    const std::string id = std::to_string(i + 1);
    run(made, "INSERT INTO topics VALUES (" + id + ", '" + topic.name + "', '" + topic.type +
                  "', 'cdr', '')");
    for (const std::uint32_t seconds : {7U, 8U}) {
      const std::string message = topic.message(seconds);
      run(made, "INSERT INTO messages(topic_id, timestamp, data) VALUES (" + id + ", " +
                    std::to_string(seconds) + ", x'" +
                    hex(is_packed ? packed("zstd", message) : message) + "')");
    }
  }
  sqlite3_int64 size = 0;
  const std::unique_ptr<unsigned char, decltype(&sqlite3_free)> bytes(
      sqlite3_serialize(made, "main", &size, 0), &sqlite3_free);
  return {reinterpret_cast<const char*>(bytes.get()), static_cast<std::size_t>(size)};
}

}  // namespace

void add_ros2_seeds(std::vector<Seed>& seeds) {
  add_mcaps(seeds);
  add_seed(seeds, "db3/seed_plain", db3(false));
  add_seed(seeds, "db3/seed_packed", db3(true));
}

}  // namespace sightline
