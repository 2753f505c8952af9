#include "compiler/cli/command_line.h"
#include "compiler/cli/guard.h"
#include "compiler/commands/commands.h"
#include "compiler/pipeline/process_cost.h"

int main(int argc, char** argv) {
  sightline::return_freed_memory();
  return sightline::run_guarded([&] {
    return sightline::run_command_line(sightline::sightline_program(), {argv + 1, argv + argc});
  });
}
