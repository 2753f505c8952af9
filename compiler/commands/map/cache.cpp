#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>

#include "compiler/cli/console/console.h"
#include "compiler/commands/commands.h"
#include "compiler/store/prune.h"

namespace sightline {
namespace {

struct CacheFlags {
  std::string folder;
  bool prunes = false;
  int unused_days = -1;
};

double mebibytes(std::uint64_t bytes) { return static_cast<double>(bytes) / (1024.0 * 1024.0); }

Result<void> look(const CacheFlags& flags) {
  std::optional<std::chrono::hours> unused_for;
  if (flags.unused_days >= 0) unused_for = std::chrono::hours(24) * flags.unused_days;
  SIGHTLINE_ASSIGN(const CacheContents contents, look_at_cache(flags.folder, unused_for));
  std::printf("%llu objects of %.1f MiB, %llu unfinished files of runs at work here\n",
              static_cast<unsigned long long>(contents.object_count),
              mebibytes(contents.object_bytes),
              static_cast<unsigned long long>(contents.busy_count));
  if (flags.prunes) SIGHTLINE_TRY(prune_cache(contents));
  const char* const what_became = flags.prunes ? ", removed" : "";
  if (unused_for) {
    std::printf("%zu objects of %.1f MiB that no run used for %d days%s\n", contents.unused.size(),
                mebibytes(contents.unused_bytes), flags.unused_days, what_became);
  }
  std::printf("%zu files of %.1f MiB of no use%s\n", contents.useless.size(),
              mebibytes(contents.useless_bytes), what_became);
  for (const std::filesystem::path& path : contents.useless) {
    print_text(path.string() + "\n");
  }
  return {};
}

}  // namespace

Verb cache_verb() {
  const auto flags = std::make_shared<CacheFlags>();
  Verb verb;
  verb.name = "cache";
  verb.summary = "Look into a cache of finished passes, and clear it of what is of no use";
  verb.details =
      "Of no use are unfinished files of killed runs, and objects that are damaged or have the "
      "name of another. Every run removes unfinished files of killed runs on its own machine. "
      "--prune also removes those of other machines and earlier boots. Do not use it while "
      "another machine works in the same folder.\n\n"
      "Finished objects are kept, also of earlier configurations, so a cache grows with every "
      "change. --unused-days lists objects that no run has used in that time, and --prune then "
      "removes them too. A later run makes them again if it needs them. Parts are kept with their "
      "artifact. To free all of the space, remove the folder.\n\n"
      "Anyone who can write to a cache can change what is compiled from it. Compile a release "
      "with --no-cache, or with a cache that only you can write to.";
  verb.examples = {"sightline cache .sightline-cache", "sightline cache .sightline-cache --prune",
                   "sightline cache .sightline-cache --prune --unused-days 30"};
  verb.positionals = {{.name = "FOLDER", .help = "The cache", .target = &flags->folder}};
  verb.flags = {{.names = "--prune", .help = "Remove what is of no use", .target = &flags->prunes},
                {.names = "--unused-days",
                 .value = "N",
                 .help = "Also objects that no run used for N days",
                 .target = &flags->unused_days,
                 .minimum = 0,
                 .maximum = 100000}};
  verb.run = [flags] { return exit_status_of(look(*flags)); };
  return verb;
}

}  // namespace sightline
