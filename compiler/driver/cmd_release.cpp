#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

#include "compiler/base/atomic_file.h"
#include "compiler/driver/commands.h"
#include "compiler/driver/console.h"
#include "compiler/driver/signing_files.h"
#include "formats/map/map_reader.h"
#include "formats/reader/mapped_file.h"

namespace sightline {
namespace {

struct ReleaseFlags {
  std::string map;
  std::string fleet;
  std::uint64_t counter = 0;
  std::string expires = "+7d";
  std::vector<std::string> deltas;  // pairs: base map, delta
  std::string out;
  bool force = false;
};

Result<ReleasedFile> released_file(const std::string& path) {
  const Result<MappedFile> file = MappedFile::open(path);
  if (!file) return file.error();
  return ReleasedFile{std::filesystem::path(path).filename().string(), file->bytes().size(),
                      sha256(file->bytes())};
}

Result<void> add_deltas(const ReleaseFlags& flags, ReleaseRecord& record) {
  for (std::size_t i = 0; i + 1 < flags.deltas.size(); i += 2) {
    const Result<ReleasedFile> base = released_file(flags.deltas[i]);
    if (!base) return base.error();
    const Result<ReleasedFile> delta = released_file(flags.deltas[i + 1]);
    if (!delta) return delta.error();
    record.deltas.push_back({*delta, base->sha256});
  }
  std::sort(
      record.deltas.begin(), record.deltas.end(),
      [](const ReleasedDelta& a, const ReleasedDelta& b) { return a.base_sha256 < b.base_sha256; });
  return {};
}

Result<void> make_release(const ReleaseFlags& flags) {
  const Result<MapSummary> verified = verify_map(flags.map);
  if (!verified) return verified.error();
  Result<ReleaseRecord> record = release_of_map(flags.map);
  if (!record) return record.error();
  record->fleet = flags.fleet;
  record->counter = flags.counter;
  const Result<std::int64_t> expires = read_time(flags.expires);
  if (!expires) return expires.error();
  record->expires_s = *expires;
  const Result<void> deltas = add_deltas(flags, *record);
  if (!deltas) return deltas;
  const Result<void> valid = validate(*record);
  if (!valid) return valid;
  return write_file_atomically(flags.out, encode(*record),
                               flags.force ? IfExists::kReplace : IfExists::kRefuse);
}

}  // namespace

void add_release_command(CLI::App& app, int& status) {
  const auto flags = std::make_shared<ReleaseFlags>();
  CLI::App* command = app.add_subcommand(
      "release", "Write a release record: the map that a fleet should drive with, until when");
  command->footer(
      "Verifies the map first. The counter grows with every record, also one that only moves the\n"
      "expiry. Sign the record, then publish it beside the files it names.\n\n"
      "Examples:\n"
      "  sightline release town.slmap --fleet metropolis --counter 8 --expires +7d -o release\n"
      "  sightline release town-2.slmap --fleet metropolis --counter 9 \\\n"
      "      --delta town-1.slmap town-1-to-2.sldelta -o release --force\n"
      "  sightline sign release --key a.key && sightline sign release --key b.key");
  command->add_option("map", flags->map, "The map (.slmap)")->required();
  command->add_option("--fleet", flags->fleet, "Name of the fleet, as its root says")->required();
  command->add_option("--counter", flags->counter, "Greater than that of every record before")
      ->required();
  command->add_option("--expires", flags->expires, "UTC, or days from now")->capture_default_str();
  command->add_option("--delta", flags->deltas, "A base map and the delta from it to this map")
      ->type_size(2)
      ->expected(-1);
  command->add_option("-o,--out", flags->out, "The record")->required();
  command->add_flag("--force", flags->force, "Replace the output");
  command->callback([flags, &status] {
    const Result<void> made = make_release(*flags);
    status = made ? 0 : report_error(made.error());
  });
}

}  // namespace sightline
