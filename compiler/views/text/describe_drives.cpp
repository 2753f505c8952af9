#include "compiler/views/text/describe_drives.h"

#include <algorithm>

namespace sightline {

std::string describe_drives(const TileDrives& tiles) {
  constexpr std::size_t kNameWidth = 22;  // as the other fields that `inspect` prints
  std::string text = "drives\n";
  for (std::uint32_t i = 0; i < tiles.drives.size(); ++i) {
    const MappedDrive& drive = tiles.drives[i];
    const std::string day = day_of(drive.begin_ns);
    const auto tiles_with = [&](std::uint32_t TileDrive::*count) {
      return std::ranges::count_if(
          tiles.rows, [&](const TileDrive& row) { return row.drive == i && row.*count > 0; });
    };
    const auto confirmed = tiles_with(&TileDrive::confirming_scan_count);
    std::string name = drive.name;
    name.resize(std::max(kNameWidth, name.size()), ' ');
    text += "  " + name + " " + (day.empty() ? "day not known" : day) + ", in " +
            std::to_string(tiles_with(&TileDrive::scan_count)) + " tiles";
    if (confirmed > 0) text += ", nothing new in " + std::to_string(confirmed);
    text += "\n";
  }
  return text;
}

}  // namespace sightline
