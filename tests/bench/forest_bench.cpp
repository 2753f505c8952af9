#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "formats/base/random.h"
#include "passes/model/forest/forest_prediction.h"
#include "passes/model/train_model.h"
#include "tests/support/synthetic_places.h"
#include "tests/support/whole_rows.h"

// How long a model takes: training on 100 000 rows (held-out forests, importances and all), and the
// answers to a million. Synthetic places: numbers that behave like factors, without a drive.
//
// usage: forest_bench [rows] [threads]

namespace sightline {
namespace {

struct Timed {
  double wall_s = 0.0;
  double cpu_s = 0.0;
};

template <class Work>
Timed timed(const Work& work) {
  const auto wall = std::chrono::steady_clock::now();
  const std::clock_t cpu = std::clock();
  work();
  const std::chrono::duration<double> wall_s = std::chrono::steady_clock::now() - wall;
  return {wall_s.count(), static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC};
}

void print(const char* what, const Timed& time) {
  std::printf("%-44s %8.1f s CPU %8.1f s wall\n", what, time.cpu_s, time.wall_s);
}

int run(std::size_t row_count, int threads) {
  SyntheticOptions options;  // 9 ranges, 12 factors; a place has two drives and four cases
  constexpr std::size_t kPlaces = 4;
  constexpr std::size_t kCases = 4;
  options.site_count = row_count / (options.ranges_m.size() * kPlaces * kCases) + 1;
  PassContext ctx;
  ctx.threads = threads;
  Result<ErrorModel> model = Error{};
  print("training, 4 places held out in turn", timed([&] {
          model = of_ranges(train_model(ctx, {}, places_driven_twice(kPlaces, options)));
        }));
  if (!model) {
    std::fprintf(stderr, "%s\n", to_string(model.error()).c_str());
    return 1;
  }
  const std::vector<std::byte> bytes = to_bytes(*model);
  std::printf("%zu rows, %zu features, %zu trees, file of %.1f MB\n", model->forest.labels.size(),
              model->features.size(), model->forest.trees.size(),
              1e-6 * static_cast<double>(bytes.size()));
  print("reading the file", timed([&] { model = from_bytes<ErrorModel>(bytes); }));
  constexpr std::size_t kMillion = 1000000;
  FeatureRows rows;
  rows.row_count = kMillion;
  for (const FeatureCard& feature : model->features) rows.names.push_back(feature.name);
  Random random(1);
  std::vector<std::uint32_t> order(kMillion);
  for (std::size_t i = 0; i < kMillion; ++i) {
    order[i] = static_cast<std::uint32_t>(i);
    const std::size_t from = random.below(model->forest.labels.size()) * rows.names.size();
    rows.values.insert(
        rows.values.end(), model->forest.rows.begin() + static_cast<std::ptrdiff_t>(from),
        model->forest.rows.begin() + static_cast<std::ptrdiff_t>(from + rows.names.size()));
  }
  double sum = 0.0;
  print("mean and P at two limits of a million rows", timed([&] {
          const PreparedForest forest(model->forest, {0.1, 0.25}, threads);
          sum = forest.predict(rows, order, threads).mean[0];
        }));
  return sum >= 0.0 ? 0 : 1;
}

}  // namespace
}  // namespace sightline

int main(int argc, char** argv) {
  const std::size_t rows = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 100000;
  return sightline::run(rows, argc > 2 ? std::atoi(argv[2]) : 2);
}
