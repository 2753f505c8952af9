#include "compiler/views/verdict/verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <tuple>

#include "compiler/gate/forms/gate_text.h"
#include "compiler/gate/gate.h"
#include "compiler/views/report/report.h"
#include "compiler/views/text/map_summary_text.h"
#include "compiler/views/verdict/verdict_text.h"
#include "formats/base/files/atomic_file.h"
#include "formats/text/quoted_text.h"
#include "tests/compiler/gate/route_map.h"
#include "tests/support/json_schema.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using enum MapVerdict;

constexpr int kSites = 60;

// A road of 59 m of ranges alone, all of it measured by its own drive and within the limit.
CompiledMap good_map() {
  CompiledMap map = route_map(kSites);
  map.looks.reset();
  map.trajectory->pieces.resize(1);
  map.measurement.reference = ErrorReference::kKnownPose;
  return map;
}

CompiledMap with_own_coverage(double coverage) {
  CompiledMap map = good_map();
  for (LimitQuality& quality : map.quality) quality.measured_coverage = coverage;
  return map;
}

CompiledMap with_unmet(std::size_t from, std::size_t to) {
  CompiledMap map = good_map();
  for (std::size_t site = from; site <= to; ++site) set_site(map, site, {2, 0.2, 0.1, kUnmet});
  sum_up(map);
  return map;
}

CompiledMap simulated() {
  CompiledMap map = good_map();
  map.measurement.reference = ErrorReference::kSimulated;
  map.measurement.measured_site_count = 0;
  return map;
}

CompiledMap in_pieces() {
  CompiledMap map = good_map();
  map.trajectory->pieces.resize(3);
  return map;
}

// A tunnel of 30 m, through which the poses rest on `substitute`.
CompiledMap with_tunnel(Substitute substitute, double way_m) {
  CompiledMap map = good_map();
  map.trajectory->unconstrained = {{12, 42, way_m, {true, false, false, substitute}, 1.5}};
  map.notices = {{"given-poses-disagree", "they disagree", 5, 3, 4, 69.1, "m"}};
  return map;
}

// Of a replayed drive: every answer beside two constant ones.
EvaluationFigures replayed(double coverage, std::uint32_t lost, std::uint32_t judged = kSites) {
  EvaluationFigures figures;
  figures.drive = "evening";
  figures.site_count = kSites;
  figures.judged_count = judged;
  figures.scan_count = 100;
  for (const double limit_m : {0.1, 0.25}) {
    figures.limits.push_back({limit_m,
                              {{AnswerKind::kRange, coverage, coverage, 0.2, 0.2, lost}},
                              {{"15 m", 0.99, 0.5, 0.5, 0}, {"50 m", 1.0, 1.0, 1.0, 0}}});
  }
  return figures;
}

struct Case {
  const char* name;
  CompiledMap map;
  std::optional<EvaluationFigures> evaluation;
  MapVerdict expected;
};

std::vector<Case> cases() {
  std::vector<Case> all;
  all.push_back({"own drive within the limit", good_map(), {}, kNotJudged});
  all.push_back({"evaluation within the limit", good_map(), replayed(0.98, 0), kGood});
  all.push_back({"simulated, then evaluated", simulated(), replayed(0.99, 0), kGood});
  all.push_back({"own drive a little below the target", with_own_coverage(0.93), {}, kPartly});
  all.push_back({"20 m unmet", with_unmet(20, 40), {}, kPartly});
  all.push_back({"a third evaluated", good_map(), replayed(0.98, 0, kSites / 3), kPartly});
  all.push_back({"evaluated, 20 m unmet", with_unmet(20, 40), replayed(0.99, 0), kPartly});
  all.push_back({"own drive far below the target", with_own_coverage(0.8), {}, kBad});
  all.push_back({"evaluation far below the target", good_map(), replayed(0.85, 0), kBad});
  all.push_back({"tracks lost", good_map(), replayed(0.98, 3), kBad});
  all.push_back({"three pieces", in_pieces(), replayed(0.98, 0), kBad});
  all.push_back({"tunnel at a constant speed", with_tunnel(Substitute::kConstantSpeed, 30.0),
                 replayed(0.99, 0), kPartly});
  all.push_back({"tunnel at an unknown speed", with_tunnel(Substitute::kNone, 20.0), {}, kPartly});
  all.push_back(
      {"short tunnel", with_tunnel(Substitute::kConstantSpeed, 19.0), replayed(0.99, 0), kGood});
  all.push_back({"tunnel with given poses", with_tunnel(Substitute::kGivenPoses, 30.0),
                 replayed(0.99, 0), kGood});
  all.push_back({"tunnel with wheel speed", with_tunnel(Substitute::kWheelSpeed, 30.0),
                 replayed(0.99, 0), kGood});
  all.push_back({"simulated", simulated(), {}, kNotJudged});
  all.push_back({"no site measured", simulated(), {}, kNotJudged});
  all.back().map.measurement.reference = ErrorReference::kKnownPose;
  return all;
}

const EvaluationFigures* figures_of(const Case& each) {
  return each.evaluation ? &*each.evaluation : nullptr;
}

MapJudgement judgement_of(const Case& each) { return judge_map(each.map, figures_of(each), {}); }

TEST(Verdict, IsAsItsThresholdsSay) {
  for (const Case& each : cases()) {
    const MapJudgement judgement = judgement_of(each);
    EXPECT_EQ(judgement.verdict, each.expected) << each.name << ": " << to_text(judgement);
    const bool has_reason = each.expected == kPartly || each.expected == kBad ||
                            (each.expected == kNotJudged && judgement.is_own_drive);
    EXPECT_EQ(!judgement.reason.empty(), has_reason) << each.name;
  }
}

TEST(Verdict, NamesTheWayThatRestsOnAnAssumedSpeed) {
  CompiledMap map = with_tunnel(Substitute::kConstantSpeed, 30.0);
  const EvaluationFigures figures = replayed(0.99, 0);
  const MapJudgement judgement = judge_map(map, &figures, {});
  EXPECT_EQ(judgement.reason,
            "On 30 m of the way the scans do not constrain the poses of the map: constant speed is "
            "assumed, +/- 1.5 m (scans 12 to 42).");
  EXPECT_THAT(judgement.next, HasSubstr("inspect MAP --all"));
  for (LimitQuality& quality : map.quality) quality.measured_coverage = 0.8;
  const MapJudgement bad = judge_map(map, nullptr, {});
  EXPECT_EQ(bad.verdict, kBad);
  EXPECT_THAT(bad.reason, HasSubstr(". On 30 m of the way"));
}

TEST(Verdict, InspectNamesWhatWasNotObservedAndWhatWasContradicted) {
  CompiledMap map = with_tunnel(Substitute::kConstantSpeed, 30.0);
  MapSummary summary;
  const MapJudgement judgement = judge_map(map, nullptr, {});
  EXPECT_THAT(
      summary_text({"road.slmap", map, summary, judgement}),
      AllOf(HasSubstr("unobserved scans 12 to 42: 30.0 m of the way are not constrained "
                      "along the road; constant speed is assumed, +/- 1.5 m\n"),
            HasSubstr("doubts     given-poses-disagree (5 places, most 69.1 m at scans 3 to "
                      "4) (--all explains them)\n")));
  map.trajectory->unconstrained.push_back({50, 60, 12.0, {false, true, true, Substitute::kNone}});
  EXPECT_THAT(summary_text({"road.slmap", map, summary, judgement}),
              HasSubstr("unobserved 42.0 m of the way on 2 stretches; scans 12 to 42: 30.0 m"));
  const CompiledMap known = good_map();
  const std::string without = summary_text({"road.slmap", known, summary, judgement});
  EXPECT_THAT(without, testing::Not(HasSubstr("unobserved")));
  EXPECT_THAT(without, testing::Not(HasSubstr("doubts")));
}

TEST(Verdict, InspectNamesHowGoodEstimatedPosesAre) {
  CompiledMap map = good_map();
  map.trajectory->source = PoseSource::kGiven;
  const MapSummary summary;
  const MapJudgement judgement = judge_map(map, nullptr, {});
  const auto text = [&] { return summary_text({"road.slmap", map, summary, judgement}); };
  EXPECT_THAT(text(), testing::Not(HasSubstr("walls")));
  map.trajectory->source = PoseSource::kEstimated;
  map.trajectory->loop_edges = 0;
  map.trajectory->overlap_count = 60;
  map.trajectory->median_overlap = 0.93;
  map.trajectory->least_overlap = 0.71;
  EXPECT_THAT(text(),
              AllOf(HasSubstr("; 93 % of the walls in a scan meet those of the scans before"),
                    HasSubstr("(median; least 71 %); no place is passed twice, so errors add up "
                              "along the route\n")));
  map.trajectory->loop_edges = 2;
  EXPECT_THAT(text(), testing::Not(HasSubstr("passed twice")));
}

TEST(Verdict, InspectExplainsLooksWhereTheMapHasThem) {
  const MapSummary summary;
  for (const bool has_looks : {true, false}) {
    const CompiledMap map = has_looks ? route_map(kSites) : good_map();
    const MapJudgement judgement = judge_map(map, nullptr, {});
    const std::string text = summary_text({"road.slmap", map, summary, judgement});
    EXPECT_EQ(text.find("\nA look is a small sample of a scan, ") != std::string::npos, has_looks);
  }
}

TEST(Verdict, TheCasesHaveTwoOfEachVerdict) {
  const std::vector<Case> all = cases();
  EXPECT_GE(all.size(), 10U);
  for (const MapVerdict verdict : {kGood, kPartly, kBad, kNotJudged}) {
    EXPECT_GE(std::ranges::count(all, verdict, &Case::expected), 2) << word_of(verdict);
  }
}

GateReport gate_of(const Case& each) {
  MapSummary summary;
  summary.format = "1.0";
  const GateMap map{"road.slmap", each.map, summary};
  return value_of(
      judge({map, nullptr, nullptr, figures_of(each)}, default_gate_settings(), "2026-06-15"));
}

// The texts wrap where the lines end.
std::string on_one_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  const std::string gap = "   ";
  for (std::size_t at = text.find(gap); at != std::string::npos; at = text.find(gap)) {
    text.replace(at, gap.size(), " ");
  }
  return text;
}

TEST(Verdict, IsTheSameInEveryForm) {
  for (const Case& each : cases()) {
    const MapJudgement judgement = judgement_of(each);
    const std::string words = verdict_head(judgement) + verdict_rest(judgement);
    MapSummary summary;
    const std::string inspected =
        summary_text({"road.slmap", each.map, summary, judgement, figures_of(each)});
    EXPECT_THAT(on_one_line(inspected), HasSubstr(words)) << each.name;
    const GateReport gate = gate_of(each);
    EXPECT_THAT(on_one_line(to_summary(gate)), HasSubstr(words)) << each.name;
    EXPECT_THAT(on_one_line(to_text(gate)), HasSubstr(words)) << each.name;
    EXPECT_THAT(to_markdown(gate), HasSubstr(to_markdown(judgement))) << each.name;
    ReportSources sources;
    sources.map = &each.map;
    sources.figures = figures_of(each);
    const std::string page = value_of(report_html(sources));
    EXPECT_THAT(page, HasSubstr(">" + verdict_head(judgement) + "<")) << each.name;
    EXPECT_THAT(page, HasSubstr(xml_text(judgement.figures))) << each.name;
    EXPECT_THAT(page, HasSubstr(xml_text(judgement.reason))) << each.name;
  }
}

TEST(Verdict, HasTheColourOfItsWordOnPageAndInMarkdown) {
  const char* const styles[] = {"is-good", "is-partly", "is-bad", "is-not-judged"};
  const char* const signs[] = {"\U0001F7E2 good", "\U0001F7E1 partly", "\U0001F534 bad",
                               "\u26AA not judged"};
  for (const Case& each : cases()) {
    const auto index = static_cast<std::size_t>(each.expected);
    ReportSources sources;
    sources.map = &each.map;
    sources.figures = figures_of(each);
    EXPECT_THAT(value_of(report_html(sources)),
                HasSubstr(std::string("<div class=\"overall ") + styles[index] + "\">"))
        << each.name;
    EXPECT_THAT(to_markdown(judgement_of(each)), HasSubstr(signs[index])) << each.name;
  }
}

TEST(Verdict, InspectFitsOnAScreenAndItsJsonIsAsTheSchemaSays) {
  const nlohmann::json schema = nlohmann::json::parse(
      value_of(read_text_file(std::string(SIGHTLINE_ROOT) + "/schemas/inspect.schema.json")));
  for (const Case& each : cases()) {
    const MapJudgement judgement = judgement_of(each);
    MapSummary summary;
    const InspectedMap inspected = {"road.slmap", each.map, summary, judgement, figures_of(each)};
    const std::string text = summary_text(inspected);
    EXPECT_LE(std::ranges::count(text, '\n'), 40) << text;
    EXPECT_LE(std::ranges::count(to_text(judgement), '\n'), 5) << text;
    EXPECT_EQ(schema_faults(schema, to_json(inspected)), "") << each.name;
    EXPECT_EQ(to_json(judgement).at("word"), word_of(each.expected));
  }
}

// A map with looks and a plan for all limits.
CompiledMap map_with_plan() {
  CompiledMap map = good_map();
  map.looks.emplace();
  map.looks->ranges = map.ranges;
  map.looks->quality = map.quality;
  LookPlan plan;
  plan.limit_m = 0.1;
  map.looks->ranges.plan = plan;
  return map;
}

// Ranges that miss, looks that do not.
TEST(Verdict, RecommendsTheFirstAnswerThatReachesTheTarget) {
  const CompiledMap map = map_with_plan();
  EvaluationFigures figures = replayed(0.99, 0);
  for (LimitFigures& limit : figures.limits) {
    limit.answers = {{AnswerKind::kPlan, 0.998, 0.998, 0.3, 0.08, 0},
                     {AnswerKind::kLook, 0.97, 0.97, 0.1, 0.1, 2},
                     {AnswerKind::kRange, 0.96, 0.96, 0.3, 0.3, 0}};
  }
  MapJudgement judgement = judge_map(map, &figures, {});
  EXPECT_EQ(judgement.verdict, kGood);
  EXPECT_EQ(judgement.limits[0].recommended, AnswerKind::kPlan);
  EXPECT_THAT(
      judgement.figures,
      HasSubstr("the map's plan keeps 99.8 % of 100 scans within 10 cm and no track is "
                "lost, with 8 % of the work (points times iterations) of the best fixed choice"));
  for (LimitFigures& limit : figures.limits) limit.answers[0].lost_count = 4;
  judgement = judge_map(map, &figures, {});
  EXPECT_EQ(judgement.verdict, kPartly) << "the ranges still reach the target";
  EXPECT_EQ(judgement.limits[0].recommended, AnswerKind::kRange);
  EXPECT_THAT(judgement.reason, HasSubstr("The map's plan lost 4 tracks"));
}

// Every limit with these answers, beside the constant ones of replayed().
EvaluationFigures with_answers(const std::vector<AnswerScore>& answers) {
  EvaluationFigures figures = replayed(0.99, 0);
  for (LimitFigures& limit : figures.limits) limit.answers = answers;
  return figures;
}

// Times, which differ from run to run, are the opposite of the work and decide nothing.
TEST(Verdict, AnAnswerOfMoreWorkThanAFixedChoiceGivesWayToAnotherOrIsPartly) {
  const CompiledMap map = map_with_plan();
  const EvaluationFigures look_is_cheap = with_answers(
      {{AnswerKind::kPlan, 0.98, 0.98, 0.1, 0.6, 0}, {AnswerKind::kLook, 0.97, 0.97, 0.9, 0.4, 0}});
  MapJudgement judgement = judge_map(map, &look_is_cheap, {});
  EXPECT_EQ(judgement.verdict, kGood) << to_text(judgement);
  EXPECT_EQ(judgement.limits[0].recommended, AnswerKind::kLook);
  const EvaluationFigures all_are_dear = with_answers(
      {{AnswerKind::kPlan, 0.98, 0.98, 0.1, 2.0, 0}, {AnswerKind::kLook, 0.97, 0.97, 0.2, 0.8, 0}});
  judgement = judge_map(map, &all_are_dear, {});
  EXPECT_EQ(judgement.verdict, kPartly);
  EXPECT_EQ(judgement.limits[0].recommended, AnswerKind::kPlan);
  EXPECT_EQ(judgement.reason,
            "A fixed choice needs less work here: use 15 m everywhere (25 % of the work).");
  EXPECT_EQ(judgement.next,
            "sightline compile CONFIG -o fixed.slmap --set annotation.looks=paper --set "
            "annotation.ranges_m=15  # makes a map of that fixed choice");
  EXPECT_THAT(
      judgement.figures,
      HasSubstr(", with 4.0 times the work (points times iterations) of the best fixed choice"));
}

TEST(Verdict, FivePercentMoreWorkAndThatOfAWorseFixedChoiceAreAccepted) {
  const CompiledMap map = good_map();
  for (const auto& [coverage, work_ratio, expected] :
       {std::tuple(0.98, 0.525, kGood), std::tuple(0.98, 0.53, kPartly),
        std::tuple(1.0, 1.04, kGood)}) {
    const EvaluationFigures figures =
        with_answers({{AnswerKind::kRange, coverage, coverage, 1.0, work_ratio, 0}});
    EXPECT_EQ(judge_map(map, &figures, {}).verdict, expected) << coverage << " " << work_ratio;
  }
  EvaluationFigures best = with_answers({{AnswerKind::kRange, 1.0, 1.0, 1.0, 3.0, 0}});
  for (LimitFigures& limit : best.limits) limit.constants.pop_back();
  EXPECT_EQ(judge_map(map, &best, {}).verdict, kGood) << "15 m keeps less";
}

TEST(Verdict, SaysWhoseEvidenceItIsBy) {
  const std::pair<DriveOrigin, std::string> kSaid[] = {
      {DriveOrigin::kOtherScans, "On its own drive (same drive, other scans: optimistic)"},
      {DriveOrigin::kKnown, "(known drive: optimistic)"},
      {DriveOrigin::kUnknown, "(origin unknown)"}};
  for (const auto& [origin, said] : kSaid) {
    EvaluationFigures figures = replayed(0.99, 0);
    figures.origin = origin;
    const MapJudgement judgement = judge_map(good_map(), &figures, {});
    EXPECT_THAT(judgement.figures, HasSubstr(said));
    EXPECT_EQ(judgement.verdict, is_own(origin) ? kNotJudged : kGood) << said;
    EXPECT_EQ(to_json(judgement).at("drive_role"), name_of(origin));
  }
}

TEST(Verdict, AnEvaluationByTheMapsOwnDriveIsOptimistic) {
  EvaluationFigures figures = replayed(0.99, 0);
  figures.origin = DriveOrigin::kOwn;
  const MapJudgement judgement = judge_map(good_map(), &figures, {.config = "drive.yaml"});
  EXPECT_THAT(judgement.figures, HasSubstr("On its own drive (optimistic) the map's ranges keep"));
  EXPECT_EQ(to_json(judgement).at("is_own_drive"), true);
  EXPECT_EQ(judgement.verdict, kNotJudged);
  EXPECT_EQ(judgement.reason, "Only its own drive has tested the map.");
  EXPECT_EQ(judgement.next,
            "sightline init RECORDING -o other.yaml  # describes another drive; name it under "
            "evaluation: in drive.yaml");
}

TEST(Verdict, TheNextCommandWorksWithoutAnEvaluationDrive) {
  const VerdictFiles files = {.map = "a.slmap", .config = "a.yaml", .names_evaluation = false};
  CompiledMap map = good_map();
  map.measurement.mapping_scans = "all";
  EXPECT_EQ(judge_map(map, nullptr, files).next,
            "sightline report a.yaml --map a.slmap -o map.html  # shows the map; to judge it, name "
            "another drive under evaluation: in a.yaml");
  EXPECT_EQ(judge_map(map, nullptr, {.map = "a.slmap", .config = "a.yaml"}).next,
            "sightline evaluate a.yaml --map a.slmap  # judges the map by another drive");
  map.measurement.mapping_scans = "even";
  EXPECT_EQ(judge_map(map, nullptr, files).next,
            "sightline evaluate a.yaml --map a.slmap  # judges the map by the scans of its drive "
            "that did not make it");
  EXPECT_EQ(judge_map(map, nullptr, {}).next,
            "sightline evaluate CONFIG --map MAP  # judges it by evaluation: in CONFIG or its own "
            "other scans");
}

TEST(Verdict, AfterALongVerdictThePromiseKeepsOneLine) {
  MapJudgement judgement = judge_map(good_map(), nullptr, {});
  judgement.reason = "Reason";
  for (int i = 0; i < 40; ++i) judgement.reason += " of words";
  judgement.figures.clear();
  judgement.promise = "No promise for recorded drives (there is one of others). Elsewhere: at most";
  for (int i = 0; i < 20; ++i) judgement.promise += " so many";
  judgement.promise += ".";
  EXPECT_THAT(to_text(judgement), HasSubstr("\nNo promise for recorded drives.\nNext: "));
}

// Places 20 to 40 have no range; all of them, or all but 30 to 40, have a look.
TEST(Verdict, APlaceWithALookOrARangeIsAnswered) {
  CompiledMap map = with_unmet(20, 40);
  const CompiledMap with_all = map_with_plan();
  map.looks = with_all.looks;
  map.looks->ranges.plan.reset();
  MapJudgement judgement = judge_map(map, nullptr, {});
  EXPECT_EQ(judgement.verdict, kNotJudged) << to_text(judgement);
  EXPECT_DOUBLE_EQ(judgement.limits[0].answered_share, 1.0);
  for (std::size_t site = 30; site <= 40; ++site) {
    const std::size_t limits = map.ranges.promises.size();
    for (std::size_t limit = 0; limit < limits; ++limit) {
      map.looks->ranges.flags[site * limits + limit] = kUnmet;
    }
  }
  judgement = judge_map(map, nullptr, {});
  EXPECT_EQ(judgement.verdict, kPartly);
  EXPECT_EQ(
      judgement.reason,
      "No look or range keeps 10 cm at 18.3 % of the places (longest stretch 10 m, from place "
      "30).");
}

TEST(Verdict, OneTrackIsLostNotOneTracks) {
  const EvaluationFigures figures = replayed(0.98, 1);
  const MapJudgement judgement = judge_map(good_map(), &figures, {});
  EXPECT_THAT(judgement.figures, HasSubstr("and 1 track is lost"));
  EXPECT_THAT(judgement.reason, HasSubstr("ranges lost 1 track, the best"));
}

TEST(Verdict, ComparesWithTheConstantAnswerOfLeastWorkThatIsAsGood) {
  const LimitFigures figures = {0.1,
                                {},
                                {{"10 m", 0.90, 0.1, 0.1, 0},
                                 {"20 m", 0.97, 0.6, 0.3, 1},
                                 {"30 m", 0.98, 0.9, 0.5, 0},
                                 {"40 m", 0.98, 0.1, 0.5, 0},
                                 {"50 m", 0.99, 0.2, 1.0, 0}}};
  const auto beside = [&](double coverage, std::uint32_t lost) {
    return best_constant(figures, {AnswerKind::kRange, coverage, coverage, 0.2, 0.2, lost})->look;
  };
  EXPECT_EQ(beside(0.96, 1), "20 m");
  EXPECT_EQ(beside(0.96, 0), "30 m") << "20 m loses a track; 40 m is not the first";
  EXPECT_EQ(beside(0.999, 0), "50 m") << "none is as good: the one that keeps most";
}

TEST(Verdict, NamesTheFixedChoiceOfTheSameWork) {
  EvaluationFigures figures = replayed(0.99, 0);
  for (LimitFigures& limit : figures.limits) {
    limit.constants.push_back({"12 m", 0.97, 0.21, 0.21, 1});  // of 1.05 times its work
    limit.constants.push_back({"13 m", 0.98, 0.22, 0.22, 0});  // of more
    limit.constants.push_back({"5 m", 0.4, 0.1, 0.1, 9});      // keeps less
  }
  const MapJudgement judgement = judge_map(good_map(), &figures, {});
  EXPECT_THAT(judgement.figures,
              HasSubstr("with 40 % of the work (points times iterations) of the best fixed choice; "
                        "a fixed choice of the same work keeps 97.0 % and loses 1 track;"));
  EXPECT_EQ(to_json(judgement).at("limits").at(0).at("same_work_fixed").at("look"), "12 m");
}

TEST(Verdict, JsonOfAnyNameIsText) {
  CompiledMap map = good_map();
  map.measurement.localization_drive = "drive \xff";
  const MapJudgement judgement = judge_map(map, nullptr, {});
  EXPECT_THAT(json_text(to_json(judgement)), HasSubstr("drive \xef\xbf\xbd"));
}

TEST(Verdict, PromisesOfManyClausesAreShortened) {
  CompiledMap map = good_map();
  for (LimitPromise& promise : map.ranges.promises) {
    promise.statement = "No promise yet";
    for (int i = 0; i < 20; ++i) promise.statement += "; it needs more route, of more drives";
  }
  const MapJudgement judgement = judge_map(map, nullptr, {});
  EXPECT_LE(std::ranges::count(to_text(judgement), '\n'), 5);
  EXPECT_GT(judgement.promise.size(), 500U) << "the whole of it is in the JSON";
  EXPECT_LE(to_markdown(judgement).size(), 600U) << to_markdown(judgement);
}

TEST(Verdict, PromisesAreNotCutWithinBrackets) {
  CompiledMap map = good_map();
  for (LimitPromise& promise : map.ranges.promises) {
    promise.statement =
        "No promise: the model cannot distinguish the places (cross-validated R^2 -0.21; 70 m of "
        "route, a promise needs 1.2 km), so one look is used for the whole map: 100 m, 650 "
        "returns, "
        "evenly spaced beyond 30 m, 40 points by normals";
  }
  MapJudgement judgement = judge_map(map, nullptr, {});
  // Three lines of verdict leave one for the promise.
  judgement.figures = std::string(120, 'x') + " " + std::string(110, 'y');
  const std::string text = to_text(judgement);
  EXPECT_THAT(text, Not(HasSubstr("-0.21.")));
  EXPECT_THAT(text, HasSubstr("cannot distinguish the places, so one look is used"));
}

}  // namespace
}  // namespace sightline
