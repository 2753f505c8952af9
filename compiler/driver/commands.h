#pragma once

#include <CLI/CLI.hpp>

namespace sightline {

// Each adds one verb to the command line; when it was asked for, it runs and leaves the exit status
// of the process in `status`.
void add_init_command(CLI::App& app, int& status);
void add_compile_command(CLI::App& app, int& status);
void add_train_command(CLI::App& app, int& status);
void add_evaluate_command(CLI::App& app, int& status);
void add_inspect_command(CLI::App& app, int& status);
void add_dump_command(CLI::App& app, int& status);
void add_export_command(CLI::App& app, int& status);
void add_report_command(CLI::App& app, int& status);
void add_verify_command(CLI::App& app, int& status);
void add_diff_command(CLI::App& app, int& status);
void add_gate_command(CLI::App& app, int& status);
void add_delta_command(CLI::App& app, int& status);
void add_apply_command(CLI::App& app, int& status);
void add_strip_command(CLI::App& app, int& status);
void add_recover_command(CLI::App& app, int& status);
void add_key_command(CLI::App& app, int& status);
void add_root_command(CLI::App& app, int& status);
void add_release_command(CLI::App& app, int& status);
void add_sign_command(CLI::App& app, int& status);
void add_admit_command(CLI::App& app, int& status);
void add_passes_command(CLI::App& app, int& status);
void add_completion_command(CLI::App& app, int& status);
void add_man_command(CLI::App& app, int& status);

}  // namespace sightline
