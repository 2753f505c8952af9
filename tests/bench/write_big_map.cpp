// Writes a made-up map: write_big_map FILE --size-mib 1024 --changed 0.04

#include <CLI/CLI.hpp>
#include <cstdio>

#include "formats/base/files/atomic_file.h"
#include "tests/bench/big_map.h"

int main(int argc, char** argv) {
  using namespace sightline;
  BigMapOptions options;
  std::string path;
  int size_mib = 16;
  CLI::App app("Writes a made-up map for benchmarks; it passes every check.");
  app.add_option("file", path, "the map (.slmap), replaced if it is there")->required();
  app.add_option("--seed", options.seed, "makes the map")->capture_default_str();
  app.add_option("--size-mib", size_mib, "about how large")
      ->capture_default_str()
      ->check(CLI::Range(1, 65536));
  app.add_option("--changed", options.changed_share,
                 "share of the tiles that differ from the same map without this option")
      ->check(CLI::Range(0.0, 0.5));
  CLI11_PARSE(app, argc, argv);
  options.tile_count = size_mib * kBigMapTilesPerMib;
  const Result<void> written = write_file_atomically(path, big_map(options), IfExists::kReplace);
  if (!written) std::fprintf(stderr, "%s\n", to_string(written.error()).c_str());
  return written ? 0 : exit_status(written.error().code);
}
