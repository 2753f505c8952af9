#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

#include "compiler/cli/common_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/commands/fleet/signing_files.h"
#include "formats/base/atomic_file.h"
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
  SIGHTLINE_ASSIGN(const MappedFile file, MappedFile::open(path));
  return ReleasedFile{std::filesystem::path(path).filename().string(), file.bytes().size(),
                      sha256(file.bytes())};
}

Result<void> add_deltas(const ReleaseFlags& flags, ReleaseRecord& record) {
  for (std::size_t i = 0; i + 1 < flags.deltas.size(); i += 2) {
    SIGHTLINE_ASSIGN(const ReleasedFile base, released_file(flags.deltas[i]));
    SIGHTLINE_ASSIGN(const ReleasedFile delta, released_file(flags.deltas[i + 1]));
    record.deltas.push_back({delta, base.sha256});
  }
  std::sort(
      record.deltas.begin(), record.deltas.end(),
      [](const ReleasedDelta& a, const ReleasedDelta& b) { return a.base_sha256 < b.base_sha256; });
  return {};
}

Result<void> make_release(const ReleaseFlags& flags) {
  SIGHTLINE_TRY(verify_map(flags.map));
  SIGHTLINE_ASSIGN(ReleaseRecord record, release_of_map(flags.map));
  record.fleet = flags.fleet;
  record.counter = flags.counter;
  SIGHTLINE_ASSIGN(const std::int64_t expires, read_time(flags.expires));
  record.expires_s = expires;
  SIGHTLINE_TRY(add_deltas(flags, record));
  SIGHTLINE_TRY(validate(record));
  return write_file_atomically(flags.out, encode(record),
                               flags.force ? IfExists::kReplace : IfExists::kRefuse);
}

}  // namespace

Verb release_verb() {
  const auto flags = std::make_shared<ReleaseFlags>();
  Verb verb;
  verb.name = "release";
  verb.summary = "Write a release record: the map that a fleet should drive with, until when";
  verb.details =
      "Verifies the map first. The counter grows with every record, also one that only moves the "
      "expiry. Sign the record, then publish it beside the files it names.";
  verb.examples = {
      "sightline release town.slmap --fleet metropolis --counter 8 --expires +7d -o release",
      "sightline release town-2.slmap --fleet metropolis --counter 9 \\\n"
      "      --delta town-1.slmap town-1-to-2.sldelta -o release --force",
      "sightline sign release --key a.key && sightline sign release --key b.key"};
  verb.positionals = {map_positional(flags->map, "The map to release")};
  verb.flags = {{.names = "--fleet",
                 .value = "NAME",
                 .help = "Name of the fleet, as its root says",
                 .target = &flags->fleet,
                 .is_required = true},
                {.names = "--counter",
                 .value = "N",
                 .help = "Greater than that of every record before",
                 .target = &flags->counter,
                 .is_required = true},
                expires_flag(flags->expires),
                {.names = "--delta",
                 .value = "FILE FILE",
                 .help = "A base map and the delta from it to this map",
                 .target = &flags->deltas},
                required_output_flag(flags->out, "The record to write"),
                force_flag(flags->force)};
  verb.run = [flags] { return exit_status_of(make_release(*flags)); };
  return verb;
}

}  // namespace sightline
