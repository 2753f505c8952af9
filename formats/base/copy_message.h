#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string>

namespace sightline {

// For C interfaces: the text cut to message_size with its zero; message may be null.
inline void copy_message(const std::string& text, char* message, std::size_t message_size) {
  if (message == nullptr || message_size == 0) return;
  const std::size_t size = std::min(text.size(), message_size - 1);
  std::memcpy(message, text.data(), size);
  message[size] = '\0';
}

}  // namespace sightline
