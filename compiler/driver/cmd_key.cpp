#include <cstdio>
#include <memory>

#include "compiler/base/atomic_file.h"
#include "compiler/driver/commands.h"
#include "compiler/driver/console.h"
#include "compiler/driver/signing_files.h"

namespace sightline {
namespace {

struct KeyFlags {
  std::string name;
  std::string passphrase_file;
};

Result<void> make_key(const KeyFlags& flags) {
  const Result<std::optional<std::string>> passphrase = read_passphrase(flags.passphrase_file);
  if (!passphrase) return passphrase.error();
  const SecretKey key = new_secret_key();
  const Result<void> secret =
      write_secret_file(flags.name + ".key", encode_secret_key_file(key, *passphrase));
  if (!secret) return secret;
  const std::string shared = encode_public_key_file(public_key_of(key));
  const Result<void> written =
      write_file_atomically(flags.name + ".pub", shared, IfExists::kRefuse);
  if (!written) return written;
  if (!*passphrase) {
    std::fprintf(stderr, "%s.key is not encrypted: who reads it can sign\n", flags.name.c_str());
  }
  std::printf("%s\n", to_base64(public_key_of(key)).c_str());
  return {};
}

}  // namespace

void add_key_command(CLI::App& app, int& status) {
  const auto flags = std::make_shared<KeyFlags>();
  CLI::App* command =
      app.add_subcommand("key", "Make a pair of signing keys: NAME.key to keep, NAME.pub to share");
  command->footer(
      "Both are files of minisign, which may make them too (minisign -G). The secret one is\n"
      "readable by its owner alone and never replaced. Prints the public key.\n\n"
      "Examples:\n"
      "  sightline key alice                              # not encrypted\n"
      "  sightline key alice --passphrase-file phrase     # first line of a file; - is stdin");
  command->add_option("name", flags->name, "Path without an ending")->required();
  command->add_option("--passphrase-file", flags->passphrase_file,
                      "Encrypt the secret key with the first line of this file");
  command->callback([flags, &status] {
    const Result<void> made = make_key(*flags);
    status = made ? 0 : report_error(made.error());
  });
}

}  // namespace sightline
