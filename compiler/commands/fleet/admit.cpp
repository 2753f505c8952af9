#include <array>
#include <memory>
#include <nlohmann/json.hpp>

#include "compiler/cli/result_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/commands/fleet/signing_files.h"
#include "formats/base/files/atomic_file.h"
#include "formats/release/record_text.h"
#include "formats/release/signatures.h"
#include "formats/text/json_text.h"

namespace sightline {
namespace {

struct AdmitFlags {
  std::string root;
  std::string next_root;
  std::string release;
  std::string seen;
  std::string new_seen;
  std::string now;
  std::string sensor;
  std::string map_id;
  std::string present;
  std::string map;
  ResultFlags result;
};

using Json = nlohmann::ordered_json;

Json json_of(const ReleasedFile& file) {
  return {{"name", file.name}, {"size", file.size}, {"sha256", to_hex(file.sha256)}};
}

Json json_of(const ReleaseRecord& record) {
  Json json = {{"fleet", record.fleet},
               {"map_id", record.map_id},
               {"version", record.version},
               {"counter", record.counter},
               {"expires", utc_text(record.expires_s)},
               {"minimum_format", concat(record.minimum_major, ".", record.minimum_minor)},
               {"sensor_sha256", to_hex(record.sensor)},
               {"map_release", record.map_release},
               {"root_digest", to_hex(record.root_digest)},
               {"map", json_of(record.map)},
               {"deltas", Json::array()}};
  for (const ReleasedDelta& delta : record.deltas) {
    Json file = json_of(delta.file);
    file["base_sha256"] = to_hex(delta.base_sha256);
    json["deltas"].push_back(std::move(file));
  }
  return json;
}

Json json_of(const RootRecord& root) {
  Json json = {{"fleet", root.fleet},
               {"version", root.version},
               {"expires", utc_text(root.expires_s)},
               {"threshold", root.threshold},
               {"keys", Json::array()}};
  for (const PublicKey& key : root.keys) json["keys"].push_back(to_base64(key));
  return json;
}

Json json_of(const FetchPlan& plan) {
  static constexpr std::array<const char*, 3> kKinds = {"nothing", "delta", "map"};
  const bool is_nothing = plan.kind == FetchPlan::Kind::kNothing;
  return {{"kind", kKinds.at(static_cast<std::size_t>(plan.kind))},
          {"file", is_nothing ? Json() : json_of(plan.file)}};
}

struct SignedText {
  std::string text;
  std::string signatures;
};

Result<SignedText> read_signed(const std::string& file) {
  SIGHTLINE_ASSIGN(const std::string text, read_short_text(file, kLargestRecord));
  SIGHTLINE_ASSIGN(const std::string signatures,
                   read_short_text(signatures_of(file), kLargestSignatureFile));
  return SignedText{text, signatures};
}

Result<VehicleFacts> facts_of(const AdmitFlags& flags) {
  VehicleFacts facts;
  SIGHTLINE_ASSIGN(facts.now_s, read_time(flags.now));
  if (!flags.seen.empty()) {
    SIGHTLINE_ASSIGN(const std::string text, read_short_text(flags.seen, kLargestSeenState));
    Result<SeenState> seen = decode_seen_state(text);
    if (!seen) return in_file(seen.error(), flags.seen);
    facts.seen = std::move(*seen);
  }
  if (!flags.map_id.empty()) facts.map_id = flags.map_id;
  if (flags.sensor.empty()) return facts;
  facts.sensor = digest_of_hex(flags.sensor);
  if (facts.sensor) return facts;
  return Error{ErrorCode::kBadArgument,
               concat("--sensor: found '", flags.sensor, "', expected 64 hexadecimal digits")};
}

Result<void> admit_root(const AdmitFlags& flags, const RootRecord& trusted) {
  SIGHTLINE_ASSIGN(const SignedText next, read_signed(flags.next_root));
  const Result<RootRecord> root = next_root(trusted, next.text, next.signatures);
  if (!root) return in_file(root.error(), flags.next_root);
  const Json json = {{"root", json_of(*root)}};
  return put_result(flags.result, flags.result.is_json() ? json_text(json) : encode(*root));
}

Result<void> admit(const AdmitFlags& flags) {
  if (flags.next_root.empty() == flags.release.empty()) {
    return Error{ErrorCode::kBadArgument, "name a RELEASE, or a root by --next-root"};
  }
  SIGHTLINE_TRY(try_result(flags.result));
  SIGHTLINE_ASSIGN(const std::string text, read_short_text(flags.root, kLargestRecord));
  const Result<RootRecord> root = decode_root_record(text);
  if (!root) return in_file(root.error(), flags.root);
  if (!flags.next_root.empty()) return admit_root(flags, *root);
  SIGHTLINE_ASSIGN(const VehicleFacts facts, facts_of(flags));
  SIGHTLINE_ASSIGN(const SignedText release, read_signed(flags.release));
  const Admission admission = admit_and_remember(release.text, release.signatures, *root, facts);
  if (!flags.new_seen.empty() && !admission.seen.release.empty()) {
    SIGHTLINE_TRY(
        write_file_atomically(flags.new_seen, encode(admission.seen), IfExists::kReplace));
  }
  const Result<ReleaseRecord>& record = admission.record;
  if (!record) return in_file(record.error(), flags.release);
  if (!flags.map.empty()) SIGHTLINE_TRY(check_map(flags.map, *record));
  const FetchPlan fetch = plan_fetch(flags.present, *record);
  const Json json = {{"release", json_of(*record)}, {"fetch", json_of(fetch)}};
  return put_result(flags.result, flags.result.is_json()
                                      ? json_text(json)
                                      : concat(encode(*record), "fetch ", to_text(fetch), "\n"));
}

}  // namespace

Verb admit_verb() {
  const auto flags = std::make_shared<AdmitFlags>();
  Verb verb;
  verb.name = "fleet admit";
  verb.summary = "In the vehicle: check a root, release or map, and name the file to fetch";
  verb.details =
      "Checks signatures, fleet, counter, expiry, reader and sensor; with --map also size, digest, "
      "contents and manifest of the map. schemas/release_format.md defines the order. Prints the "
      "record and one line: \"fetch nothing\", \"fetch map NAME SIZE SHA256\" or \"fetch delta "
      "NAME SIZE SHA256\".";
  verb.examples = {
      "sightline fleet admit --root root --next-root root.2",
      "sightline fleet admit --root root --seen seen --new-seen new --present town.slmap release",
      "sightline fleet admit --root root --seen seen release --map incoming.slmap"};
  verb.positionals = {{.name = "RELEASE",
                       .help = "The release record, with its .minisig",
                       .target = &flags->release,
                       .is_required = false}};
  verb.flags = {
      {.names = "--root",
       .value = "FILE",
       .help = "The trusted root record",
       .target = &flags->root,
       .is_required = true},
      {.names = "--next-root",
       .value = "FILE",
       .help = "Check this root with its .minisig and print it; without RELEASE",
       .target = &flags->next_root},
      {.names = "--seen",
       .value = "FILE",
       .help =
           "State of this vehicle: the file of --new-seen, or the newest release record that was "
           "admitted before",
       .target = &flags->seen},
      {.names = "--new-seen",
       .value = "FILE",
       .help = "Write the new state of this vehicle, also if the release is refused",
       .target = &flags->new_seen},
      {.names = "--now",
       .value = "TIME",
       .help = "UTC time such as 2026-12-01T00:00:00Z; default: the clock",
       .target = &flags->now},
      {.names = "--sensor",
       .value = "SHA256",
       .help = "Digest of the sensor profile of this vehicle",
       .target = &flags->sensor},
      {.names = "--map-id",
       .value = "ID",
       .help = "Id of the map that this vehicle needs",
       .target = &flags->map_id},
      {.names = "--present",
       .value = "FILE",
       .help = "The map that is installed in the vehicle (.slmap)",
       .target = &flags->present},
      {.names = "--map",
       .value = "FILE",
       .help = "The map to check against the release (.slmap)",
       .target = &flags->map}};
  add_result_flags(verb, flags->result, {"text", "json"},
                   "json as schemas/admit.schema.json describes it");
  verb.run = [flags] { return exit_status_of(admit(*flags)); };
  return verb;
}

}  // namespace sightline
