#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

#include "compiler/cli/common_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/commands/fleet/signing_files.h"
#include "formats/base/files/atomic_file.h"
#include "formats/map/map_reader.h"
#include "formats/reader/mapped_file.h"
#include "formats/release/record_text.h"

namespace sightline {
namespace {

// A counter that is far ahead by mistake can only be followed by greater ones. Dates as counters
// stay within: from 20261231 to 20270101 it is 8870.
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
  return write_file_atomically(flags.out, encode(record), if_exists(flags.force));
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
  return write_file_atomically(flags.out, encode(root), if_exists(flags.force));
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
  verb.flags = {
      {.names = "--fleet",
       .value = "NAME",
       .help = "Name of the fleet, as its root says",
       .target = &flags->fleet,
       .is_required = true},
      {.names = "--counter",
       .value = "N",
       .help = "Greater than that of every record before",
       .target = &flags->counter,
       .minimum = 1,
       .is_required = true},
      {.names = "--after",
       .value = "FILE",
       .help = "The record before; without it the one that is replaced",
       .target = &flags->previous},
      {.names = "--any-step",
       .help = "Allow a counter that is not greater than that of the record before, or by "
               "more than 100000",
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
  verb.name = "root";
  verb.summary = "Write a root record: who may sign for a fleet, and how many of them must";
  verb.details =
      "A vehicle takes the next root only with enough signatures by the keys of the root before "
      "and by its own (schemas/release_format.md).";
  verb.examples = {
      "sightline root --fleet metropolis --signer a.pub --signer b.pub --threshold 2 -o root.1",
      "sightline root --previous root.1 --signer b.pub --signer c.pub --threshold 2 -o root.2",
      "sightline sign root.2 --key b.key && sightline sign root.2 --key c.key"};
  verb.flags = {{.names = "--fleet",
                 .value = "NAME",
                 .help = "Name of the fleet; without it that of the previous root",
                 .target = &flags->fleet},
                {.names = "--previous",
                 .value = "FILE",
                 .help = "The root that this one follows",
                 .target = &flags->previous},
                {.names = "--signer",
                 .value = "FILE",
                 .help = "A signer's public key (.pub)",
                 .target = &flags->keys,
                 .is_required = true},
                {.names = "--threshold",
                 .value = "N",
                 .help = "How many of them must sign",
                 .target = &flags->threshold,
                 .is_required = true},
                expires_flag(flags->expires),
                required_output_flag(flags->out, "The record to write"),
                force_flag(flags->force)};
  verb.run = [flags] { return exit_status_of(make_root(*flags)); };
  return verb;
}

}  // namespace sightline
