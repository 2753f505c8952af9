#include <gtest/gtest.h>

#include <filesystem>

#include "compiler/pipeline/runner.h"
#include "compiler/store/cache.h"
#include "formats/annotation/site_column.h"
#include "formats/surroundings/ndt_map.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

NdtMap row_of_nds(int count) {
  NdtMap map;
  map.cell_m = 2.0;
  map.tile_m = 8.0;
  for (int i = 0; i < count; ++i) {
    Nd nd;
    nd.key = {i, 0, 0};
    nd.point_count = 10;
    nd.mean_m = cell_centre_m(nd.key, map.cell_m);
    nd.covariance_m2.diagonal() = Eigen::Vector3d(0.3, 0.2, 0.1);
    decompose(nd);
    map.nds.push_back(nd);
  }
  return map;
}

Result<TiledNds> copy_nds(PassContext& /*ctx*/, const NoOptions& /*options*/, const TiledNds& nds) {
  return nds;
}

Result<SiteColumn> count_tiles(PassContext& /*ctx*/, const NoOptions& /*options*/,
                               const TiledNds& nds) {
  return SiteColumn{"tiles", "", {static_cast<float>(nds.tiles().size())}};
}

Result<SiteColumn> count_nds(PassContext& /*ctx*/, const NoOptions& /*options*/,
                             const NdtMap& nds) {
  return SiteColumn{"nds", "", {static_cast<float>(nds.nds.size())}};
}

constexpr Pass kCopyNds{"copy-nds", 1, "copy", "The same", &copy_nds};
constexpr Pass kCountTiles{"count-tiles", 1, "tiles", "How many tiles there are", &count_tiles};
constexpr Pass kCountNds{"count-nds", 1, "count", "How many NDs there are", &count_nds};

class ArtifactForms : public TestInFolder {
 protected:
  ArtifactForms() { options_.cache_directory = folder_; }

  // provided -> copy -> tiles, nds; and of what was provided.
  enum class Wants { kAll, kCounts };
  void run(Wants wants) {
    Plan plan;
    const Wire<NdtMap> provided = plan.input<NdtMap>("provided");
    copy_ = plan.run(kCopyNds, provided);
    tiles_ = plan.run(kCountTiles, copy_);
    nds_ = plan.run(kCountNds, copy_);
    of_provided_ = plan.run_as("provided", kCountNds, {}, provided);
    artifacts_ = {};
    artifacts_.provide(provided, row_of_nds(10));
    std::vector<AnyWire> wanted;
    if (wants == Wants::kCounts) wanted = {tiles_, nds_, of_provided_};
    reports_.clear();
    require(run_plan(plan, wanted, options_, observer_, artifacts_, reports_));
    EXPECT_EQ(artifacts_.get(tiles_).values.front(), 3.0);
    EXPECT_EQ(artifacts_.get(nds_).values.front(), 10.0);
    EXPECT_EQ(artifacts_.get(of_provided_).values.front(), 10.0);
  }

  RunOptions options_;
  RunObserver observer_;
  ArtifactSet artifacts_;
  std::vector<StepReport> reports_;
  Wire<NdtMap> copy_;
  Wire<SiteColumn> tiles_;
  Wire<SiteColumn> nds_;
  Wire<SiteColumn> of_provided_;
};

TEST_F(ArtifactForms, WhoWantsAnArtifactHasItWholeMadeOrLoaded) {
  for (int i = 0; i < 2; ++i) {
    run(Wants::kAll);
    EXPECT_EQ(reports_.front().from_cache, i == 1);
    EXPECT_TRUE(to_bytes(artifacts_.get(copy_)) == to_bytes(row_of_nds(10)));
  }
}

TEST_F(ArtifactForms, PassesHaveItInTheirOwnMadeLoadedAndWithoutACache) {
  run(Wants::kCounts);
  EXPECT_FALSE(artifacts_.has(copy_));
  for (const auto& entry : std::filesystem::directory_iterator(options_.cache_directory)) {
    if (entry.path().filename().string().starts_with("count-")) {
      std::filesystem::remove(entry.path());
    }
  }
  run(Wants::kCounts);
  EXPECT_TRUE(reports_.front().from_cache);
  EXPECT_FALSE(reports_[1].from_cache);
  options_.cache_directory.clear();
  run(Wants::kCounts);
}

TEST_F(ArtifactForms, TheStoreHoldsTheBytesOfTheWhole) {
  run(Wants::kAll);
  const ArtifactCache cache(options_.cache_directory);
  const Result<ArtifactCache::Content> stored = cache.load("copy-nds", artifacts_.entry(copy_).key);
  ASSERT_TRUE(stored && *stored);
  EXPECT_TRUE(**stored == to_bytes(row_of_nds(10)));
}

TEST_F(ArtifactForms, ArePrintedAsTheWholeIs) {
  std::vector<Table> printed;
  observer_.printed = [&](const std::string&, const Table& table) { printed.push_back(table); };
  options_.print_after = {"copy-nds"};
  for (const bool keeps : {true, false}) {
    options_.keeps_wanted = keeps;
    if (keeps) {
      run(Wants::kAll);
      ASSERT_EQ(printed.size(), 1U);
      EXPECT_EQ(printed.front().rows, dump(row_of_nds(10)).rows);
    }
  }
}

Result<NdtMap> make_whole(PassContext& /*ctx*/, const NoOptions& /*options*/, const NdtMap& nds) {
  return nds;
}

Result<SiteColumn> count_tiles_and_report(PassContext& ctx, const NoOptions& options,
                                          const TiledNds& nds) {
  ctx.progress(0, 1);
  return count_tiles(ctx, options, nds);
}

constexpr Pass kMakeWhole{"make-whole", 1, "whole", "The same, whole", &make_whole};
constexpr Pass kReport{"count-tiles", 1, "tile-count", "How many tiles there are",
                       &count_tiles_and_report};
constexpr Pass kReportAgain{"count-tiles-again", 1, "tile-count-again", "The number again",
                            &count_tiles_and_report};

TEST_F(ArtifactForms, OfAWholeTheLastToTakeAFormReadsItFromTheStore) {
  Plan plan;
  const Wire<NdtMap> provided = plan.input<NdtMap>("provided");
  const Wire<NdtMap> whole = plan.run(kMakeWhole, provided);
  const Wire<SiteColumn> first = plan.run(kReport, whole);
  const Wire<SiteColumn> last = plan.run(kReportAgain, whole);
  std::vector<bool> is_form;  // of the entry, while a step runs
  observer_.progress = [&](std::size_t, std::size_t) {
    is_form.push_back(artifacts_.entry(whole).type->is_form);
  };
  const auto run_with = [&](const std::string& cache, std::vector<AnyWire> wanted) {
    is_form.clear();
    artifacts_ = {};
    artifacts_.provide(provided, row_of_nds(10));
    options_.cache_directory = cache;
    require(run_plan(plan, wanted, options_, observer_, artifacts_, reports_));
    EXPECT_EQ(artifacts_.get(first).values.front(), 3.0);
    EXPECT_EQ(artifacts_.get(last).values.front(), 3.0);
  };
  const std::string cache = options_.cache_directory;
  run_with(cache, {first, last});
  EXPECT_EQ(is_form, (std::vector<bool>{false, true}));
  run_with("", {first, last});
  EXPECT_EQ(is_form, (std::vector<bool>{false, false}));
  std::filesystem::remove_all(cache);
  run_with(cache, {whole, first, last});
  EXPECT_EQ(is_form, (std::vector<bool>{false, false}));
  EXPECT_TRUE(to_bytes(artifacts_.get(whole)) == to_bytes(row_of_nds(10)));
}

TEST(InForm, GivesAnyFormOfAnother) {
  const NdtMap map = row_of_nds(10);
  const ArtifactSet::Entry whole{&artifact_type<NdtMap>(), std::make_shared<const NdtMap>(map), {}};
  EXPECT_EQ(value_of(in_form(whole, artifact_type<NdtMap>())), whole.value);
  const std::shared_ptr<const void> tiled = value_of(in_form(whole, artifact_type<TiledNds>()));
  EXPECT_EQ(static_cast<const TiledNds*>(tiled.get())->tiles().size(), 3U);
  const std::shared_ptr<const void> back =
      value_of(in_form({&artifact_type<TiledNds>(), tiled, {}}, artifact_type<NdtMap>()));
  EXPECT_TRUE(to_bytes(*static_cast<const NdtMap*>(back.get())) == to_bytes(map));
}

}  // namespace
}  // namespace sightline
