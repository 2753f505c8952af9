#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

#include "compiler/base/atomic_file.h"
#include "compiler/driver/commands.h"
#include "compiler/driver/console.h"
#include "compiler/driver/signing_files.h"
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
  const Result<std::string> text = read_record_text(flags.previous, kLargestRecord);
  if (!text) return text.error();
  const Result<RootRecord> previous = decode_root_record(*text);
  if (!previous) return in_file(previous.error(), flags.previous);
  if (root.fleet.empty()) root.fleet = previous->fleet;
  root.version = previous->version + 1;
  return {};
}

Result<void> make_root(const RootFlags& flags) {
  RootRecord root;
  const Result<void> followed = follow_previous(flags, root);
  if (!followed) return followed;
  root.threshold = flags.threshold;
  const Result<std::int64_t> expires = read_time(flags.expires);
  if (!expires) return expires.error();
  root.expires_s = *expires;
  for (const std::string& file : flags.keys) {
    const Result<PublicKey> key = read_public_key(file);
    if (!key) return key.error();
    root.keys.push_back(*key);
  }
  std::sort(root.keys.begin(), root.keys.end(),
            [](const PublicKey& a, const PublicKey& b) { return to_base64(a) < to_base64(b); });
  const Result<void> valid = validate(root);
  if (!valid) return valid;
  return write_file_atomically(flags.out, encode(root),
                               flags.force ? IfExists::kReplace : IfExists::kRefuse);
}

}  // namespace

void add_root_command(CLI::App& app, int& status) {
  const auto flags = std::make_shared<RootFlags>();
  CLI::App* command = app.add_subcommand(
      "root", "Write a root record: who may sign for a fleet, and how many of them it takes");
  command->footer(
      "A vehicle takes the next root only with enough signatures by the keys of the root before\n"
      "and by its own (schemas/release_format.md).\n\n"
      "Examples:\n"
      "  sightline root --fleet metropolis --key a.pub --key b.pub --key c.pub --threshold 2 -o "
      "root.1\n"
      "  sightline root --previous root.1 --key b.pub --key c.pub --key d.pub --threshold 2 -o "
      "root.2\n"
      "  sightline sign root.2 --key b.key && sightline sign root.2 --key c.key");
  command->add_option("--fleet", flags->fleet, "Name of the fleet (default: the previous root's)");
  command->add_option("--previous", flags->previous, "The root that this one follows");
  command->add_option("--key", flags->keys, "A signer's public key; once for each")->required();
  command->add_option("--threshold", flags->threshold, "How many of them must sign")->required();
  command->add_option("--expires", flags->expires, "UTC, or days from now")->capture_default_str();
  command->add_option("-o,--out", flags->out, "The record")->required();
  command->add_flag("--force", flags->force, "Replace the output");
  command->callback([flags, &status] {
    const Result<void> made = make_root(*flags);
    status = made ? 0 : report_error(made.error());
  });
}

}  // namespace sightline
