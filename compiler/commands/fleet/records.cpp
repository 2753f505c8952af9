#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/written.h"
#include "compiler/commands/commands.h"
#include "compiler/commands/fleet/signing_files.h"
#include "formats/base/files/atomic_file.h"
#include "formats/map/map_reader.h"
#include "formats/reader/mapped_file.h"
#include "formats/release/record_text.h"

namespace sightline {
namespace {

// A counter that is far ahead by mistake can only be followed by greater ones. Dates as counters
// keep within: from 20261231 to 20270101 it is 8870.
constexpr std::uint64_t kLargestStep = 100'000;

struct ReleaseFlags {
  std::string map;
  std::string fleet;
  std::uint64_t counter = 0;
  std::string previous;  // empty: what the new record replaces, if anything
  bool allows_any_step = false;
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
  std::ranges::sort(record.deltas, {}, &ReleasedDelta::base_sha256);
  return {};
}

// Of the record before; 0 where there is none.
Result<std::uint64_t> previous_counter(const ReleaseFlags& flags) {
  const std::string& file = flags.previous.empty() ? flags.out : flags.previous;
  const Result<std::string> text = read_short_text(file, kLargestRecord);
  if (!text && flags.previous.empty()) return std::uint64_t{0};
  if (!text) return text.error();
  const Result<ReleaseRecord> record = decode_release_record(*text);
  if (record) return record->counter;
  if (flags.previous.empty()) return std::uint64_t{0};  // what is replaced is no record
  return in_file(record.error(), file);
}

Result<void> check_counter(const ReleaseFlags& flags) {
  SIGHTLINE_ASSIGN(const std::uint64_t before, previous_counter(flags));
  if (flags.allows_any_step) return {};
  const bool is_greater = flags.counter > before;
  if (is_greater && flags.counter - before <= kLargestStep) return {};
  return Error{ErrorCode::kBadValue,
               concat("--counter: found ", flags.counter, " after ", before,
                      ", expected a step of 1 to ", kLargestStep, "; --any-step allows others")};
}

Result<void> make_release(const ReleaseFlags& flags) {
  SIGHTLINE_TRY(check_counter(flags));
  SIGHTLINE_TRY(verify_map(flags.map));
  SIGHTLINE_ASSIGN(ReleaseRecord record, release_of_map(flags.map));
  record.fleet = flags.fleet;
  record.counter = flags.counter;
  SIGHTLINE_ASSIGN(record.expires_s, read_time(flags.expires));
  SIGHTLINE_TRY(add_deltas(flags, record));
  SIGHTLINE_TRY(validate(record));
  SIGHTLINE_TRY(write_file_atomically(flags.out, encode(record), if_exists(flags.force)));
  print_written(flags.out,
                concat("release ", record.counter, " of ", record.fleet, ", not signed"));
  return {};
}

struct RootFlags {
  std::string fleet;
  std::string previous;
  std::vector<std::string> keys;
  std::uint32_t threshold = 1;
  std::string expires = "+365d";
  std::string out;
  bool force = false;
};

// Name and version follow from the root before, where there is one.
Result<void> follow_previous(const RootFlags& flags, RootRecord& root) {
  root.fleet = flags.fleet;
  if (flags.previous.empty()) return {};
  SIGHTLINE_ASSIGN(const std::string text, read_short_text(flags.previous, kLargestRecord));
  const Result<RootRecord> previous = decode_root_record(text);
  if (!previous) return in_file(previous.error(), flags.previous);
  if (root.fleet.empty()) root.fleet = previous->fleet;
  root.version = previous->version + 1;
  return {};
}

Result<void> make_root(const RootFlags& flags) {
  RootRecord root;
  SIGHTLINE_TRY(follow_previous(flags, root));
  root.threshold = flags.threshold;
  SIGHTLINE_ASSIGN(root.expires_s, read_time(flags.expires));
  for (const std::string& file : flags.keys) {
    SIGHTLINE_ASSIGN(const PublicKey key, read_public_key(file));
    root.keys.push_back(key);
  }
  std::sort(root.keys.begin(), root.keys.end(),
            [](const PublicKey& a, const PublicKey& b) { return to_base64(a) < to_base64(b); });
  SIGHTLINE_TRY(validate(root));
  SIGHTLINE_TRY(write_file_atomically(flags.out, encode(root), if_exists(flags.force)));
  print_written(flags.out, concat("root ", root.version, " of ", root.fleet, ", not signed"));
  return {};
}

}  // namespace

Verb release_verb() {
  const auto flags = std::make_shared<ReleaseFlags>();
  Verb verb;
  verb.name = "fleet release";
  verb.summary = "Write a release record: the map that a fleet should use, and until when";
  verb.details =
      "Verifies the map first. The counter must grow with every record, also if only the expiry "
      "changes. Sign the record, then publish it beside the files that it names.";
  verb.examples = {
      "sightline fleet release town.slmap --fleet metropolis --counter 8 --expires +7d -o release",
      "sightline fleet release town-2.slmap --fleet metropolis --counter 9 \\\n"
      "      --delta town-1.slmap town-1-to-2.sldelta -o release --force",
      "sightline fleet sign release --key a.key && sightline fleet sign release --key b.key"};
  verb.positionals = {map_positional(flags->map, "The map to release")};
  verb.flags = {
      {.names = "--fleet",
       .value = "NAME",
       .help = "Name of the fleet, as in its root record",
       .target = &flags->fleet,
       .is_required = true},
      {.names = "--counter",
       .value = "N",
       .help = "Counter of the record; greater than that of all records before",
       .target = &flags->counter,
       .minimum = 1,
       .is_required = true},
      {.names = "--after",
       .value = "FILE",
       .help = "The record before; default: the one that is replaced",
       .target = &flags->previous},
      {.names = "--any-step",
       .help =
           "Allow a counter that is not greater than that of the record before, or greater by more "
           "than 100000",
       .target = &flags->allows_any_step},
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

Verb root_verb() {
  const auto flags = std::make_shared<RootFlags>();
  Verb verb;
  verb.name = "fleet root";
  verb.summary = "Write a root record: who may sign for a fleet, and how many must";
  verb.details =
      "A vehicle accepts the next root only if enough keys of the previous root and enough keys of "
      "the new one signed it (schemas/release_format.md).";
  verb.examples = {
      "sightline fleet root --fleet metropolis --signer a.pub --signer b.pub --threshold 2 \\\n"
      "      -o root.1",
      "sightline fleet root --previous root.1 --signer b.pub --signer c.pub --threshold 2 \\\n"
      "      -o root.2",
      "sightline fleet sign root.2 --key b.key && sightline fleet sign root.2 --key c.key"};
  verb.flags = {{.names = "--fleet",
                 .value = "NAME",
                 .help = "Name of the fleet; default: that of the previous root",
                 .target = &flags->fleet},
                {.names = "--previous",
                 .value = "FILE",
                 .help = "The root that this one follows",
                 .target = &flags->previous},
                {.names = "--signer",
                 .value = "FILE",
                 .help = "Public key of a signer (.pub)",
                 .target = &flags->keys,
                 .is_required = true},
                {.names = "--threshold",
                 .value = "N",
                 .help = "Number of signers that must sign",
                 .target = &flags->threshold,
                 .is_required = true},
                expires_flag(flags->expires),
                required_output_flag(flags->out, "The record to write"),
                force_flag(flags->force)};
  verb.run = [flags] { return exit_status_of(make_root(*flags)); };
  return verb;
}

}  // namespace sightline
