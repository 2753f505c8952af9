#pragma once

#include <string>
#include <vector>

// Tables for people: columns that stand under each other.

namespace sightline {

using TextGrid = std::vector<std::vector<std::string>>;  // [row][column]; rows may be short

enum class FirstColumn { kLeft, kRight };

// The first column to the left (unless said), the others to the right, two spaces between, one line
// a row.
std::string aligned(const TextGrid& grid, FirstColumn first = FirstColumn::kLeft);

}  // namespace sightline
