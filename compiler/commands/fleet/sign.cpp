#include <cstdio>
#include <filesystem>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/cli/console/written.h"
#include "compiler/commands/commands.h"
#include "compiler/commands/fleet/signing_files.h"
#include "formats/base/files/atomic_file.h"
#include "formats/release/record_text.h"
#include "formats/release/signatures.h"

namespace sightline {
namespace {

struct KeyFlags {
  std::string name;
  std::string passphrase_file;
};

// A pair of which only the secret half is there, as where this verb was killed, is completed.
Result<SecretKey> secret_key(const KeyFlags& flags, const std::string& secret_file,
                             const std::string& public_file) {
  const bool has_secret = std::filesystem::exists(secret_file);
  if (has_secret && !std::filesystem::exists(public_file)) {
    print_note(concat(secret_file, " exists without ", public_file, ", which is made from it"));
    return read_secret_key(secret_file, flags.passphrase_file);
  }
  SIGHTLINE_ASSIGN(const std::optional<std::string> passphrase,
                   read_passphrase(flags.passphrase_file));
  if (!has_secret) SIGHTLINE_TRY(check_output(public_file, IfExists::kRefuse));
  const SecretKey key = new_secret_key();
  SIGHTLINE_TRY(write_secret_file(secret_file, encode_secret_key_file(key, passphrase)));
  if (!passphrase) {
    print_warning(secret_file + " is not encrypted: everybody who can read it can sign");
  }
  return key;
}

Result<void> make_key(const KeyFlags& flags) {
  const std::string public_file = flags.name + ".pub";
  SIGHTLINE_ASSIGN(const SecretKey key, secret_key(flags, flags.name + ".key", public_file));
  const PublicKey shared = public_key_of(key);
  SIGHTLINE_TRY(
      write_file_atomically(public_file, encode_public_key_file(shared), IfExists::kRefuse));
  print_data(to_base64(shared) + "\n");
  return {};
}

struct SignFlags {
  std::string record;
  std::string key;
  std::string passphrase_file;
};

// "release 9 of metropolis": nothing else is signed, so that no signature means something it should
// not.
Result<std::string> title_of(const std::string& text) {
  const Result<ReleaseRecord> release = decode_release_record(text);
  if (release) return concat("release ", release->counter, " of ", release->fleet);
  const Result<RootRecord> root = decode_root_record(text);
  if (root) return concat("root ", root->version, " of ", root->fleet);
  return text.starts_with("sightline-root ") ? root.error() : release.error();
}

// The signatures that are there already, still of this record; none where there is no file.
Result<std::string> earlier_signatures(const std::string& file, const std::string& text,
                                       const PublicKey& key) {
  std::error_code failure;
  if (!std::filesystem::exists(file, failure)) return std::string();
  SIGHTLINE_ASSIGN(std::string earlier, read_short_text(file, kLargestSignatureFile));
  const Result<std::vector<Signature>> signatures = parse_signatures(earlier);
  if (!signatures) return in_file(signatures.error(), file);
  for (const Signature& signature : *signatures) {
    if (signature.key_id != key.id) continue;
    const bool is_same = is_valid(signature, text, key);
    return Error{is_same ? ErrorCode::kOutputExists : ErrorCode::kBadSignature,
                 is_same ? "this key has already signed the record"
                         : "the file holds signatures of another record; remove it first",
                 file};
  }
  return earlier;
}

Result<void> sign_record(const SignFlags& flags) {
  SIGHTLINE_ASSIGN(const std::string text, read_short_text(flags.record, kLargestRecord));
  const Result<std::string> title = title_of(text);
  if (!title) return in_file(title.error(), flags.record);
  SIGHTLINE_ASSIGN(const SecretKey key, read_secret_key(flags.key, flags.passphrase_file));
  const std::string file = signatures_of(flags.record);
  SIGHTLINE_ASSIGN(const std::string earlier, earlier_signatures(file, text, public_key_of(key)));
  const std::string signatures = earlier + sign(text, key, *title);
  SIGHTLINE_TRY(write_file_atomically(file, signatures, IfExists::kReplace));
  print_written(file, concat(*title, ", signed by ", to_hex(key.id)));
  return {};
}

}  // namespace

Verb key_verb() {
  const auto flags = std::make_shared<KeyFlags>();
  Verb verb;
  verb.name = "fleet key";
  verb.summary = "Make a pair of signing keys: NAME.key (secret) and NAME.pub (public)";
  verb.details =
      "Both are minisign files; `minisign -G` makes them too. The secret key is readable by its "
      "owner only and is never replaced. If NAME.key exists without NAME.pub, NAME.pub is made "
      "from it. Prints the public key.";
  verb.examples = {"sightline fleet key alice                              # not encrypted",
                   "sightline fleet key alice --passphrase-file phrase     # encrypted"};
  verb.positionals = {{.name = "NAME", .help = "Path without an ending", .target = &flags->name}};
  verb.flags = {passphrase_flag(flags->passphrase_file)};
  verb.run = [flags] { return exit_status_of(make_key(*flags)); };
  return verb;
}

Verb sign_verb() {
  const auto flags = std::make_shared<SignFlags>();
  Verb verb;
  verb.name = "fleet sign";
  verb.summary = "Add a signature to a root or release record, in RECORD.minisig";
  verb.details =
      "Signers sign one after the other, each on a machine of their own. `minisign -V` verifies "
      "the first signature of the file; `tail -n +5 RECORD.minisig` removes it, for the second.";
  verb.examples = {"sightline fleet sign release --key alice.key",
                   "sightline fleet sign release --key bob.key --passphrase-file -"};
  verb.positionals = {{.name = "RECORD", .help = "The record to sign", .target = &flags->record}};
  verb.flags = {{.names = "--key",
                 .value = "FILE",
                 .help = "The secret key (.key)",
                 .target = &flags->key,
                 .is_required = true},
                passphrase_flag(flags->passphrase_file)};
  verb.run = [flags] { return exit_status_of(sign_record(*flags)); };
  return verb;
}

}  // namespace sightline
