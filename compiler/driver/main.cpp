#include <CLI/CLI.hpp>

#include "compiler/driver/command_line.h"
#include "compiler/driver/commands.h"

int main(int argc, char** argv) {
  CLI::App app(
      "sightline compiles recorded drives into a map that tells a vehicle how far it must look at "
      "each place.\n\nData goes to stdout, log and progress to stderr. Exit status: 0 done, 64 "
      "usage, 65 input, 66 version, 67 corrupt,\n68 signature, 69 gate, 74 system, 75 incomplete; "
      "diff alone: 0 same, 1 different, 2 trouble.\nschemas/error_codes.md lists every failure with "
      "its remedy.");
  app.name("sightline");
  app.set_version_flag("--version", "sightline " SIGHTLINE_VERSION);
  app.require_subcommand(1);
  int status = 0;
  sightline::add_init_command(app, status);
  sightline::add_compile_command(app, status);
  sightline::add_train_command(app, status);
  sightline::add_evaluate_command(app, status);
  sightline::add_inspect_command(app, status);
  sightline::add_dump_command(app, status);
  sightline::add_export_command(app, status);
  sightline::add_report_command(app, status);
  sightline::add_verify_command(app, status);
  sightline::add_diff_command(app, status);
  sightline::add_gate_command(app, status);
  sightline::add_delta_command(app, status);
  sightline::add_apply_command(app, status);
  sightline::add_strip_command(app, status);
  sightline::add_recover_command(app, status);
  sightline::add_key_command(app, status);
  sightline::add_root_command(app, status);
  sightline::add_release_command(app, status);
  sightline::add_sign_command(app, status);
  sightline::add_admit_command(app, status);
  sightline::add_passes_command(app, status);
  sightline::add_completion_command(app, status);
  sightline::add_man_command(app, status);
  return sightline::run_command_line(app, argc, argv, status);
}
