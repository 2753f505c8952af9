#include <cstdio>
#include <memory>

#include "compiler/driver/commands.h"
#include "compiler/driver/console.h"
#include "formats/map/describe.h"
#include "formats/map/map_reader.h"

namespace sightline {

void add_inspect_command(CLI::App& app, int& status) {
  const auto file = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand(
      "inspect", "Say in words what a map holds: sites, ranges, promises, model card");
  command->footer("Example:\n  sightline inspect town.slmap");
  command->add_option("map", *file, "The map (.slmap)")->required();
  command->callback([file, &status] {
    const Result<CompiledMap> map = read_map(*file);
    if (!map) {
      status = report_error(map.error());
      return;
    }
    const Result<MapSummary> summary = verify_map(*file);
    if (!summary) {
      status = report_error(summary.error());
      return;
    }
    std::fputs(describe(*map).c_str(), stdout);
    std::fputs(describe(*summary).c_str(), stdout);
    status = 0;
  });
}

}  // namespace sightline
