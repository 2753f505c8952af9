#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/base/files/atomic_file.h"
#include "passes/model/promise/calibration.h"

// What a model of many places promises of each of them, and what the place's drives observed. The
// model holds out whole places, so each is predicted by trees of the others; its threshold is set
// here on the others alone. The others' own predictions come from trees that learnt from it, which
// training a model without each place (tests/bench/promise) avoids, at as many times the cost.
//
// usage: promise_bench MODEL [--looks] [ALPHA...]
// --looks: of the looks that take a sample, each named by its number in place of a range.
// Prints a line of JSON for each limit, alpha, kind of case, place and drive:
// the threshold, the promise made of the others, and per site run, s_m, the chosen range and 1
// where the error there was over the limit; then for each limit and kind the pairs of site and
// range.

namespace sightline {
namespace {

ErrorModel without_labels_of(const ErrorModel& model, std::uint32_t place) {
  ErrorModel without = model;
  for (TrainedSite& site : without.sites)
    if (site.place == place) site.has_label = 0;
  return without;
}

bool is_case_of(const TrainedSite& site, std::uint32_t place, std::uint32_t drive, CaseKind kind) {
  return site.place == place && site.drive == drive && site.has_label == 1 &&
         (site.has_history == 1) == (kind == CaseKind::kHistory);
}

std::string head_of(const ErrorModel& model, std::uint32_t place, std::uint32_t drive,
                    CaseKind kind) {
  const PlaceCard& card = model.card.places[place];
  return "\"place\": \"" + card.name + "\", \"drive\": \"" + card.drives[drive] +
         "\", \"kind\": \"" + (kind == CaseKind::kHistory ? "history" : "map-only") + "\"";
}

void print_sites(const ErrorModel& model, std::uint32_t place, CaseKind kind,
                 const Calibration& calibration) {
  const LimitPromise& promise = calibration.promise;
  const double threshold =
      kind == CaseKind::kHistory ? promise.history_threshold : promise.probability_threshold;
  for (std::uint32_t drive = 0; drive < model.card.places[place].drives.size(); ++drive) {
    std::printf("{%s, \"limit_m\": %g, \"alpha\": %g, \"threshold\": %g, \"is_earned\": %s, ",
                head_of(model, place, drive, kind).c_str(), promise.limit_m, promise.alpha,
                threshold, promise.is_earned ? "true" : "false");
    std::printf("\"statement\": \"%s\", \"sites\": [", promise.statement.c_str());
    const char* comma = "";
    for (std::size_t i = 0; i < model.sites.size(); ++i) {
      const TrainedSite& site = model.sites[i];
      if (!is_case_of(site, place, drive, kind) || !calibration.choice.is_answered(i)) continue;
      const std::size_t range = calibration.choice.range_index[i];
      const bool is_sample = !takes_every_return(model.out_of_fold.looks[range]);
      std::printf("%s[%u, %g, %g, %d]", comma, site.run, site.s_m,
                  is_sample ? static_cast<double>(range) : model.ranges[range].range_m,
                  model.measured(i, range) > promise.limit_m ? 1 : 0);
      comma = ", ";
    }
    std::printf("]}\n");
  }
}

void print_pairs(const ErrorModel& model, std::size_t limit, CaseKind kind) {
  const double limit_m = model.out_of_fold.limits_m[limit];
  for (std::uint32_t place = 0; place < model.card.places.size(); ++place) {
    for (std::uint32_t drive = 0; drive < model.card.places[place].drives.size(); ++drive) {
      std::printf("{%s, \"limit_m\": %g, \"pairs\": [", head_of(model, place, drive, kind).c_str(),
                  limit_m);
      const char* comma = "";
      for (std::size_t i = 0; i < model.sites.size(); ++i) {
        const TrainedSite& site = model.sites[i];
        if (!is_case_of(site, place, drive, kind)) continue;
        for (std::size_t range = 0; range < model.ranges.size(); ++range) {
          std::printf("%s[%u, %g, %.6g, %.6g]", comma, site.run, site.s_m,
                      model.out_of_fold.probability(i, range, limit), model.measured(i, range));
          comma = ", ";
        }
      }
      std::printf("]}\n");
    }
  }
}

void judge(const ErrorModel& model, CaseKind kind, const std::vector<double>& alphas) {
  for (std::uint32_t place = 0; place < model.card.places.size(); ++place) {
    const ErrorModel without = without_labels_of(model, place);
    for (const double alpha : alphas) {
      CalibrationOptions options;
      options.alpha = alpha;
      std::optional<Choice> tighter;
      for (std::size_t limit = 0; limit < model.out_of_fold.limits_m.size(); ++limit) {
        Calibration calibration =
            calibrate_probability(without, limit, kind, options, tighter ? &*tighter : nullptr);
        print_sites(model, place, kind, calibration);
        tighter = std::move(calibration.choice);
      }
    }
  }
  for (std::size_t limit = 0; limit < model.out_of_fold.limits_m.size(); ++limit) {
    print_pairs(model, limit, kind);
  }
}

Result<ErrorModel> read_held_out(const std::string& file, bool of_looks) {
  SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes, read_file(file));
  SIGHTLINE_ASSIGN(const ByFamily<ErrorModel> model, from_bytes<ByFamily<ErrorModel>>(bytes));
  const TrainingCard& card = model.ranges.card;
  if (card.hold_out != "places" || card.fold_count != card.places.size()) {
    return Error{ErrorCode::kBadArgument,
                 "expected a model that held out every place: train-model.hold_out=places and as "
                 "many train-model.folds as places",
                 file};
  }
  if (!of_looks) return model.ranges;
  if (model.samples) return *model.samples;
  return Error{ErrorCode::kBadArgument, "the model knows no looks that take a sample"};
}

}  // namespace
}  // namespace sightline

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: %s MODEL [--looks] [ALPHA...]\n", argv[0]);
    return 64;
  }
  const bool of_looks = argc > 2 && std::string_view(argv[2]) == "--looks";
  const auto model = sightline::read_held_out(argv[1], of_looks);
  if (!model) {
    std::fprintf(stderr, "%s\n", to_string(model.error()).c_str());
    return 1;
  }
  std::vector<double> alphas;
  for (int i = of_looks ? 3 : 2; i < argc; ++i) alphas.push_back(std::atof(argv[i]));
  if (alphas.empty()) alphas = {0.05, 0.10};
  sightline::judge(*model, sightline::CaseKind::kMapOnly, alphas);
  if (model->card.knows_history) sightline::judge(*model, sightline::CaseKind::kHistory, alphas);
  return 0;
}
