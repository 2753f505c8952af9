#pragma once

#include <gmock/gmock.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>

#include "formats/base/files/atomic_file.h"
#include "formats/foreign/clouds/read_point_cloud.h"
#include "tests/support/value_of.h"

namespace sightline {

using testing::HasSubstr;

class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "sightline-XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  [[nodiscard]] std::filesystem::path operator/(std::string_view name) const {
    return path_ / name;
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  std::filesystem::path write(std::string_view name, std::string_view text) const {
    const std::filesystem::path file = path_ / name;
    EXPECT_TRUE(write_file_atomically(file, text, IfExists::kReplace).has_value());
    return file;
  }

 private:
  std::filesystem::path path_;
};

inline Result<PointCloudFile> parse_text(std::string_view text, const std::string& name,
                                         const std::optional<FloatColumns>& columns = {}) {
  return parse_point_cloud(std::as_bytes(std::span(text)), name, columns);
}

template <class T>
std::string as_bytes(std::initializer_list<T> values) {
  std::string bytes;
  for (const T value : values) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof value);
    bytes.append(raw, sizeof value);
  }
  return bytes;
}

// Points in a spiral, `columns` floats each: x y z, then whole numbers.
inline std::string float_spiral(std::size_t columns, std::size_t points = 1600) {
  std::string bytes;
  for (std::size_t i = 0; i < points; ++i) {
    const auto turn = static_cast<float>(i);
    bytes += as_bytes({(5.0F + 0.1F * turn) * std::cos(turn), (5.0F + 0.1F * turn) * std::sin(turn),
                       0.3F + 0.001F * turn});
    for (std::size_t k = 3; k < columns; ++k) bytes += as_bytes({static_cast<float>(i * k % 16)});
  }
  return bytes;
}

// Every shorter version is refused, or says that it may be cut; none crashes. Text may end without
// its last line end, which changes nothing, and within its last number, which is flagged.
inline void expect_every_cut_is_noticed(const std::string& whole, const std::string& name) {
  EXPECT_FALSE(value_of(parse_text(whole, name)).may_be_cut);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Result<PointCloudFile> cut = parse_text(whole.substr(0, size), name);
    EXPECT_TRUE(!cut.has_value() || cut->may_be_cut) << name << " cut at byte " << size;
    if (!cut) {
      EXPECT_EQ(error_class(cut.error().code), ErrorClass::kInput) << to_string(cut.error());
      EXPECT_EQ(cut.error().file, name);
    }
  }
}

// No damage to a single byte crashes, allocates without bound, or gives points that were not there.
inline void expect_no_damage_crashes(const std::string& whole, const std::string& name) {
  const PointCloudFile intact = value_of(parse_text(whole, name));
  const std::size_t most = whole.size();
  for (std::size_t i = 0; i < whole.size(); ++i) {
    for (const char flip : {'\x01', '\x10', '\x80', '\xff'}) {
      std::string damaged = whole;
      damaged[i] = static_cast<char>(damaged[i] ^ flip);
      const Result<PointCloudFile> read = parse_text(damaged, name);
      if (!read) continue;
      EXPECT_LE(read->points_m.size(), most);
      EXPECT_EQ(read->points_m.size(), read->intensity.size());
    }
  }
}

}  // namespace sightline
