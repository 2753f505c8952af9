#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "compiler/cli/console/written.h"
#include "compiler/cli/result_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/store/prune.h"
#include "formats/text/json_text.h"

namespace sightline {
namespace {

struct CacheFlags {
  std::string folder;
  ResultFlags result;
  bool prunes = false;
  int unused_days = -1;
};

std::string to_text(const CacheFlags& flags, const CacheContents& contents) {
  const std::string removed = flags.prunes ? ", removed" : "";
  std::string text = concat(contents.object_count, " objects (", size_text(contents.object_bytes),
                            "), ", contents.busy_count, " unfinished files of running processes\n");
  if (flags.unused_days >= 0) {
    text += concat(contents.unused.size(), " objects (", size_text(contents.unused_bytes),
                   ") not used for ", flags.unused_days, " days", removed, "\n");
  }
  text += concat(contents.useless.size(), " useless files (", size_text(contents.useless_bytes),
                 ")", removed, "\n");
  for (const std::filesystem::path& path : contents.useless) text += path.string() + "\n";
  return text;
}

std::string to_json(const CacheFlags& flags, const CacheContents& contents) {
  nlohmann::ordered_json json = {
      {"objects", contents.object_count},        {"object_bytes", contents.object_bytes},
      {"running_files", contents.busy_count},    {"useless_files", nlohmann::ordered_json::array()},
      {"useless_bytes", contents.useless_bytes}, {"is_pruned", flags.prunes}};
  for (const std::filesystem::path& path : contents.useless) {
    json["useless_files"].push_back(path.string());
  }
  if (flags.unused_days >= 0) {
    json["unused_days"] = flags.unused_days;
    json["unused_objects"] = contents.unused.size();
    json["unused_bytes"] = contents.unused_bytes;
  }
  // A path need not be UTF-8.
  return json_text(json);
}

Result<void> look(const CacheFlags& flags) {
  std::optional<std::chrono::hours> unused_for;
  if (flags.unused_days >= 0) unused_for = std::chrono::hours(24) * flags.unused_days;
  SIGHTLINE_ASSIGN(const CacheContents contents, look_at_cache(flags.folder, unused_for));
  if (flags.prunes) SIGHTLINE_TRY(prune_cache(contents));
  return put_result(flags.result,
                    flags.result.is_json() ? to_json(flags, contents) : to_text(flags, contents));
}

}  // namespace

Verb cache_verb() {
  const auto flags = std::make_shared<CacheFlags>();
  Verb verb;
  verb.name = "cache";
  verb.summary = "Show what a cache of finished passes contains, and remove useless files";
  verb.details =
      "Useless files are unfinished files of killed runs, and objects that are damaged or "
      "misplaced. Each run removes those of killed runs on its own machine. --prune also removes "
      "those of other machines and of earlier boots: do not use it while another machine works "
      "with the same folder.\n\n"
      "Finished results are kept, also those of earlier configurations, so a cache grows with "
      "each change. --unused-days counts objects that no run has used for that time, and --prune "
      "then removes them too; a run that needs one again computes it again. To free all space, "
      "remove the folder.\n\n"
      "Everybody who can write to a cache can change the maps made from it. Compile releases with "
      "--no-cache, or with a cache that only you can write to.";
  verb.examples = {"sightline cache .sightline-cache", "sightline cache .sightline-cache --prune",
                   "sightline cache .sightline-cache --prune --unused-days 30"};
  verb.positionals = {{.name = "FOLDER", .help = "The cache", .target = &flags->folder}};
  verb.flags = {{.names = "--prune", .help = "Remove useless files", .target = &flags->prunes},
                {.names = "--unused-days",
                 .value = "N",
                 .help = "Also count objects that no run has used for N days",
                 .target = &flags->unused_days,
                 .minimum = 0,
                 .maximum = 100000}};
  add_result_flags(verb, flags->result, {"text", "json"},
                   "json as schemas/cache.schema.json describes it");
  verb.run = [flags] { return exit_status_of(look(*flags)); };
  return verb;
}

}  // namespace sightline
