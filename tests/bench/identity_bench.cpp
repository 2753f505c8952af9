#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "formats/drive/shared_scans.h"
#include "formats/foreign/recording/open_recording.h"
#include "tests/formats/drive/identity/street_scans.h"

// Counts how well copies of recordings are recognized: made-up copies of each folder of scans, and
// folders that are no copies of each other.
// usage: identity_bench [--scans N=60] SCANS...     (folders or files of scans; each another drive)

namespace sightline {
namespace {

struct Folder {
  std::string name;
  std::vector<ScanPoints> scans;
  RecordingCard card;
};

Folder read_folder(const std::string& path, std::size_t most_scans) {
  RecordingOptions options;
  options.scans = path;
  Folder folder{path, {}, {"mapping", path, sha256(path), {}}};
  const Result<Recording> recording = list_recording(options);
  if (!recording) return folder;
  for (std::size_t i = 0; i < std::min(most_scans, recording->scans.size()); ++i) {
    const Result<PointCloudFile> cloud = read_listed_scan(*recording, i);
    if (!cloud) continue;
    folder.scans.push_back(cloud->points_m);
    folder.card.scans.push_back(sketch_of(cloud->points_m));
  }
  return folder;
}

// Some changes that people make, by chance: a part of the scans, noise of 1 mm, half of the points,
// whole millimetres, a shorter range, scans of another drive behind them.
RecordingCard variant_of(const Folder& folder, const Folder& other, std::uint64_t seed) {
  Random chance(seed);
  const auto is_so = [&](double share) { return chance.uniform() < share; };
  const bool is_noisy = is_so(0.5), is_thin = is_so(0.5), is_rounded = is_so(0.5);
  const bool is_cropped = is_so(0.3), is_joined = is_so(0.3);
  const std::size_t count = folder.scans.size();
  const std::size_t kept = std::max<std::size_t>(2, count / (1 + chance.below(4)));
  const std::size_t first = chance.below(count - kept + 1);
  RecordingCard card{"localization", "copy", sha256("copy " + std::to_string(seed)), {}};
  for (std::size_t i = first; i < first + kept; ++i) {
    ScanPoints scan = folder.scans[i];
    if (is_noisy) scan = with_noise(std::move(scan), 1e-3, mix(seed, i));
    if (is_thin) scan = thinned(scan, 0.5, mix(seed, i));
    if (is_rounded) scan = in_millimetres(std::move(scan));
    if (is_cropped) scan = cropped(std::move(scan), 30.0);
    card.scans.push_back(sketch_of(scan));
  }
  if (!is_joined) return card;
  card.scans.insert(card.scans.end(), other.card.scans.begin(), other.card.scans.end());
  return card;
}

int count_recognized(const Folder& folder, const Folder& other) {
  int recognized = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    recognized += have_common_scans(variant_of(folder, other, seed), folder.card) ? 1 : 0;
  }
  return recognized;
}

// The greatest likeness of scans of two drives.
double greatest_likeness(const Folder& a, const Folder& b) {
  double greatest = 0.0;
  for (const ScanSketch& of_a : a.card.scans) {
    for (const ScanSketch& of_b : b.card.scans) greatest = std::max(greatest, likeness(of_a, of_b));
  }
  return greatest;
}

void print_time(const Folder& folder) {
  const auto begin = std::chrono::steady_clock::now();
  std::size_t points = 0;
  for (const ScanPoints& scan : folder.scans) {
    points += scan.size() + static_cast<std::size_t>(sketch_of(scan).front() == 0);
  }
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  std::printf("%s: %zu scans, %.2f ms a scan, %.1f ns a point\n", folder.name.c_str(),
              folder.scans.size(), 1e3 * taken.count() / static_cast<double>(folder.scans.size()),
              1e9 * taken.count() / static_cast<double>(points));
}

}  // namespace
}  // namespace sightline

int main(int argc, char** argv) {
  using namespace sightline;
  std::size_t most_scans = 60;
  std::vector<Folder> folders;
  for (int i = 1; i < argc; ++i) {
    if (std::string(argv[i]) == "--scans" && i + 1 < argc) {
      most_scans = std::stoul(argv[++i]);
    } else {
      folders.push_back(read_folder(argv[i], most_scans));
    }
  }
  for (std::size_t i = 0; i < folders.size(); ++i) {
    print_time(folders[i]);
    std::printf("  copies recognized: %d of 100\n",
                count_recognized(folders[i], folders[(i + 1) % folders.size()]));
  }
  int wrong = 0, pairs = 0;
  double greatest = 0.0;
  for (std::size_t i = 0; i < folders.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      ++pairs;
      wrong += have_common_scans(folders[i].card, folders[j].card) ? 1 : 0;
      greatest = std::max(greatest, greatest_likeness(folders[i], folders[j]));
    }
  }
  std::printf(
      "pairs of different drives called copies: %d of %d; greatest likeness of two scans "
      "%.2f\n",
      wrong, pairs, greatest);
}
