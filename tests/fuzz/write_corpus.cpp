// Writes the inputs that the fuzzers start from: write_corpus FOLDER makes FOLDER/<target>/seed_*.

#include <cstdio>
#include <string>

#include "formats/base/atomic_file.h"
#include "formats/map/delta/make_delta.h"
#include "formats/map/map_writer.h"
#include "tests/formats/map/random_map.h"
#include "tests/formats/release/signed_records.h"
#include "tests/fuzz/delta_base.h"
#include "tests/support/handmade_model.h"

namespace sightline {
namespace {

struct Seed {
  std::string name;  // "map/seed_plain"
  std::vector<std::byte> bytes;
};

ContainerParts unpacked(ContainerParts parts) {
  for (TileParts& tile : parts.tiles) {
    for (BlockParts& layer : tile.layers) layer.may_compress = false;
  }
  return parts;
}

void add_maps(std::vector<Seed>& seeds) {
  const RandomMapOptions small{.seed = 2, .site_count = 3, .nd_count = 4, .model_size = 90};
  seeds.push_back({"map/seed_packed", encode_map(random_map(small))});
  ContainerParts parts = unpacked(parts_of(random_map(small)));
  seeds.push_back({"manifest/seed_whole", parts.manifest});
  seeds.push_back({"map/seed_plain", assemble(parts)});
  CompiledMap stripped = random_map({.seed = 3, .site_count = 1, .nd_count = 1, .model_size = 0});
  stripped.factors.factors.clear();
  stripped.factors.values.clear();
  stripped.sharpness.reset();
  parts = unpacked(parts_of(stripped));
  seeds.push_back({"manifest/seed_stripped", parts.manifest});
  parts.features = {{.bit = 3, .is_required = false, .name = "something-new"}};
  parts.sections.push_back({.name = "unknown", .is_required = false, .raw = {std::byte{1}}});
  seeds.push_back({"map/seed_unknown_optional", assemble(parts)});
}

void add_models(std::vector<Seed>& seeds) {
  ErrorModel model = handmade_model({{{0.5, 0.75}, {0.2, 0.1}}, {{0.25, 1.0}, {0.4, 0.1}}}, 2);
  seeds.push_back({"model/seed_leaf", to_bytes(model)});
  model.card.tree_count = 2;
  model.forest.trees.resize(2);
  model.forest.trees[1].nodes = {{0, 15.0F, 1, 4}, {0, 12.0F, 2, 3}};
  model.forest.rows = {20.0F, 10.0F, 13.0F, 20.0F};
  model.forest.trees[1].leaf_of_label = {2, 0, 1, 2};
  seeds.push_back({"model/seed_tree", to_bytes(model)});
}

// The first byte tells fuzz_release what the rest is.
void add_records(std::vector<Seed>& seeds) {
  const auto add = [&](const std::string& name, char kind, const std::string& text) {
    Seed seed{"release/seed_" + name, {static_cast<std::byte>(kind)}};
    for (const char c : text) seed.bytes.push_back(static_cast<std::byte>(c));
    seeds.push_back(std::move(seed));
  };
  Random random(1);
  ReleaseRecord release = random_release(random);
  release.expires_s = 2'000'000'000;
  while (release.deltas.empty()) release.deltas = random_release(random).deltas;
  add("release", 'r', encode(release));
  add("root", 'o', encode(root_of({3, 4, 5}, 2, 5)));
  add("signatures", 's', signed_by("sightline-release 1\n", {1, 2}));
  add("public_key", 'k', encode_public_key_file(public_key_of(key_of(1))));
  add("secret_key", 'k', encode_secret_key_file(key_of(1), {}));
}

void add_deltas(std::vector<Seed>& seeds) {
  CompiledMap map = fuzzed_base();
  const std::vector<std::byte> base = encode_map(map);
  map.release += 1;
  for (std::size_t i = 0; i < map.ndt.nds.size(); i += 9) map.ndt.nds[i].point_count += 1;
  map.ranges.flags[0] ^= kExtrapolated;
  const std::vector<std::byte> result = encode_map(map);
  seeds.push_back({"delta/seed_small", *make_delta(base, result, {.is_portable = false})});
  seeds.push_back({"delta/seed_portable", *make_delta(base, result, {.is_portable = true})});
  seeds.push_back({"delta/seed_empty", *make_delta(base, base, DeltaOptions())});
}

}  // namespace
}  // namespace sightline

int main(int argc, char** argv) {
  using namespace sightline;
  if (argc != 2) return 64;
  std::vector<Seed> seeds;
  add_maps(seeds);
  add_models(seeds);
  add_records(seeds);
  add_deltas(seeds);
  for (const Seed& seed : seeds) {
    const std::string path = std::string(argv[1]) + "/" + seed.name;
    const Result<void> written = write_file_atomically(path, seed.bytes, IfExists::kReplace);
    if (written) continue;
    std::fprintf(stderr, "%s\n", to_string(written.error()).c_str());
    return 1;
  }
  return 0;
}
