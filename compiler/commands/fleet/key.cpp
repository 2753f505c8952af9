#include <cstdio>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/commands/fleet/signing_files.h"
#include "formats/base/atomic_file.h"

namespace sightline {
namespace {

struct KeyFlags {
  std::string name;
  std::string passphrase_file;
};

Result<void> make_key(const KeyFlags& flags) {
  SIGHTLINE_ASSIGN(const std::optional<std::string> passphrase,
                   read_passphrase(flags.passphrase_file));
  const SecretKey key = new_secret_key();
  SIGHTLINE_TRY(write_secret_file(flags.name + ".key", encode_secret_key_file(key, passphrase)));
  const std::string shared = encode_public_key_file(public_key_of(key));
  SIGHTLINE_TRY(write_file_atomically(flags.name + ".pub", shared, IfExists::kRefuse));
  if (!passphrase) {
    std::fprintf(stderr, "%s.key is not encrypted: who reads it can sign\n", flags.name.c_str());
  }
  std::printf("%s\n", to_base64(public_key_of(key)).c_str());
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
      "readable by its owner alone and never replaced. Prints the public key.";
  verb.examples = {"sightline key alice                              # not encrypted",
                   "sightline key alice --passphrase-file phrase     # encrypted"};
  verb.positionals = {{.name = "NAME", .help = "Path without an ending", .target = &flags->name}};
  verb.flags = {passphrase_flag(flags->passphrase_file)};
  verb.run = [flags] { return exit_status_of(make_key(*flags)); };
  return verb;
}

}  // namespace sightline
