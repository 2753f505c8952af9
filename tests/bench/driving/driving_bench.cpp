#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "formats/base/parallel.h"
#include "passes/pass/default_looks.h"
#include "tests/bench/driving/driven_town.h"
#include "tests/bench/driving/learn_plan.h"

// How good and how dear is driving by a plan of looks? Drives 1 and 2 of each town whole, in closed
// loop, begun up to a metre off and then predicted from the last two results, against the true
// pose; beside one look always and static 50 m with every return, as fast as tests/bench/static_50m
// keeps it. The plan's test and threshold are learnt from the other towns (--test left-out), or
// those of the product (--test usual). Time is thread CPU time; before each scan and rule the
// caches are emptied by writing 64 MiB, and all rules take turns at one scan.

namespace sightline {
namespace {

const std::vector<std::string> kStaticLooks = {
    "100 m, 1944 returns, evenly spaced beyond 30 m, 80 points by normals, settle",
    "100 m, 4000 returns, evenly spaced beyond 30 m, 250 points by normals, settle",
    "100 m, 1944 returns, evenly spaced beyond 30 m, 100 points by normals",
    "100 m, 4000 returns, evenly spaced beyond 30 m, 250 points by normals",
    "100 m, 2850 returns, evenly spaced beyond 30 m, 250 points"};

struct Options {
  std::vector<std::uint64_t> seeds = {1, 2, 3, 4, 5, 6, 7, 8};
  double length_m = 600.0;
  int beams = 16;
  std::string first = to_text(usual_plan().first);
  std::string second = to_text(usual_plan().second);
  std::vector<std::string> looks = kStaticLooks;
  std::string test = "left-out";
  HarderDrive harder;
  std::size_t timed_every = 1;
  bool is_learning = false;
  int threads = 0;
};

// What is compared: static 50 m, static looks, the plan. Where no plan is given, without it.
struct Rules {
  std::vector<Look> looks;  // the first is static 50 m
  std::vector<LookPlan> plan_of_town;
};

// Of one rule in one town.
struct Figures {
  double within_10cm = 0.0, within_25cm = 0.0, scans = 0.0, second = 0.0, work = 0.0;
  std::size_t lost = 0;
  std::vector<double> times_ms;
};

void add(const DriveStep& step, Figures& figures) {
  figures.scans += 1.0;
  figures.within_10cm += step.error_m <= 0.10 ? 1.0 : 0.0;
  figures.within_25cm += step.error_m <= 0.25 ? 1.0 : 0.0;
  figures.second += step.found.look_count > 1 ? 1.0 : 0.0;
  figures.work += static_cast<double>(step.found.match.work);
  figures.lost += step.is_lost ? 1 : 0;
  if (step.time_ms >= 0.0) figures.times_ms.push_back(step.time_ms);
}

// All rules scan by scan in turn.
std::vector<Figures> drive_in_turn(const DrivenTown& town, const Rules& rules, const LookPlan& plan,
                                   std::size_t timed_every) {
  const KernelVersion in_turn = kernel_in_turn();
  std::vector<Figures> figures(rules.looks.size() + 1);
  for (const TownDrive& drive : town.drives) {
    std::vector<std::unique_ptr<Vehicle>> vehicles;
    for (const Look& look : rules.looks) vehicles.push_back(make_static_vehicle(town, look));
    vehicles.push_back(make_planned_vehicle(town, plan));
    std::vector<ClosedLoop> loops;
    for (const std::unique_ptr<Vehicle>& vehicle : vehicles) loops.emplace_back(drive, *vehicle);
    for (std::size_t scan = 0; scan < drive.scans.size(); ++scan) {
      for (std::size_t rule = 0; rule < loops.size(); ++rule) {
        replace_fastest_kernel(rule == 0 ? &in_turn : nullptr);
        add(loops[rule].step(scan, scan % timed_every == 0), figures[rule]);
      }
    }
  }
  replace_fastest_kernel(nullptr);
  return figures;
}

double mean_of(const std::vector<double>& values) {
  return ordered_sum(values) / static_cast<double>(std::max<std::size_t>(values.size(), 1));
}

// Over the towns; times over static 50 m's mean in the same town.
void print_row(const std::string& name, const std::vector<Figures>& of_town,
               const std::vector<Figures>& reference) {
  const auto count = static_cast<double>(of_town.size());
  double within_10cm = 0.0, within_25cm = 0.0, worst = 1.0, second = 0.0, time = 0.0, work = 0.0;
  std::size_t lost = 0;
  std::vector<double> times;
  for (std::size_t town = 0; town < of_town.size(); ++town) {
    const Figures& figures = of_town[town];
    within_10cm += figures.within_10cm / figures.scans / count;
    within_25cm += figures.within_25cm / figures.scans / count;
    worst = std::min(worst, figures.within_10cm / figures.scans);
    second += figures.second / figures.scans / count;
    lost += figures.lost;
    work += figures.work / reference[town].work / count;
    const double unit_ms = mean_of(reference[town].times_ms);
    time += mean_of(figures.times_ms) / unit_ms / count;
    for (const double time_ms : figures.times_ms) times.push_back(time_ms / unit_ms);
  }
  std::ranges::sort(times);
  const std::size_t p99 = (times.size() - 1) * 99 / 100;
  std::printf("%6.2f (%5.1f)  %6.2f  %4zu  %4.1f %%  %.3f  %.3f  %.3f  %.3f  %s\n",
              100.0 * within_10cm, 100.0 * worst, 100.0 * within_25cm, lost, 100.0 * second, work,
              time, times[p99], times.back(), name.c_str());
}

void print_plan(const LookPlan& plan) {
  for (std::size_t i = 0; i < kLookSigns; ++i) {
    std::printf("%8.4f  %s\n", plan.test.weights[i], std::string(look_sign_names()[i]).c_str());
  }
  std::printf("%8.4f  constant\n%8.4f  doubt above\n", plan.test.constant, plan.doubt_above);
}

// One for each town, learnt from the others; prints how well the tests tell.
std::vector<LookPlan> left_out_plans(const DrivenTowns& towns, const LookPlan& looks,
                                     const Options& options) {
  const std::vector<std::vector<LookExample>> examples = examples_of(towns, looks, options.threads);
  std::vector<LookPlan> plans;
  double area = 0.0, judged = 0.0;
  for (std::size_t town = 0; town < towns.size(); ++town) {
    plans.push_back(learn_plan(towns, examples, looks, town, options.threads));
    const double of_town = area_under_curve(examples[town], plans.back().test);
    if (of_town != of_town) continue;  // no look of this town is beyond the limit
    area += of_town;
    judged += 1.0;
  }
  std::printf("area under the curve of the test, mean over towns: %.4f\n", area / judged);
  if (options.is_learning) {
    std::printf("learnt from all these towns:\n");
    print_plan(learn_plan(towns, examples, looks, towns.size(), options.threads));
  }
  return plans;
}

void compare(const Options& options, const Rules& wanted, const LookPlan& looks) {
  DrivenTowns towns;
  for (const std::uint64_t seed : options.seeds) {
    towns.push_back(make_driven_town({.town = {.seed = seed, .length_m = options.length_m},
                                      .beams = options.beams,
                                      .harder = options.harder,
                                      .threads = options.threads}));
  }
  Rules rules = wanted;
  rules.plan_of_town = options.test == "usual" ? std::vector<LookPlan>(towns.size(), usual_plan())
                                               : left_out_plans(towns, looks, options);
  std::vector<std::vector<Figures>> of_rule(rules.looks.size() + 1);
  for (std::size_t town = 0; town < towns.size(); ++town) {
    const std::vector<Figures> figures =
        drive_in_turn(*towns[town], rules, rules.plan_of_town[town], options.timed_every);
    for (std::size_t i = 0; i < figures.size(); ++i) of_rule[i].push_back(figures[i]);
  }
  std::printf(" 10 cm (worst)   25 cm  lost  second   work   time    p99    max  rule\n");
  for (std::size_t i = 0; i < rules.looks.size(); ++i) {
    print_row(to_text(rules.looks[i]), of_rule[i], of_rule[0]);
  }
  print_row("plan: " + to_text(looks.first) + "; where the test doubts: " + to_text(looks.second),
            of_rule.back(), of_rule[0]);
}

Result<void> run(const Options& options) {
  Rules rules;
  rules.looks.push_back(every_return(50.0));
  for (const std::string& text : options.looks) {
    SIGHTLINE_ASSIGN(const Look look, parse_look(text));
    rules.looks.push_back(look);
  }
  LookPlan looks = usual_plan();
  if (options.test != "usual") {
    SIGHTLINE_ASSIGN(looks.first, parse_look(options.first));
    SIGHTLINE_ASSIGN(looks.second, parse_look(options.second));
  }
  compare(options, rules, looks);
  return {};
}

}  // namespace
}  // namespace sightline

int main(int argc, char** argv) {
  sightline::Options options;
  CLI::App app{"Driving by a plan of looks, in generated towns"};
  app.add_option("--seeds", options.seeds, "towns");
  app.add_option("--length-m", options.length_m, "of each");
  app.add_option("--beams", options.beams, "of the sensor: 16, 32, 64 or 128");
  app.add_option("--first", options.first, "the plan's first look");
  app.add_option("--second", options.second, "the plan's second look");
  app.add_option("--look", options.looks, "a look that stands beside it; may be repeated");
  app.add_option("--test", options.test,
                 "left-out: learnt from the other towns; usual: as built in")
      ->check(CLI::IsMember({"left-out", "usual"}));
  app.add_option("--rebuilt", options.harder.rebuilt_share,
                 "share of each 60 m of the route that was rebuilt since it was mapped");
  app.add_option("--crowd", options.harder.traffic, "times the usual traffic");
  app.add_option("--missing", options.harder.missing_share, "share of returns that are missing");
  app.add_option("--timed-every", options.timed_every, "scans: how many are timed");
  app.add_flag("--learn", options.is_learning, "also prints what all these towns teach together");
  app.add_option("--threads", options.threads, "0: all there are; times are taken on one");
  CLI11_PARSE(app, argc, argv);
  const sightline::Result<void> result = sightline::run(options);
  if (!result) {
    std::fprintf(stderr, "%s\n", result.error().message.c_str());
    return 65;
  }
}
