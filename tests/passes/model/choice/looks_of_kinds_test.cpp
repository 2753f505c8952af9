#include "passes/model/choice/looks_of_kinds.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"

namespace sightline {
namespace {

// A street of stretches of 120 m, a site every metre, whose kinds alternate. Three looks of costs
// 300, 400 and 1200 miss at these shares of the sites of a kind.
struct Street {
  PlaceKind kind = PlaceKind::kCanyon;
  std::vector<double> miss_share;  // [look]
};

LookErrors errors_at(const std::vector<Street>& sites, std::uint64_t seed) {
  Random random(seed);
  LookErrors errors;
  for (const Street& site : sites) {
    for (const double share : site.miss_share) {
      errors.error_m.push_back(random.uniform() < share ? 0.3 : 0.05);
    }
    errors.is_measured.push_back(1);
  }
  return errors;
}

LookEvidence evidence_of(const std::vector<Street>& stretches, std::uint64_t seed = 1) {
  constexpr std::size_t kStretch = 120;
  std::vector<Street> sites;
  for (const Street& stretch : stretches) sites.insert(sites.end(), kStretch, stretch);
  LookEvidence evidence;
  evidence.shape = {3};
  evidence.cost = {300.0, 400.0, 1200.0};
  for (std::size_t site = 0; site < sites.size(); ++site) {
    evidence.kinds.push_back(sites[site].kind);
    evidence.route.push_back({0, static_cast<double>(site)});
  }
  evidence.own = errors_at(sites, seed);
  evidence.drives = {errors_at(sites, seed + 100)};
  return evidence;
}

const Street kEasy = {PlaceKind::kCanyon, {0.0, 0.0, 0.0}};
const Street kHard = {PlaceKind::kOpen, {0.3, 0.15, 0.0}};
const Street kHopeless = {PlaceKind::kAvenue, {0.9, 0.8, 0.6}};

std::vector<Street> twice(std::vector<Street> stretches) {
  const std::vector<Street> once = stretches;
  stretches.insert(stretches.end(), once.begin(), once.end());
  return stretches;
}

TEST(LooksOfKinds, AreTheCheapestConstantThatItsEvidenceSupports) {
  const KindLooks looks = choose_kind_looks(evidence_of({kEasy, kEasy}), 0.1, 0.025);
  EXPECT_EQ(looks.everywhere, 0);
  EXPECT_EQ(looks.of_kind, (std::array<std::uint8_t, kPlaceKindCount>{}));
  EXPECT_EQ(looks.coverage, 1.0);
  EXPECT_EQ(choose_kind_looks(evidence_of({kHard, kHard}), 0.1, 0.025).everywhere, 2);
  EXPECT_EQ(choose_kind_looks(evidence_of({kHard, kHard}), 0.1, 0.2).everywhere, 1);
}

TEST(LooksOfKinds, DifferWhereThatIsProvenCheaper) {
  const KindLooks looks = choose_kind_looks(evidence_of(twice({kEasy, kHard})), 0.1, 0.025);
  EXPECT_EQ(looks.everywhere, 2);
  EXPECT_EQ(looks.at(kEasy.kind), 0);
  EXPECT_EQ(looks.at(kHard.kind), 2);
}

// 120 m are four blocks of 30 m: too few for any test.
TEST(LooksOfKinds, DoNotDifferOnAShortDrive) {
  LookEvidence evidence = evidence_of({kEasy});
  for (std::size_t site = 60; site < 120; ++site) {
    evidence.kinds[site] = kHard.kind;
    for (std::size_t look = 0; look < 2; ++look) {
      evidence.own.error_m[evidence.shape.index(site, look)] = 0.3;
    }
  }
  const KindLooks looks = choose_kind_looks(evidence, 0.1, 0.025);
  EXPECT_EQ(looks.at(kEasy.kind), 2);
  EXPECT_EQ(looks.at(kHard.kind), 2);
}

// In uniform streets luck makes kinds differ, and the other half of the blocks does not bear it
// out.
TEST(LooksOfKinds, RarelyDifferByLuck) {
  int different = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Street one = {PlaceKind::kCanyon, {0.03, 0.02, 0.01}};
    Street other = one;
    other.kind = PlaceKind::kOpen;
    const KindLooks looks =
        choose_kind_looks(evidence_of(twice({one, other}), 7 * seed), 0.1, 0.025);
    different += looks.at(one.kind) != looks.at(other.kind) ? 1 : 0;
  }
  EXPECT_LE(different, 10);
}

TEST(LooksOfKinds, GiveUpWhereNoLookHoldsAndAreNotMadeDearByIt) {
  const KindLooks looks =
      choose_kind_looks(evidence_of(twice({kEasy, kEasy, kHopeless})), 0.1, 0.025);
  EXPECT_EQ(looks.everywhere, 0);
  EXPECT_EQ(looks.at(kEasy.kind), 0);
}

// Where no look is good enough anywhere, the cheapest is no answer.
TEST(LooksOfKinds, CoverMostWhereNothingCoversEnough) {
  EXPECT_EQ(choose_kind_looks(evidence_of({kHopeless, kHopeless}), 0.1, 0.025).everywhere, 2);
}

// The map's own scans lie well in the map that they made.
TEST(LooksOfKinds, BelieveTheLowerOfTwoCoverages) {
  LookEvidence evidence = evidence_of({kHard, kHard});
  std::ranges::fill(evidence.own.error_m, 0.01);
  EXPECT_EQ(choose_kind_looks(evidence, 0.1, 0.025).everywhere, 2);
  evidence.drives.clear();
  EXPECT_EQ(choose_kind_looks(evidence, 0.1, 0.025).everywhere, 0);
}

TEST(LooksOfKinds, DoNotDifferBySimulatedErrors) {
  LookEvidence evidence = evidence_of(twice({kEasy, kHard}));
  evidence.is_simulated = true;
  const KindLooks looks = choose_kind_looks(evidence, 0.1, 0.025);
  EXPECT_EQ(looks.at(kEasy.kind), looks.at(kHard.kind));
}

}  // namespace
}  // namespace sightline
