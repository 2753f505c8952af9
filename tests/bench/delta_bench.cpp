// Diff, delta and apply of two large maps of which a share of the tiles differs: how much they
// read, write and hold in memory. The program itself is run, with the files out of the page cache.
//   delta_bench --size-mib 1024 --changed 0.04 --folder /tmp/maps

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <thread>

#include "formats/base/files/atomic_file.h"
#include "formats/map/container/packed_block.h"
#include "formats/map/diff/map_side.h"
#include "formats/reader/mapped_file.h"
#include "map_generated.h"
#include "tests/bench/big_map.h"

namespace {

using namespace sightline;
namespace fs = std::filesystem;

struct Run {
  int status = 0;
  double cpu_s = 0.0;
  double peak_mib = 0.0;
};

// Memory of the process itself, without pages of files, which the kernel takes back when it likes.
// The usage that wait4() returns holds this program's own peak from before exec.
double own_mib(pid_t process) {
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  for (std::string word; status >> word;) {
    double kib = 0.0;
    if (word == "RssAnon:" && status >> kib) return kib / 1024.0;
  }
  return 0.0;
}

Run run(const std::vector<std::string>& words) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const pid_t child = ::fork();
  if (child == 0) {
    (void)std::freopen("/dev/null", "w", stdout);
    ::execv(arguments[0], arguments.data());
    ::_exit(127);
  }
  int status = 0;
  rusage usage{};
  double peak_mib = 0.0;
  while (::wait4(child, &status, WNOHANG, &usage) == 0) {
    peak_mib = std::max(peak_mib, own_mib(child));
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return {WEXITSTATUS(status), seconds(usage.ru_utime) + seconds(usage.ru_stime), peak_mib};
}

void drop_from_cache(const fs::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY);
  ::fsync(file);
  ::posix_fadvise(file, 0, 0, POSIX_FADV_DONTNEED);
  ::close(file);
}

// Bytes of the file that are in the page cache: what was read since it was dropped, and what the
// kernel read ahead.
double cached_mib(const fs::path& path) {
  const Result<MappedFile> file = MappedFile::open(path.string());
  if (!file) return 0.0;
  std::vector<unsigned char> is_there((file->bytes().size() + 4095) / 4096);
  ::mincore(const_cast<std::byte*>(file->bytes().data()), file->bytes().size(), is_there.data());
  std::size_t count = 0;
  for (const unsigned char page : is_there) count += page & 1;
  return static_cast<double>(count) * 4096.0 / (1 << 20);
}

// The layers of the new map that the old one does not have, each packed by itself as in a map.
double packed_size_of_changes(const fs::path& before, const fs::path& after) {
  const Result<MappedFile> old_file = MappedFile::open(before.string());
  const Result<MappedFile> new_file = MappedFile::open(after.string());
  const Result<MapContainer> old_map = open_container(old_file->bytes());
  const Result<MapContainer> new_map = open_container(new_file->bytes());
  double size = 0.0;
  for (const schema::Tile* tile : *new_map->directory->tiles()) {
    const std::optional<std::uint32_t> old_tile = find_tile(*old_map, tile->x(), tile->y());
    for (const schema::Block* block : *tile->layers()) {
      const schema::Block* old_block =
          old_tile ? find_layer(*old_map, *old_tile, block->name()->string_view()) : nullptr;
      const bool is_same =
          old_block != nullptr &&
          std::equal(block->raw_digest()->bytes()->begin(), block->raw_digest()->bytes()->end(),
                     old_block->raw_digest()->bytes()->begin());
      if (is_same) continue;
      const std::span<const std::byte> stored = located_bytes(*new_map, *block);
      const bool is_packed = block->codec() == schema::Codec::Zstd;
      size += static_cast<double>(is_packed ? stored.size() : pack(stored).bytes.size());
    }
  }
  return size;
}

void write_maps(const fs::path& before, const fs::path& after, BigMapOptions options) {
  const double changed_share = options.changed_share;
  for (const fs::path& path : {before, after}) {
    options.changed_share = path == before ? 0.0 : changed_share;
    if (!fs::exists(path)) (void)write_file_atomically(path, big_map(options), IfExists::kReplace);
  }
}

void report(const char* what, const Run& run) {
  std::printf("%-18s exit %d, %.1f s of CPU, at most %.1f MiB of memory of its own\n", what,
              run.status, run.cpu_s, run.peak_mib);
}

}  // namespace

int main(int argc, char** argv) {
  BigMapOptions options;
  options.changed_share = 0.04;
  int size_mib = 64;
  std::string folder = "/tmp/sightline_big_maps";
  std::string program = SIGHTLINE_PROGRAM;
  CLI::App app("Diff, delta and apply of two large maps.");
  app.add_option("--size-mib", size_mib)->capture_default_str();
  app.add_option("--changed", options.changed_share)->capture_default_str();
  app.add_option("--folder", folder, "maps that lie there are used again")->capture_default_str();
  app.add_option("--program", program)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  options.tile_count = size_mib * kBigMapTilesPerMib;
  fs::create_directories(folder);
  const fs::path before = fs::path(folder) / "before.slmap";
  const fs::path after = fs::path(folder) / "after.slmap";
  const fs::path delta = fs::path(folder) / "change.sldelta";
  const fs::path vehicle = fs::path(folder) / "vehicle.slmap";
  write_maps(before, after, options);
  const double both_mib =
      static_cast<double>(fs::file_size(before) + fs::file_size(after)) / (1 << 20);
  for (const fs::path& path : {before, after}) drop_from_cache(path);
  const Run diff = run({program, "diff", before, after});
  const double read_mib = cached_mib(before) + cached_mib(after);
  report("diff", diff);
  std::printf("  %.1f of %.1f MiB were read from the disk: %.1f %%\n", read_mib, both_mib,
              100.0 * read_mib / both_mib);
  const double changes = packed_size_of_changes(before, after);
  for (const bool is_portable : {true, false}) {
    std::vector<std::string> words = {program, "delta", "make", before,
                                      after,   "-o",    delta,  "--force"};
    if (is_portable) words.push_back("--portable");
    report(is_portable ? "delta --portable" : "delta", run(words));
    const auto size = static_cast<double>(fs::file_size(delta));
    std::printf("  %.2f MiB, %.3f of the zstd size of the changed layers\n", size / (1 << 20),
                size / changes);
  }
  fs::copy_file(before, vehicle, fs::copy_options::overwrite_existing);
  report("apply", run({program, "delta", "apply", delta, "--to", vehicle}));
  const Result<FileContent> made = read_file_content(vehicle);
  const Result<FileContent> wanted = read_file_content(after);
  const bool is_right = made && wanted && std::ranges::equal(made->bytes(), wanted->bytes());
  std::printf("  the map is the new one byte for byte: %s\n", is_right ? "yes" : "NO");
  fs::remove(vehicle);
  fs::remove(vehicle.string() + ".previous");
  return is_right ? 0 : 1;
}
