// How much of a large map a vehicle reads to open it and look up once, and how long that takes:
//
//   write_big_map ... && open_bench MAP
//
// Pages are counted twice: those of the file that a fresh process brought into memory (mincore,
// after the file was dropped from the page cache), and page faults.

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/base/random.h"
#include "formats/base/stopwatch.h"
#include "formats/reader/reader.h"

namespace {

using namespace sightline;

constexpr double kTile_m = 64.0;  // of big_map.h: a street through the middle of each row of tiles

std::size_t resident_bytes(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const auto size = static_cast<std::size_t>(std::filesystem::file_size(path));
  void* data = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, file, 0);
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  std::vector<unsigned char> pages((size + page - 1) / page);
  if (data == MAP_FAILED || ::mincore(data, size, pages.data()) != 0) return size;
  ::munmap(data, size);
  ::close(file);
  return page * static_cast<std::size_t>(std::ranges::count_if(
                    pages, [](unsigned char bits) { return (bits & 1) != 0; }));
}

void drop_from_memory(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  ::fsync(file);
  ::posix_fadvise(file, 0, 0, POSIX_FADV_DONTNEED);
  ::close(file);
}

long page_faults() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return usage.ru_minflt + usage.ru_majflt;
}

struct Visit {
  std::size_t read_bytes = 0;
  long faults = 0;
  double cpu_ms = 0.0;
};

Visit visit(const std::string& path, double x_m, double y_m) {
  Visit visit;
  const long faults = page_faults();
  const double start_ms = thread_cpu_ms();
  const Result<MapReader> reader = MapReader::open(path, "searching");
  const Result<RangeAnswer> answer =
      reader ? reader->observation_range({x_m, y_m, 1.8}, 0.10) : reader.error();
  visit.cpu_ms = thread_cpu_ms() - start_ms;
  visit.faults = page_faults() - faults;
  if (!answer || answer->site == kNoSite) {
    std::fprintf(stderr, "no answer: %s\n", answer ? "far" : to_string(answer.error()).c_str());
    std::exit(1);
  }
  return visit;
}

double median(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

// CPU time of one look-up: the median over batches, so that other programs on the machine do not
// count.
double look_up_ns(const MapReader& reader, const std::vector<std::array<double, 3>>& places) {
  constexpr std::size_t kBatch = 1000;
  std::vector<double> batches_ns;
  double sum_m = 0.0;
  for (std::size_t first = 0; first + kBatch <= places.size(); first += kBatch) {
    const double start_ms = thread_cpu_ms();
    for (std::size_t i = first; i < first + kBatch; ++i) {
      sum_m += reader.observation_range(places[i], 0.10)->range_m;
    }
    batches_ns.push_back(1e6 * (thread_cpu_ms() - start_ms) / kBatch);
  }
  if (!(sum_m > 0.0)) std::exit(1);
  return median(batches_ns);
}

int measure(const std::string& path, int columns) {
  Random random(1);
  std::vector<double> cold_kib;
  std::vector<double> warm_ms;
  std::vector<double> faults;
  for (int i = 0; i < 21; ++i) {
    const double x_m = kTile_m * (columns - 1) * random.uniform();
    const double y_m =
        kTile_m *
        (0.5 + static_cast<double>(random.below(static_cast<std::uint64_t>(columns - 1))));
    drop_from_memory(path);
    const std::size_t before = resident_bytes(path);
    const Visit cold = visit(path, x_m, y_m);
    cold_kib.push_back(static_cast<double>(resident_bytes(path) - before) / 1024.0);
    faults.push_back(static_cast<double>(cold.faults));
    warm_ms.push_back(visit(path, x_m, y_m).cpu_ms);
  }
  std::printf("file                 %.0f MiB\n",
              static_cast<double>(std::filesystem::file_size(path)) / (1 << 20));
  std::printf("read, cold           median %.0f KiB, most %.0f KiB (page faults: median %.0f)\n",
              median(cold_kib), *std::ranges::max_element(cold_kib), median(faults));
  std::printf("open and look up     warm, median %.3f ms, most %.3f ms of CPU time\n",
              median(warm_ms), *std::ranges::max_element(warm_ms));
  const Result<MapReader> reader = MapReader::open(path, "searching");
  // Anywhere in the map, and a metre further each time along its streets.
  std::vector<std::array<double, 3>> anywhere;
  std::vector<std::array<double, 3>> along;
  const double end_m = kTile_m * (columns - 1);
  for (int i = 0; i < 200000; ++i) {
    const auto row = static_cast<double>(random.below(static_cast<std::uint64_t>(columns - 1)));
    anywhere.push_back(
        {end_m * random.uniform(), kTile_m * (row + 0.5) + random.uniform(-1.0, 1.0), 1.8});
    along.push_back({std::fmod(i, end_m), kTile_m * (std::floor(i / end_m) + 0.5), 1.8});
  }
  (void)look_up_ns(*reader, anywhere);  // every page checked
  (void)look_up_ns(*reader, along);
  std::printf("look-up              anywhere %.0f ns, along a street %.0f ns\n",
              look_up_ns(*reader, anywhere), look_up_ns(*reader, along));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s MAP, one that write_big_map wrote\n", argv[0]);
    return 64;
  }
  const Result<MapReader> reader = MapReader::open(std::string(argv[1]), "searching");
  if (!reader) {
    std::fprintf(stderr, "%s\n", to_string(reader.error()).c_str());
    return exit_status(reader.error().code);
  }
  const double tiles = reader->info().site_count / 64.0;  // a site every metre of a street
  return measure(argv[1], static_cast<int>(std::sqrt(tiles)));
}
