#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "formats/drive/shared_scans.h"
#include "formats/foreign/recording/open_recording.h"
#include "tests/formats/drive/identity/street_scans.h"

// Counts how well copies of recordings are recognized: made-up copies of each folder of scans, one
// change each and several at once, and folders that are no copies of each other.
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

ScanPoints shuffled(ScanPoints points_m, std::uint64_t seed) {
  Random chance(seed);
  for (std::size_t i = points_m.size(); i > 1; --i) {
    std::swap(points_m[i - 1], points_m[chance.below(i)]);
  }
  return points_m;
}

ScanPoints rotated(ScanPoints points_m, double yaw_deg) {
  const Eigen::AngleAxisd turn(yaw_deg * std::numbers::pi / 180.0, Eigen::Vector3d::UnitZ());
  for (Eigen::Vector3d& point_m : points_m) point_m = turn * point_m;
  return points_m;
}

ScanPoints shifted(ScanPoints points_m, double by_m) {
  for (Eigen::Vector3d& point_m : points_m) point_m.z() += by_m;
  return points_m;
}

// Those of even rings of a sensor with rings 2 degrees apart; of others, of every second degree.
ScanPoints of_every_second_ring(ScanPoints points_m) {
  std::erase_if(points_m, [](const Eigen::Vector3d& point_m) {
    const double elevation_deg = std::asin(point_m.z() / point_m.norm()) * 180.0 / std::numbers::pi;
    return std::llround(0.5 * (elevation_deg - 1.0)) % 2 != 0;
  });
  return points_m;
}

struct Change {
  const char* name;
  ScanPoints (*make)(const Folder& folder, std::size_t scan);
};

constexpr Change kChanges[] = {
    {"points shuffled", [](const Folder& f, std::size_t i) { return shuffled(f.scans[i], i); }},
    {"merged two by two",
     [](const Folder& f, std::size_t i) {
       ScanPoints both = f.scans[i];
       const ScanPoints& next = f.scans[std::min(i + 1, f.scans.size() - 1)];
       both.insert(both.end(), next.begin(), next.end());
       return both;
     }},
    {"every second ring",
     [](const Folder& f, std::size_t i) { return of_every_second_ring(f.scans[i]); }},
    {"one point in ten",
     [](const Folder& f, std::size_t i) { return thinned(f.scans[i], 0.1, i); }},
    {"noise of 1 mm",
     [](const Folder& f, std::size_t i) { return with_noise(f.scans[i], 1e-3, i); }},
    {"noise of 3 mm",
     [](const Folder& f, std::size_t i) { return with_noise(f.scans[i], 3e-3, i); }},
    {"noise of 5 mm",
     [](const Folder& f, std::size_t i) { return with_noise(f.scans[i], 5e-3, i); }},
    {"noise of 10 mm",
     [](const Folder& f, std::size_t i) { return with_noise(f.scans[i], 1e-2, i); }},
    {"rotated by 90 degrees",
     [](const Folder& f, std::size_t i) { return rotated(f.scans[i], 90.0); }},
    {"rotated by 2 degrees",
     [](const Folder& f, std::size_t i) { return rotated(f.scans[i], 2.0); }},
    {"1.8 m higher", [](const Folder& f, std::size_t i) { return shifted(f.scans[i], 1.8); }},
};

void print_changes(const Folder& folder) {
  for (const Change& change : kChanges) {
    RecordingCard copy{"localization", "copy", sha256(change.name), {}};
    std::vector<double> alike;
    for (std::size_t i = 0; i < folder.scans.size(); ++i) {
      copy.scans.push_back(sketch_of(change.make(folder, i)));
      alike.push_back(likeness(copy.scans.back(), folder.card.scans[i]));
    }
    std::ranges::sort(alike);
    std::printf("  %s: %s; likeness %.2f to %.2f, median %.2f\n", change.name,
                have_common_scans(copy, folder.card) ? "recognized" : "NOT recognized",
                alike.front(), alike.back(), alike[alike.size() / 2]);
  }
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
      if (!folders.back().scans.empty()) continue;
      std::fprintf(stderr, "%s: no scans\n", argv[i]);
      return 1;
    }
  }
  for (std::size_t i = 0; i < folders.size(); ++i) {
    print_time(folders[i]);
    std::printf("  copies recognized: %d of 100\n",
                count_recognized(folders[i], folders[(i + 1) % folders.size()]));
    print_changes(folders[i]);
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
