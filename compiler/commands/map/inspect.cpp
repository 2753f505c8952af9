#include <cstdio>
#include <filesystem>
#include <memory>

#include "compiler/cli/console/console.h"
#include "compiler/commands/commands.h"
#include "compiler/driver/provide_inputs.h"
#include "compiler/views/text/describe.h"
#include "compiler/views/text/describe_site.h"
#include "formats/map/map_reader.h"

namespace sightline {
namespace {

struct InspectFlags {
  std::string file;
  int site = -1;  // below 0: the map as a whole
};

Result<void> inspect_model(const InspectFlags& flags) {
  if (flags.site >= 0) {
    return Error{ErrorCode::kBadArgument, "--site: a model annotates no sites, a map does",
                 flags.file};
  }
  SIGHTLINE_ASSIGN(const ByFamily<ErrorModel> model, read_model(flags.file));
  print_text(describe(model));
  return {};
}

Result<void> inspect_map(const InspectFlags& flags) {
  SIGHTLINE_ASSIGN(const CompiledMap map, read_map(flags.file));
  if (flags.site >= 0) {
    SIGHTLINE_ASSIGN(const std::string text,
                     describe_site(map, static_cast<std::size_t>(flags.site)));
    print_text(text);
    return {};
  }
  SIGHTLINE_ASSIGN(const MapSummary summary, verify_map(flags.file));
  print_text(describe(map));
  print_text(describe(summary));
  return {};
}

Result<void> inspect(const InspectFlags& flags) {
  const bool is_model = std::filesystem::path(flags.file).extension() == ".slmodel";
  return is_model ? inspect_model(flags) : inspect_map(flags);
}

}  // namespace

Verb inspect_verb() {
  const auto flags = std::make_shared<InspectFlags>();
  Verb verb;
  verb.name = "inspect";
  verb.summary = "Say in words what a map or a model holds: sites, ranges, promises, model card";
  verb.examples = {"sightline inspect town.slmap",
                   "sightline inspect town.slmap --site 40    # why is the range long here?",
                   "sightline inspect city.slmodel            # what was it trained on?"};
  verb.positionals = {
      {.name = "FILE", .help = "The map (.slmap) or model (.slmodel)", .target = &flags->file}};
  verb.flags = {{.names = "--site",
                 .value = "SITE",
                 .help = "Explain the choice at this site, counted from 0, instead",
                 .target = &flags->site,
                 .minimum = 0}};
  verb.run = [flags] { return exit_status_of(inspect(*flags)); };
  return verb;
}

}  // namespace sightline
