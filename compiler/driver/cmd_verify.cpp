#include <cstdio>
#include <memory>

#include "compiler/driver/commands.h"
#include "compiler/driver/console.h"
#include "formats/map/describe.h"
#include "formats/map/map_reader.h"

namespace sightline {

void add_verify_command(CLI::App& app, int& status) {
  const auto file = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand(
      "verify", "Check every digest, checksum, bound and order of a map; names the first fault");
  command->footer("Example:\n  sightline verify town.slmap && cp town.slmap /srv/maps/");
  command->add_option("map", *file, "The map (.slmap)")->required();
  command->callback([file, &status] {
    const Result<MapSummary> checked = verify_map(*file);
    if (!checked) {
      status = report_error(checked.error());
      return;
    }
    std::fputs(describe(*checked).c_str(), stdout);
    status = 0;
  });
}

}  // namespace sightline
