#pragma once

#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/base/hash.h"
#include "formats/record/cells.h"
#include "formats/record/codec.h"

namespace sightline {

// Values as texts, each under the path of its field: {"measurement.leaf_m", "0.5"}. A list of
// numbers is one text. In a list of records each has its number in the path; where they are many
// the text is their count and the SHA-256 of their encoding.
class FieldTexts {
 public:
  using Texts = std::vector<std::pair<std::string, std::string>>;

  template <class T>
  void add(const std::string& path, const T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      texts_.emplace_back(path, value ? "yes" : "no");
    } else if constexpr (std::is_same_v<T, Digest>) {
      texts_.emplace_back(path, to_hex(value));
    } else if constexpr (requires { value.has_value(); }) {
      if (value) add(path, *value);
    } else if constexpr (requires { cell_of(value); }) {
      texts_.emplace_back(path, cell_text(cell_of(value)));
    } else if constexpr (HasFields<T>) {
      add_fields(path, value);
    } else if constexpr (requires { value.first; }) {
      add(path + "." + value.first, value.second);
    } else if constexpr (requires { cell_of(*value.begin()); }) {
      texts_.emplace_back(path, joined(value));
    } else {
      add_each(path, value);
    }
  }

  // Also of a record that has a text of its own.
  template <HasFields X>
  void add_fields(const std::string& path, const X& record) {
    const auto visit = [&](std::string_view name, const auto& field) {
      add(path + "." + std::string(name), field);
    };
    fields(visit, record);
  }

  [[nodiscard]] Texts take() { return std::move(texts_); }

 private:
  template <class Values>
  void add_each(const std::string& path, const Values& values) {
    constexpr std::size_t kMany = 5;
    if (values.size() >= kMany) {
      ByteWriter writer;
      FieldWriter(writer).put(values);
      const std::string digest = to_hex(sha256(writer.bytes()));
      texts_.emplace_back(path, std::to_string(values.size()) + ", sha256 " + digest);
      return;
    }
    for (std::size_t i = 0; i < values.size(); ++i) add(path + "." + std::to_string(i), values[i]);
  }

  template <class Values>
  static std::string joined(const Values& values) {
    std::string text;
    for (const auto& value : values) text += (text.empty() ? "" : " ") + cell_text(cell_of(value));
    return text;
  }

  Texts texts_;
};

}  // namespace sightline
