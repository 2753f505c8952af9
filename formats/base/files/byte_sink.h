#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "formats/base/result.h"

namespace sightline {

// Takes bytes that come in pieces, in their order.
using ByteSink = std::function<Result<void>(std::span<const std::byte>)>;

}  // namespace sightline
