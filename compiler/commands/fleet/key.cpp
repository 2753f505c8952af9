#include <cstdio>
#include <filesystem>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/commands/fleet/signing_files.h"
#include "formats/base/files/atomic_file.h"

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
    std::fprintf(stderr, "%s is there without %s, which is made of it\n", secret_file.c_str(),
                 public_file.c_str());
    return read_secret_key(secret_file, flags.passphrase_file);
  }
  SIGHTLINE_ASSIGN(const std::optional<std::string> passphrase,
                   read_passphrase(flags.passphrase_file));
  if (!has_secret) SIGHTLINE_TRY(check_output(public_file, IfExists::kRefuse));
  const SecretKey key = new_secret_key();
  SIGHTLINE_TRY(write_secret_file(secret_file, encode_secret_key_file(key, passphrase)));
  if (!passphrase) {
    std::fprintf(stderr, "%s is not encrypted: who reads it can sign\n", secret_file.c_str());
  }
  return key;
}

Result<void> make_key(const KeyFlags& flags) {
  const std::string public_file = flags.name + ".pub";
  SIGHTLINE_ASSIGN(const SecretKey key, secret_key(flags, flags.name + ".key", public_file));
  const PublicKey shared = public_key_of(key);
  SIGHTLINE_TRY(
      write_file_atomically(public_file, encode_public_key_file(shared), IfExists::kRefuse));
  std::printf("%s\n", to_base64(shared).c_str());
  return {};
}

}  // namespace

Verb key_verb() {
  const auto flags = std::make_shared<KeyFlags>();
  Verb verb;
  verb.name = "key";
  verb.summary = "Make a pair of signing keys: NAME.key to keep, NAME.pub to share";
  verb.details =
      "Both are files of minisign, which may make them too (minisign -G). The secret one is "
      "readable by its owner alone and never replaced. Where NAME.key is there without NAME.pub, "
      "that is made of it. Prints the public key.";
  verb.examples = {"sightline key alice                              # not encrypted",
                   "sightline key alice --passphrase-file phrase     # encrypted"};
  verb.positionals = {{.name = "NAME", .help = "Path without an ending", .target = &flags->name}};
  verb.flags = {passphrase_flag(flags->passphrase_file)};
  verb.run = [flags] { return exit_status_of(make_key(*flags)); };
  return verb;
}

}  // namespace sightline
