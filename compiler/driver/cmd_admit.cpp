#include <cstdio>
#include <memory>
#include <vector>

#include "compiler/driver/commands.h"
#include "compiler/driver/console.h"
#include "compiler/driver/signing_files.h"
#include "formats/release/record_text.h"
#include "formats/release/signatures.h"

namespace sightline {
namespace {

struct AdmitFlags {
  std::string root;
  std::string next_root;
  std::string release;
  std::string seen;
  std::string now;
  std::string sensor;
  std::string map_id;
  std::string present;
  std::string map;
};

struct SignedText {
  std::string text;
  std::string signatures;
};

Result<SignedText> read_signed(const std::string& file) {
  const Result<std::string> text = read_record_text(file, kLargestRecord);
  if (!text) return text.error();
  const Result<std::string> signatures =
      read_record_text(signatures_of(file), kLargestSignatureFile);
  if (!signatures) return signatures.error();
  return SignedText{*text, *signatures};
}

Result<RootRecord> read_root(const AdmitFlags& flags) {
  const Result<std::string> text = read_record_text(flags.root, kLargestRecord);
  if (!text) return text.error();
  Result<RootRecord> root = decode_root_record(*text);
  if (!root) return in_file(root.error(), flags.root);
  return root;
}

Result<VehicleFacts> facts_of(const AdmitFlags& flags) {
  VehicleFacts facts;
  const Result<std::int64_t> now = read_time(flags.now);
  if (!now) return now.error();
  facts.now_s = *now;
  if (!flags.seen.empty()) {
    const Result<std::string> seen = read_record_text(flags.seen, kLargestRecord);
    if (!seen) return seen.error();
    facts.seen_release = *seen;
  }
  if (!flags.map_id.empty()) facts.map_id = flags.map_id;
  if (flags.sensor.empty()) return facts;
  facts.sensor = digest_of_hex(flags.sensor);
  if (facts.sensor) return facts;
  return Error{ErrorCode::kBadArgument, "--sensor takes 64 hexadecimal digits", "", ""};
}

Result<void> admit_root(const AdmitFlags& flags, const RootRecord& trusted) {
  const Result<SignedText> next = read_signed(flags.next_root);
  if (!next) return next.error();
  const Result<RootRecord> root = next_root(trusted, next->text, next->signatures);
  if (!root) return in_file(root.error(), flags.next_root);
  std::fputs(encode(*root).c_str(), stdout);
  return {};
}

Result<void> admit(const AdmitFlags& flags) {
  const Result<RootRecord> root = read_root(flags);
  if (!root) return root.error();
  if (!flags.next_root.empty()) return admit_root(flags, *root);
  const Result<VehicleFacts> facts = facts_of(flags);
  if (!facts) return facts.error();
  const Result<SignedText> release = read_signed(flags.release);
  if (!release) return release.error();
  const Result<ReleaseRecord> record =
      admit_release(release->text, release->signatures, *root, *facts);
  if (!record) return in_file(record.error(), flags.release);
  if (!flags.map.empty()) {
    const Result<void> checked = check_map(flags.map, *record);
    if (!checked) return checked;
  }
  std::fputs(encode(*record).c_str(), stdout);
  std::printf("fetch %s\n", to_text(plan_fetch(flags.present, *record)).c_str());
  return {};
}

}  // namespace

void add_admit_command(CLI::App& app, int& status) {
  const auto flags = std::make_shared<AdmitFlags>();
  CLI::App* command = app.add_subcommand(
      "admit", "In the vehicle: may this root, release or map be trusted, and what to fetch?");
  command->footer(
      "Checks signatures, fleet, counter, expiry, reader, sensor and, with --map, the map's size,\n"
      "digest, contents and manifest, in the order of schemas/release_format.md. Prints the "
      "record\n"
      "and \"fetch nothing\", \"fetch map NAME SIZE SHA256\" or \"fetch delta NAME SIZE "
      "SHA256\".\n\n"
      "Examples:\n"
      "  sightline admit --root root --next-root root.2\n"
      "  sightline admit --root root --seen seen --present town.slmap release\n"
      "  sightline admit --root root --seen seen release --map incoming.slmap");
  command->add_option("--root", flags->root, "The root record that is trusted")->required();
  CLI::Option* next = command->add_option("--next-root", flags->next_root,
                                          "Check this root, with its .minisig, and print it");
  command->add_option("release", flags->release, "The release record, with its .minisig")
      ->excludes(next);
  command->add_option("--seen", flags->seen, "The newest release record admitted before");
  command->add_option("--now", flags->now, "UTC (default: the clock)");
  command->add_option("--sensor", flags->sensor, "Digest of this vehicle's sensor profile");
  command->add_option("--map-id", flags->map_id, "The map this vehicle wants");
  command->add_option("--present", flags->present, "The map that the vehicle has");
  command->add_option("--map", flags->map, "Check this map against the release");
  command->callback([flags, &status] {
    const Result<void> admitted =
        flags->next_root.empty() && flags->release.empty()
            ? Error{ErrorCode::kBadArgument, "a release or --next-root is needed", "", ""}
            : admit(*flags);
    status = admitted ? 0 : report_error(admitted.error());
  });
}

}  // namespace sightline
