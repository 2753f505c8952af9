#include "compiler/views/report/page/page_data.h"

#include <gtest/gtest.h>
#include <png.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "compiler/views/report/page/pictures.h"
#include "compiler/views/text/describe_protection.h"
#include "compiler/views/text/describe_site.h"
#include "compiler/views/verdict/recommended_answer.h"
#include "compiler/views/verdict/verdict.h"
#include "formats/base/random.h"
#include "tests/compiler/views/report/sources.h"
#include "tests/compiler/views/report/unpacked.h"

namespace sightline {
namespace {

using Json = nlohmann::json;
Json data_of(const MadeSources& made) { return Json::parse(page_data_json(made.sources())); }

std::vector<unsigned char> greys_of(const std::string& base64_png) {
  const std::vector<unsigned char> file = bytes_of_base64(base64_png);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&image, file.data(), file.size()) == 0) return {};
  image.format = PNG_FORMAT_GRAY;
  std::vector<unsigned char> greys(PNG_IMAGE_SIZE(image));
  png_image_finish_read(&image, nullptr, greys.data(), 0, nullptr);
  return greys;
}

template <class T>
std::vector<float> as_floats(const std::vector<T>& values) {
  return {values.begin(), values.end()};
}

TEST(PageData, HoldsTheNumbersOfMapAndEvaluation) {
  const MadeSources made = made_sources(1);
  const Json data = data_of(made);
  EXPECT_EQ(data.at("ranges_m").get<std::vector<double>>(), ranges_of(made.map.ranges.looks));
  EXPECT_EQ(unpacked<float>(data["predicted"]["mean_m"]), as_floats(made.map.predicted.mean_m));
  EXPECT_EQ(unpacked<float>(data["predicted"]["probability"]),
            as_floats(made.map.predicted.within_probability));
  EXPECT_EQ(unpacked<std::uint8_t>(data["choice"]["range_index"]), made.map.ranges.range_index);
  EXPECT_EQ(unpacked<std::uint8_t>(data["choice"]["flags"]), made.map.ranges.flags);
  EXPECT_EQ(unpacked<float>(data["judged"]["error_m"]), as_floats(made.evaluation.error_m));
  EXPECT_EQ(unpacked<float>(data["judged"]["time_ms"]), as_floats(made.evaluation.time_ms));
  EXPECT_EQ(unpacked<std::uint8_t>(data["judged"]["chosen"]), made.evaluation.chosen_range_index);
  const std::vector<std::uint32_t> judged = unpacked<std::uint32_t>(data["judged"]["site"]);
  ASSERT_EQ(judged.size(), made.evaluation.sites.size());
  for (std::size_t i = 0; i < judged.size(); ++i) {
    EXPECT_EQ(judged[i], made.evaluation.sites[i].site);
  }
}

TEST(PageData, HoldsWhatTheMapAnswersAtEachPlace) {
  const MadeSources made = made_sources(1);
  ASSERT_TRUE(made.map.looks);
  const Json answers = data_of(made)["answers"];
  const MapJudgement judgement = judge_map(made.map, nullptr, {});
  const std::size_t limits = judgement.limits.size();
  ASSERT_EQ(answers["recommended"].size(), limits);
  EXPECT_EQ(answers["looks"][0], to_text(made.map.looks->ranges.looks[0]));
  EXPECT_EQ(answers["looks_range_m"][0], made.map.looks->ranges.looks[0].range_m);
  const std::vector<std::uint8_t> kinds = unpacked<std::uint8_t>(answers["kind"]);
  const std::vector<std::uint8_t> choices = unpacked<std::uint8_t>(answers["choice"]);
  const std::vector<float> mean_m = unpacked<float>(answers["mean_m"]);
  const std::vector<float> probability = unpacked<float>(answers["probability"]);
  for (std::size_t site = 0; site < made.map.sites.sites.size(); ++site) {
    for (std::size_t limit = 0; limit < limits; ++limit) {
      const AnswerKind recommended = judgement.limits[limit].recommended;
      EXPECT_EQ(answers["recommended"][limit], name_of(recommended));
      const RecommendedAnswer answer = recommended_answer(made.map, recommended, site, limit);
      const std::size_t at = site * limits + limit;
      EXPECT_EQ(kinds.at(at), answer.is_good ? static_cast<int>(answer.kind) : 3);
      EXPECT_EQ(choices.at(at), answer.choice);
      EXPECT_EQ(mean_m.at(at), static_cast<float>(answer.mean_error_m));
      EXPECT_EQ(probability.at(at), static_cast<float>(answer.probability));
    }
  }
}

TEST(PageData, HoldsKindsOfPlaceAndProtectionWhereTheMapHasThem) {
  MadeSources made = made_sources(1);
  made.map.columns.clear();
  EXPECT_TRUE(data_of(made)["places"].empty());
  SiteColumn kinds = {"place_kind", "", {}};
  for (std::size_t site = 0; site < made.map.sites.sites.size(); ++site) {
    kinds.values.push_back(site == 3 ? 2.0F : 1.0F);
  }
  made.map.columns = {kinds};
  const Json places = data_of(made)["places"];
  const std::vector<std::uint8_t> kind = unpacked<std::uint8_t>(places["kind"]);
  EXPECT_EQ(places["kinds"][kind.at(3)], "canyon");
  EXPECT_EQ(places["kinds"][kind.at(4)], "lane");
  const std::vector<float> levels_m = unpacked<float>(places["protection_m"]);
  ASSERT_EQ(levels_m.size(), 3 * kind.size());
  const SiteProtection expected = protection_at(made.map, 4);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(levels_m[12 + axis], static_cast<float>(expected.levels[axis]));
  }
}

TEST(PageData, NoNameEndsTheScriptThatItIsIn) {
  MadeSources made = made_sources(1);
  made.evaluation.drive = "</script> \"a\\b\"\n\t\x01 \xff";  // the last is no UTF-8
  const std::string text = page_data_json(made.sources());
  EXPECT_EQ(text.find('<'), std::string::npos);
  EXPECT_EQ(Json::parse(text)["judged"]["drive"], "</script> \"a\\b\"\n\t\x01 \ufffd");
}

TEST(PageData, HoldsSitesAndTheirTexts) {
  const MadeSources made = made_sources(2);
  const Json data = data_of(made);
  const std::vector<double> x_m = unpacked<double>(data["sites"]["x_m"]);
  const std::size_t per_block = data["texts"]["sites_per_block"].get<std::size_t>();
  ASSERT_EQ(x_m.size(), made.map.sites.sites.size());
  for (std::size_t site = 0; site < x_m.size(); ++site) {
    EXPECT_EQ(x_m[site], made.map.sites.sites[site].p_map_m.x());
    const std::string& block =
        data["texts"]["blocks"][site / per_block].get_ref<const std::string&>();
    const std::vector<unsigned char> bytes = inflated(block, 1U << 20U);
    auto begin = bytes.begin();
    for (std::size_t i = 0; i < site % per_block; ++i) begin = std::find(begin, bytes.end(), 0) + 1;
    EXPECT_EQ(std::string(begin, std::find(begin, bytes.end(), 0)), *describe_site(made.map, site));
  }
}

TEST(PageData, WaysOfAllRunsAreLaidEndToEnd) {
  const MadeSources made = made_sources(3);
  const std::vector<double> route_m = unpacked<double>(data_of(made)["sites"]["route_m"]);
  for (std::size_t i = 0; i < route_m.size(); ++i) {
    EXPECT_NEAR(route_m[i], static_cast<double>(i), 1e-9);
  }
}

TEST(PageData, NdsAreWhereTheyAre) {
  const MadeSources made = made_sources(4);
  const Json nds = data_of(made)["nds"];
  std::size_t i = 0;
  for (const Json& tile : nds["tiles"]) {
    const std::vector<std::uint16_t> place = unpacked<std::uint16_t>(tile["place_m"]);
    const std::vector<std::uint16_t> height = unpacked<std::uint16_t>(tile["height"]);
    const std::vector<std::uint16_t> radius = unpacked<std::uint16_t>(tile["radius"]);
    const std::vector<std::uint8_t> turn = unpacked<std::uint8_t>(tile["turn"]);
    const std::vector<std::uint16_t> rise = unpacked<std::uint16_t>(tile["rise"]);
    const std::vector<std::uint8_t> tilt = unpacked<std::uint8_t>(tile["tilt"]);
    for (std::size_t k = 0; k < height.size(); ++k, ++i) {
      const Nd& nd = made.map.ndt.nds[i];
      EXPECT_NEAR((tile["x"].get<int>() + place[2 * k] / 65535.0) * 64.0, nd.mean_m.x(), 1e-3);
      EXPECT_NEAR((tile["y"].get<int>() + place[2 * k + 1] / 65535.0) * 64.0, nd.mean_m.y(), 1e-3);
      EXPECT_NEAR(nds["lowest_z_m"].get<double>() + 0.01 * height[k], nd.mean_m.z(), 0.006);
      // Two standard deviations along the direction that `turn` names are the longer radius.
      const double angle = turn[k] * std::numbers::pi / 256.0;
      const Eigen::Vector2d along(std::cos(angle), std::sin(angle));
      const double variance = along.dot(nd.covariance_m2.topLeftCorner<2, 2>() * along);
      EXPECT_NEAR(0.001 * radius[2 * k], 2.0 * std::sqrt(variance),
                  0.002 + 2e-3 * radius[2 * k] * 1e-3);
      EXPECT_GE(radius[2 * k], radius[2 * k + 1]);
      // Height: its spread, and how much of it goes with either axis from above.
      EXPECT_NEAR(0.001 * rise[k], 2.0 * std::sqrt(nd.covariance_m2(2, 2)), 0.001);
      const double shared_m2 = along.dot(nd.covariance_m2.block<2, 1>(0, 2));
      const double step_m2 = 0.25e-6 * radius[2 * k] * rise[k];  // of a correlation of 1
      EXPECT_NEAR(step_m2 * (tilt[2 * k] / 127.0 - 1.0), shared_m2, 0.02 * step_m2 + 1e-5);
    }
  }
  EXPECT_EQ(i, made.map.ndt.nds.size());
}

TEST(PageData, DepthImagesReadBackToHalfAStep) {
  const MadeSources made = made_sources(5);
  const Json depth = data_of(made)["depth"];
  const std::vector<std::uint32_t> sites = unpacked<std::uint32_t>(depth["site"]);
  ASSERT_FALSE(sites.empty());
  const std::vector<unsigned char> greys = greys_of(depth["images"][1].get<std::string>());
  ASSERT_EQ(greys.size(), 360U * 31U);
  for (std::size_t row = 0; row < 31; ++row) {
    for (std::size_t column = 0; column < 360; ++column) {
      // The middle is map +x, to its left +y; the upper row is the highest.
      const std::size_t azimuth = (180 + 359 - column) % 360;
      const double distance_m =
          static_cast<double>(made.depth.image_of(sites[1])[(30 - row) * 360 + azimuth]);
      const unsigned char grey = greys[row * 360 + column];
      if (distance_m > 50.0) {
        EXPECT_EQ(grey, 255);
      } else {
        EXPECT_NEAR(grey * 50.0 / 254.0, distance_m, 0.1);
      }
    }
  }
}

TEST(PageData, ManyDepthImagesAreThinnedOut) {
  DepthImages images;
  images.site_count = 6000;
  images.azimuth_count = 90;
  Random random(1);
  for (std::size_t i = 0; i < images.cells_per_site() * images.site_count; ++i) {
    images.distance_m.push_back(static_cast<float>(random.uniform(0.0, 50.0)));
  }
  const PageJson json = depth_json(images, 1.0);
  EXPECT_LT(json.dump().size(), 3'500'000U);
  const std::vector<std::uint32_t> sites = unpacked<std::uint32_t>(json["site"]);
  EXPECT_GT(sites.size(), 600U);
  EXPECT_EQ(sites[0], 0U);
  EXPECT_GE(sites[1], 2U);
  EXPECT_EQ(sites[2] - sites[1], sites[1] - sites[0]);
}

TEST(PageData, WhatMovedLiesInColumnsOfVoxels) {
  const Json tiles = data_of(made_sources(6))["moved"]["tiles"];
  ASSERT_EQ(tiles.size(), 2U);
  EXPECT_EQ(tiles[0]["x"], -2);  // -75 m
  EXPECT_EQ(unpacked<std::uint8_t>(tiles[0]["height"]), std::vector<std::uint8_t>{2});
  EXPECT_EQ(unpacked<std::uint16_t>(tiles[0]["cell"]), (std::vector<std::uint16_t>{212, 5}));
  EXPECT_EQ(unpacked<std::uint16_t>(tiles[1]["cell"]), (std::vector<std::uint16_t>{4, 4}));
}

TEST(PageData, ReliefTellsHeightsOverTheRoad) {
  MadeSources made = made_sources(7);
  for (Site& site : made.map.sites.sites) site.p_map_m.z() = made.map.sensor.height_m;
  const Json relief = data_of(made)["relief"];
  ASSERT_EQ(relief["tiles"].size(), 1U);
  const std::vector<unsigned char> greys = greys_of(relief["tiles"][0]["image"].get<std::string>());
  ASSERT_EQ(greys.size(), 256U * 256U);
  // Patch 10 reaches from x = 5 to 5.5 m and lies at 5 m.
  const unsigned char grey = greys[255 * 256 + 21];
  EXPECT_NEAR(relief["lowest_m"].get<double>() + relief["step_m"].get<double>() * (grey - 1), 5.0,
              0.03);
  EXPECT_EQ(greys[0], 0);
}

template <class T>
void expect_back(const std::vector<T>& values, const std::string& type) {
  const PageJson json = json_numbers(values);
  EXPECT_EQ(json.at("type"), type);
  EXPECT_EQ(unpacked<T>(json), values);
}

TEST(Packed, AnyArrayReadsBackExactly) {
  std::mt19937_64 random(7);
  for (std::size_t count = 0; count < 300; count = 2 * count + 1) {
    std::vector<std::uint8_t> bytes;
    std::vector<std::uint16_t> shorts;
    std::vector<std::uint32_t> words;
    std::vector<float> floats;
    std::vector<double> doubles;
    for (std::size_t i = 0; i < count; ++i) {
      bytes.push_back(static_cast<std::uint8_t>(random()));
      shorts.push_back(static_cast<std::uint16_t>(random()));
      words.push_back(static_cast<std::uint32_t>(random()));
      doubles.push_back(static_cast<double>(random()) / 3.0);
      floats.push_back(static_cast<float>(doubles.back()));
    }
    expect_back(bytes, "u8");
    expect_back(shorts, "u16");
    expect_back(words, "u32");
    expect_back(floats, "f32");
    expect_back(doubles, "f64");
  }
}

TEST(Packed, FourDigitsAreKeptAndNoMore) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> exponent(-12.0, 12.0);
  for (int i = 0; i < 10000; ++i) {
    const double value = (i % 2 == 0 ? 1.0 : -1.0) * std::pow(10.0, exponent(random));
    EXPECT_NEAR(four_digits(value), value, std::abs(value) / 16384.0);
  }
  EXPECT_EQ(four_digits(0.0), 0.0F);
  EXPECT_EQ(four_digits(0.5), 0.5F);
  EXPECT_TRUE(std::isinf(four_digits(std::numeric_limits<double>::infinity())));
}

Site site_at(double x_m, double y_m, double z_m) {
  Site site;
  site.p_map_m = {x_m, y_m, z_m};
  return site;
}

TEST(Relief, RoadIsAsHighAsTheNearestSiteSays) {
  Sites sites;
  Random random(5);
  for (int i = 0; i < 200; ++i) {
    // A spot each, so that none hides another.
    const int row = i / 20;
    sites.sites.push_back(site_at(20.0 * (i % 20), 20.0 * row, random.uniform(0.0, 9.0)));
  }
  const RoadHeight road(sites, 1.5);
  for (int k = 0; k < 500; ++k) {
    const double x_m = random.uniform(-50.0, 450.0);
    const double y_m = random.uniform(-50.0, 250.0);
    const auto apart_m = [&](const Site& site) {
      return std::hypot(site.p_map_m.x() - x_m, site.p_map_m.y() - y_m);
    };
    const auto nearest =
        std::min_element(sites.sites.begin(), sites.sites.end(),
                         [&](const Site& a, const Site& b) { return apart_m(a) < apart_m(b); });
    EXPECT_DOUBLE_EQ(road.at(x_m, y_m), nearest->p_map_m.z() - 1.5);
  }
  EXPECT_EQ(RoadHeight(Sites{}, 1.0).at(3.0, 4.0), 0.0);
}

TEST(Relief, TheHighestPatchIsSeenAndNothingIsZero) {
  Sites sites;
  sites.sites = {site_at(0.0, 0.0, 2.0)};
  const RoadHeight road(sites, 2.0);
  Surface surface;
  surface.patches = {{{0, 0, 0}, {1.0, 1.0, 0.0}, {0, 0, 1}, 0.5},
                     {{0, 0, 1}, {1.0, 1.0, 3.0}, {0, 0, 1}, 0.5},
                     {{0, 1, 0}, {3.0, 1.0, 40.0}, {1, 0, 0}, 0.5}};
  const GreyRaster raster = relief_picture(surface, {0, 1, 2}, road, {0.0, 0.0, 4.0, 2.0}, 0.5);
  ASSERT_EQ(raster.width, 8U);
  ASSERT_EQ(raster.height, 4U);
  EXPECT_NEAR(relief_height_m(raster.at(2, 2)), 3.0, 0.03);
  EXPECT_EQ(raster.at(0, 0), 0);
  EXPECT_EQ(raster.at(6, 2), 255);  // as high as can be shown
  EXPECT_EQ(raster.at(4, 2), 0);    // beside the wall
}

}  // namespace
}  // namespace sightline
