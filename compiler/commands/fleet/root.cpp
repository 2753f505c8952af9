#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

#include "compiler/cli/common_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/commands/fleet/signing_files.h"
#include "formats/base/files/atomic_file.h"
#include "formats/release/record_text.h"

namespace sightline {
namespace {

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
  SIGHTLINE_ASSIGN(const std::int64_t expires, read_time(flags.expires));
  root.expires_s = expires;
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
