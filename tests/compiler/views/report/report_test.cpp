#include "compiler/views/report/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "compiler/views/report/sections/html.h"
#include "compiler/views/report/sections/sections.h"
#include "formats/text/numbers.h"
#include "tests/compiler/views/report/sources.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(Report, HoldsEveryTableAndFigure) {
  const std::string html = value_of(report_html(made_sources(1).sources()));
  for (const char* part :
       {"Table I.", "Table II.", "id=\"figure-5\"", "id=\"figure-6\"", "id=\"figure-7\"",
        "id=\"figure-8\"", "id=\"figure-10-0\"", "id=\"figure-10-1\"", "id=\"figure-11\"",
        "id=\"pareto-0\"", "id=\"pareto-1\"", "id=\"calibration\"", "id=\"correlations\"",
        "removed as moving", "build-ndt.cell_m", "ab12", ">limit 10 cm<"}) {
    EXPECT_THAT(html, HasSubstr(part));
  }
}

TEST(Report, TablesSayWhatTheEvaluationSays) {
  const MadeSources made = made_sources(2);
  const std::string html = value_of(report_html(made.sources()));
  for (const StaticScore& score : made.evaluation.statics) {
    EXPECT_THAT(html, HasSubstr("<td>" + fixed(100.0 * score.mean_error_m, 1) + "</td>"));
  }
  for (std::size_t limit = 0; limit < made.evaluation.limits_m.size(); ++limit) {
    const RuleScore& score = made.evaluation.score(limit, Rule::kMap);
    EXPECT_THAT(html,
                HasSubstr("<th scope=\"row\">this map</th><td>" + fixed(100.0 * score.coverage, 1) +
                          "</td><td>" + fixed(100.0 * score.mean_error_m, 1) + "</td><td>" +
                          fixed(100.0 * score.p95_error_m, 1) + "</td><td>" +
                          fixed(score.mean_range_m, 1) + "</td><td>" + fixed(score.time_ratio, 3)));
  }
}

TEST(Report, TellsWhereTheMapIsWeakWhereThatWasAsked) {
  const MadeSources made = made_sources(2);
  ReportSources sources = made.sources();
  EXPECT_THAT(*report_html(sources), Not(HasSubstr("Weak stretches")));
  ExplainedStretch one;
  one.stretch.worst_site = 7;
  one.stretch.worst = {every_return(50.0), 0.07, 0.75, 0.3, false};
  one.sights = {132, 4, 31.0, 0.9};
  one.cause = WeakCause::kDistant;
  one.advice.resize(1);
  one.advice[0].gain = 0.25;
  Weakness weakness;
  weakness.limit_m = 0.1;
  weakness.stretch_count = 1;
  weakness.stretches = {one};
  sources.weakness = &weakness;
  const std::string html = *report_html(sources);
  EXPECT_THAT(html, HasSubstr("Weak stretches"));
  EXPECT_THAT(html, HasSubstr("distant"));
  EXPECT_THAT(html, HasSubstr("Site 7: 4 of 132 upright surfaces seen within 50 m"));
  EXPECT_THAT(html, HasSubstr("25.0 % less"));
}

TEST(Report, ADiffNamesRouteThatIsNewOrNoLongerThere) {
  Stretch added;
  added.line_world_m = {Eigen::Vector3d(700.0, -64.0, 1.8), Eigen::Vector3d(701.0, -64.0, 1.8)};
  added.sites_added = 2;
  added.limits.resize(1);
  Stretch removed = added;
  removed.is_of_old_map = true;
  Stretch changed = added;
  changed.sites_added = 1;
  changed.limits[0].mean_range_before_m = 10.0;
  changed.limits[0].mean_range_after_m = 20.0;
  MapDiff diff;
  diff.after.root_digest[0] = 1;
  diff.stretches = {added, removed, changed};
  const MadeSources made = made_sources(1);
  ReportSources sources = made.sources();
  sources.diff = &diff;
  const std::string html = diff_section(sources).html;
  EXPECT_THAT(html, HasSubstr("<td>new</td>"));
  EXPECT_THAT(html, HasSubstr("<td>removed</td>"));
  EXPECT_THAT(html, HasSubstr("<td>10.0 → 20.0</td><td>+10.0</td>"));
  EXPECT_THAT(html, Not(HasSubstr("0.0 → 0.0")));
}

TEST(Report, EqualSourcesGiveEqualBytes) {
  EXPECT_EQ(*report_html(made_sources(3).sources()), *report_html(made_sources(3).sources()));
}

// Scripts may hold addresses in what they never show; the policy of the page keeps them from being
// asked.
TEST(Report, FetchesNothing) {
  const std::string html = *report_html(made_sources(4).sources());
  const std::string markup = html.substr(0, html.find("<script"));
  EXPECT_THAT(markup, HasSubstr("default-src 'none'"));
  for (const char* what : {"<link", "src=\"http", "href=\"http", "url(http", "@import"}) {
    EXPECT_EQ(markup.find(what), std::string::npos) << what;
  }
}

TEST(Report, TextsOfAMapCannotBecomeMarkup) {
  MadeSources made = made_sources(5);
  made.map.map_id = "<script>alert(1)</script>";
  made.evaluation.drive = "</script><b>";
  const std::string html = *report_html(made.sources());
  EXPECT_THAT(html, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(html, Not(HasSubstr("</script><b>")));
  EXPECT_THAT(html, HasSubstr("&lt;script&gt;alert(1)"));
}

TEST(Report, IsNamedAfterTheDriveElseAfterTheMap) {
  MadeSources made = made_sources(5);
  made.map.map_id = "0123abcd";
  made.map.measurement.mapping_drive = "old town, noon";
  std::string html = *report_html(made.sources());
  EXPECT_THAT(html, HasSubstr("<title>old town, noon – sightline report</title>"));
  EXPECT_THAT(html, HasSubstr("<h1>old town, noon</h1>\n<p>Map 0123abcd, version "));
  made.map.measurement.mapping_drive.clear();
  html = *report_html(made.sources());
  EXPECT_THAT(html, HasSubstr("<title>0123abcd – sightline report</title>"));
}

TEST(Report, OfAMapAloneSaysWhatIsNotKnown) {
  const MadeSources made = made_sources(6);
  ReportSources alone;
  alone.map = &made.map;
  const std::string html = value_of(report_html(alone));
  EXPECT_THAT(html, HasSubstr("there is no provenance file"));
  EXPECT_THAT(html, HasSubstr("the points of the drive were not available"));
  EXPECT_THAT(html, Not(HasSubstr("figure-5")));
}

TEST(Report, SaysFirstWhatIsPromisedAndReached) {
  MadeSources made = made_sources(1);
  LimitPromise& promise = made.map.ranges.promises[0];
  promise.alpha = 0.05;
  promise.is_earned = false;
  promise.scope = PromiseScope::kThisDrive;
  made.map.ranges.promises[1].is_earned = true;
  made.map.looks.reset();
  const EvaluationFigures figures = figures_of(made.map, made.evaluation, nullptr);
  ReportSources sources = made.sources();
  sources.figures = &figures;
  std::string html = *report_html(sources);
  html.resize(html.find("id=\"map\""));
  EXPECT_THAT(html, HasSubstr("<p class=\"word\">Verdict: "));
  EXPECT_THAT(html, HasSubstr("is-not-judged\">No promise for the next drive<"));
  EXPECT_THAT(
      html,
      HasSubstr("is-good\">Promised: at least 95.0 % of the answered sites of the next drive<"));
  const RuleScore& score = made.evaluation.score(0, Rule::kMap);
  EXPECT_THAT(html, HasSubstr(">By range: " + fixed(100.0 * score.coverage, 1) + " % of " +
                              std::to_string(made.evaluation.sites.size()) + " places"));
}

TEST(Report, TilesShowTheRecommendedAnswer) {
  MadeSources made = made_sources(1);
  ASSERT_TRUE(made.map.looks);
  RangeTable& looks = made.map.looks->ranges;
  LookPlan plan;
  plan.limit_m = looks.promises[1].limit_m;
  plan.first = looks.looks.front();
  plan.second = looks.looks.back();
  looks.plan = plan;
  std::string html = summary_section(made.sources()).html;
  // Of the tighter limit there is no plan.
  EXPECT_THAT(html, HasSubstr(">look<span class=\"unit\"> </span></div><div class=\"what\">"
                              "recommended within 10 cm: "));
  EXPECT_THAT(html, HasSubstr(">plan<span class=\"unit\"> </span></div><div class=\"what\">"
                              "recommended within 25 cm: " +
                              to_text(plan.first) + "; a larger look"));
  made.map.looks.reset();
  html = summary_section(made.sources()).html;
  EXPECT_THAT(html, HasSubstr(fixed(made.map.quality[0].mean_range_m, 1) +
                              "<span class=\"unit\"> m</span></div><div class=\"what\">"
                              "recommended within 10 cm: the range; its mean"));
  EXPECT_THAT(html, Not(HasSubstr(">look<")));
}

TEST(Report, TheFirstScreenIsVerdictAndMap) {
  const std::string html = *report_html(made_sources(1).sources());
  const std::size_t begin = html.find("<div class=\"first-screen\">");
  ASSERT_NE(begin, std::string::npos);
  const std::string first = html.substr(begin, html.find("id=\"ranges\"") - begin);
  EXPECT_THAT(first, HasSubstr("<section id=\"summary\">"));
  EXPECT_THAT(first, HasSubstr("<section id=\"map\">"));
  EXPECT_LT(first.find("id=\"map\""), first.find("</section>\n</div>"));
}

TEST(Report, NamesFactorsInWordsAndFoldsProvenance) {
  const std::string html = *report_html(made_sources(1).sources());
  EXPECT_THAT(html, HasSubstr("<th scope=\"row\">points of a virtual scan</th>"));
  EXPECT_THAT(html, Not(HasSubstr("<th scope=\"row\">virtual_points</th>")));
  EXPECT_THAT(html, HasSubstr("<details><summary>Files, versions and inputs</summary>"));
}

TEST(Report, SaysWhatTheGateSaid) {
  const MadeSources made = made_sources(1);
  const GateResult gate = {
      std::string(64, '0'), false, 1, 2, 3, 4, {{"unmet-share", "error", "a <b> too many", 40}}};
  ReportSources sources = made.sources();
  sources.gate = &gate;
  const std::string html = *report_html(sources);
  EXPECT_THAT(html, HasSubstr("is-bad\">Failed: 1 errors, 2 warnings, 3 notes, 4 excepted<"));
  EXPECT_THAT(html, HasSubstr("error, unmet-share: a &lt;b&gt; too many (<a href=\"#site=40\">"));
  sources.summary.root_digest[0] = 1;
  EXPECT_EQ(report_html(sources).error().code, ErrorCode::kMismatchedInputs);
}

int green_of(const std::string& css, const std::string& name) {
  const std::size_t at = css.find("--" + name + ":#");
  return at == std::string::npos ? -1 : std::stoi(css.substr(at + name.size() + 6, 2), nullptr, 16);
}

TEST(Report, ColoursSpanTheRangesThatOccur) {
  MadeSources made = made_sources(1);
  for (std::uint8_t& range : made.map.ranges.range_index) range %= 2;  // 10 and 20 of 10, 20, 50 m
  const std::string css = colours_css(made.map);
  EXPECT_GT(green_of(css, "range-1") - green_of(css, "range-0"), 100);
  EXPECT_GT(green_of(css, "range-2"), green_of(css, "range-1"));
  EXPECT_LT(green_of(css, "range-zero"), green_of(css, "range-0"));
}

TEST(Report, OneRangeEverywhereHasAColourOfTheMiddle) {
  MadeSources made = made_sources(1);
  for (std::uint8_t& range : made.map.ranges.range_index) range = 2;
  const int green = green_of(colours_css(made.map), "range-2");
  EXPECT_GT(green, 60);
  EXPECT_LT(green, 220);
}

TEST(Report, RefusesWhatIsOfAnotherMap) {
  MadeSources made = made_sources(7);
  made.depth.site_count = 149;
  EXPECT_EQ(report_html(made.sources()).error().code, ErrorCode::kMismatchedInputs);
  made = made_sources(7);
  made.evaluation.site_count = 10;
  EXPECT_EQ(report_html(made.sources()).error().code, ErrorCode::kMismatchedInputs);
}

TEST(Report, RefusesAProvenanceThatIsNotJson) {
  const MadeSources made = made_sources(8);
  ReportSources sources = made.sources();
  sources.provenance = "[1, 2";
  const Error html = failure_of(report_html(sources));
  EXPECT_EQ(html.code, ErrorCode::kMalformedText);
  EXPECT_EQ(html.file, "made.slmap.provenance.json");
}

}  // namespace
}  // namespace sightline
