#include <CLI/CLI.hpp>

#include "compiler/base/error.h"
#include "compiler/driver/commands.h"

int main(int argc, char** argv) {
  CLI::App app(
      "sightline compiles recorded drives into a map that tells a vehicle how far it must look at "
      "each place.\n\nData goes to stdout, log and progress to stderr. Exit status: 0 done, 64 "
      "usage, 65 input, 66 version, 67 corrupt,\n74 system, 75 incomplete; schemas/error_codes.md "
      "lists every failure with its remedy.");
  app.name("sightline");
  app.set_version_flag("--version", "sightline " SIGHTLINE_VERSION);
  app.require_subcommand(1);
  int status = 0;
  sightline::add_compile_command(app, status);
  sightline::add_train_command(app, status);
  sightline::add_evaluate_command(app, status);
  sightline::add_inspect_command(app, status);
  sightline::add_dump_command(app, status);
  sightline::add_verify_command(app, status);
  sightline::add_strip_command(app, status);
  sightline::add_migrate_command(app, status);
  sightline::add_recover_command(app, status);
  sightline::add_passes_command(app, status);
  sightline::add_report_command(app, status);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // Asking for help is no failure; all else the parser finds is usage.
    const int parsed = app.exit(error);
    return parsed == 0 ? 0 : sightline::exit_status(sightline::ErrorCode::kBadArgument);
  }
  return status;
}
