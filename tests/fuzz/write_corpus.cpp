// Writes the inputs that the fuzzers start from: write_corpus FOLDER makes FOLDER/<target>/seed_*.

#include <cstdio>
#include <cstring>
#include <string>

#include "formats/base/files/atomic_file.h"
#include "formats/map/delta/make_delta.h"
#include "formats/map/map_writer.h"
#include "tests/formats/map/random_map.h"
#include "tests/formats/release/signed_records.h"
#include "tests/fuzz/delta_base.h"
#include "tests/fuzz/seed.h"
#include "tests/support/handmade_model.h"

namespace sightline {
namespace {

ContainerParts unpacked(ContainerParts parts) {
  for (TileParts& tile : parts.tiles) {
    for (BlockParts& layer : tile.layers) layer.may_compress = false;
  }
  return parts;
}

void add_maps(std::vector<Seed>& seeds) {
  const RandomMapOptions small{.seed = 2, .site_count = 3, .nd_count = 4, .model_size = 90};
  seeds.push_back({"map/seed_packed", encode_map(random_map(small))});
  RandomMapOptions promise = small;
  promise.size = MapSize::kPromise;
  seeds.push_back({"map/seed_promise", encode_map(random_map(promise))});
  ContainerParts parts = unpacked(parts_of(random_map(small)));
  seeds.push_back({"manifest/seed_whole", parts.manifest});
  seeds.push_back({"map/seed_plain", assemble(parts)});
  CompiledMap stripped = random_map({.seed = 3, .site_count = 1, .nd_count = 1, .model_size = 0});
  stripped.factors = {};
  if (stripped.looks) stripped.looks->factors = {};
  stripped.sharpness.reset();
  parts = unpacked(parts_of(stripped));
  seeds.push_back({"manifest/seed_stripped", parts.manifest});
  parts.features = {{.bit = 3, .is_required = false, .name = "something-new"}};
  parts.sections.push_back({.name = "unknown", .is_required = false, .raw = {std::byte{1}}});
  seeds.push_back({"map/seed_unknown_optional", assemble(parts)});
}

void add_models(std::vector<Seed>& seeds) {
  ErrorModel model = handmade_model({{{0.5, 0.75}, {0.2, 0.1}}, {{0.25, 1.0}, {0.4, 0.1}}}, 2);
  seeds.push_back({"model/seed_leaf", to_bytes(ByFamily<ErrorModel>(model))});
  model.card.tree_count = 2;
  model.forest.trees.resize(2);
  model.forest.trees[1].nodes = {{0, 15.0F, 1, 4}, {0, 12.0F, 2, 3}};
  model.forest.rows = {20.0F, 10.0F, 13.0F, 20.0F};
  ErrorModel samples = handmade_model({{{0.5, 0.75}, {0.2, 0.1}}}, 2);
  for (Look& look : samples.out_of_fold.looks) look.return_count = 1000;
  seeds.push_back({"model/seed_tree", to_bytes(ByFamily<ErrorModel>(model, samples))});
}

// The first byte decides fuzz_release what the rest is.
void add_records(std::vector<Seed>& seeds) {
  const auto add = [&](const std::string& name, char kind, const std::string& text) {
    add_seed(seeds, "release/seed_" + name, kind, text);
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

template <class T>
void put(std::string& bytes, std::size_t at, T value) {
  if (bytes.size() < at + sizeof value) bytes.resize(at + sizeof value);
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

std::string floats(std::initializer_list<float> values) {
  std::string bytes;
  for (const float value : values) bytes += raw(value);
  return bytes;
}

// LAS 1.4 with two points of format 6, one of them withheld, and a reference system said twice.
std::string las() {
  const std::string wkt = "PROJCS[\"UTM\",GEOGCS[\"WGS 84\"],UNIT[\"metre\",1]]";
  std::string bytes = "LASF";
  put(bytes, 24, std::uint16_t{0x0401});
  put(bytes, 94, std::uint16_t{375});
  put(bytes, 96, static_cast<std::uint32_t>(375 + 54 + wkt.size()));
  put(bytes, 100, std::uint32_t{1});
  put(bytes, 104, std::uint8_t{6});
  put(bytes, 105, std::uint16_t{30});
  for (std::size_t axis = 0; axis < 3; ++axis) put(bytes, 131 + 8 * axis, 0.001);
  put(bytes, 235, static_cast<std::uint64_t>(375 + 54 + wkt.size() + 60));
  put(bytes, 243, std::uint32_t{1});
  put(bytes, 247, std::uint64_t{2});
  bytes.resize(375 + 54);
  bytes.replace(375 + 2, 15, "LASF_Projection");
  put(bytes, 375 + 18, std::uint16_t{2112});
  put(bytes, 375 + 20, static_cast<std::uint16_t>(wkt.size()));
  bytes += wkt;
  for (std::int32_t i = 0; i < 2; ++i) {
    const std::size_t at = bytes.size();
    put(bytes, at, 1000 + i);
    put(bytes, at + 4, 2000);
    put(bytes, at + 15, static_cast<std::uint8_t>(4 * i));
    put(bytes, at + 22, 100.5 + i);
  }
  const std::size_t at = bytes.size();
  bytes += std::string(60, '\0');
  bytes.replace(at + 2, 15, "LASF_Projection");
  put(bytes, at + 18, std::uint16_t{34735});
  put(bytes, at + 20, std::uint64_t{16});
  return bytes + raw(std::array<std::uint16_t, 8>{1, 1, 0, 1, 1024, 0, 1, 1});
}

// The first byte decides fuzz_clouds what the file is called.
void add_clouds(std::vector<Seed>& seeds) {
  const auto add = [&](const std::string& name, char kind, const std::string& text) {
    add_seed(seeds, "clouds/seed_" + name, kind, text);
  };
  const std::string fields =
      "FIELDS x y z t\nSIZE 4 4 4 4\nTYPE F F F F\nWIDTH 2\nHEIGHT 1\nPOINTS 2\n";
  const std::string points = floats({1.0F, 2.0F, 3.0F, 0.0F, 4.0F, 5.0F, 6.0F, 0.1F});
  add("pcd_text", 0, fields + "DATA ascii\n1 2 3 0\n4 5 6 0.1\n");
  add("pcd_binary", 0, fields + "DATA binary\n" + points);
  const std::string sizes = raw(std::uint32_t{33}) + raw(std::uint32_t{32});
  add("pcd_compressed", 0, fields + "DATA binary_compressed\n" + sizes + '\x1f' + points);
  const std::string vertices =
      "element vertex 2\nproperty float x\nproperty float y\nproperty float z\nproperty float t\n";
  const std::string faces = "element face 1\nproperty list uchar int index\nend_header\n";
  add("ply_text", 1, "ply\nformat ascii 1.0\n" + vertices + faces + "1 2 3 0\n4 5 6 1\n2 0 1\n");
  add("ply_binary", 1,
      "ply\nformat binary_big_endian 1.0\n" + vertices + faces + points + std::string(1, '\0'));
  add("las", 2, las());
  add("bin", 3, points + points);
}

}  // namespace
}  // namespace sightline

int main(int argc, char** argv) {
  using namespace sightline;
  if (argc != 2 || argv[1][0] == '-') return 64;
  std::vector<Seed> seeds;
  add_maps(seeds);
  add_models(seeds);
  add_records(seeds);
  add_deltas(seeds);
  add_clouds(seeds);
  add_foreign_seeds(seeds);
  add_lidar_seeds(seeds);
  add_ros2_seeds(seeds);
  for (const Seed& seed : seeds) {
    const std::string path = std::string(argv[1]) + "/" + seed.name;
    const Result<void> written = write_file_atomically(path, seed.bytes, IfExists::kReplace);
    if (written) continue;
    std::fprintf(stderr, "%s\n", to_string(written.error()).c_str());
    return 1;
  }
  return 0;
}
