#include <gtest/gtest.h>

#include <cmath>

#include "examples/ros2/src/observation_node.h"
#include "formats/map/map_writer.h"
#include "tests/formats/foreign/foreign_files.h"
#include "tests/formats/map/random_map.h"

// The example's node over headers that tests/examples/ros2_headers.py makes: what it publishes and
// sets, beside what the reader answers.

namespace sightline_ros2 {
namespace {

using sightline::CompiledMap;
using sightline::LookAnswer;
using sightline::MapReader;
using sightline::RangeAnswer;
const std::string kCropBox = "/crop_box";
const std::string kDownsample = "/downsample";

class Ros2Node : public testing::Test {
 protected:
  void SetUp() override {
    rclcpp::recorded() = {};
    rclcpp::recorded().is_ready = {{kCropBox, true}, {kDownsample, true}};
    map_ = sightline::random_map({.seed = 2, .site_count = 60, .extent_m = 40.0});
    const std::vector<std::byte> bytes = sightline::encode_map(map_);
    std::string text(bytes.size(), '\0');
    std::memcpy(text.data(), bytes.data(), bytes.size());
    file_ = folder_.write("random.slmap", text).string();
    reader_ = *MapReader::open(file_, "");
    reader_ = *MapReader::open(file_, reader_->info().localizer);
  }

  std::unique_ptr<ObservationNode> node(std::vector<rclcpp::Parameter> further = {}) {
    std::vector<rclcpp::Parameter> parameters = {
        {"map_file", file_},
        {"localizer", std::string(reader_->info().localizer)},
        {"sensor_in_base_m", std::vector<double>{1.0, 0.5, 2.0}},
        {"crop_box_node", kCropBox},
        {"downsample_node", kDownsample}};
    parameters.insert(parameters.begin(), further.begin(), further.end());  // the first one counts
    return std::make_unique<ObservationNode>(rclcpp::NodeOptions().parameter_overrides(parameters));
  }

  void drive_to(const std::array<double, 3>& sensor_world_m) {
    const auto pose = std::make_shared<geometry_msgs::msg::PoseStamped>();
    const std::array<double, 3>& taken_m = reader_->info().export_origin_world_m;
    // Turned by 90 degrees, the sensor at (1, 0.5, 2) of the vehicle is at (-0.5, 1, 2).
    pose->pose.position.x = sensor_world_m[0] - taken_m[0] + 0.5;
    pose->pose.position.y = sensor_world_m[1] - taken_m[1] - 1.0;
    pose->pose.position.z = sensor_world_m[2] - taken_m[2] - 2.0;
    pose->pose.orientation.z = std::sqrt(0.5);
    pose->pose.orientation.w = std::sqrt(0.5);
    rclcpp::recorded().subscribed.at("~/input/pose")(pose);
  }
  [[nodiscard]] std::array<double, 3> site_m(std::size_t i) const {
    const Eigen::Vector3d p_m = map_.sites.sites[i].p_map_m + map_.sites.frame.origin_world_m +
                                Eigen::Vector3d(0.1, 0.2, 0);
    return {p_m.x(), p_m.y(), p_m.z()};
  }
  template <class T>
  [[nodiscard]] static T last(const std::string& topic) {
    return *std::static_pointer_cast<T>(rclcpp::recorded().published.at(topic).back());
  }
  [[nodiscard]] static std::map<std::string, rclcpp::ParameterValue> last_set(
      const std::string& node) {
    std::map<std::string, rclcpp::ParameterValue> values;
    for (const rclcpp::Parameter& parameter : rclcpp::recorded().set_parameters.at(node).back()) {
      values.emplace(parameter.get_name(), parameter.value());
    }
    return values;
  }

  sightline::ScratchFolder folder_;
  CompiledMap map_;
  std::string file_;
  std::optional<MapReader> reader_;
};

TEST_F(Ros2Node, PublishesAndSetsWhatTheReaderAnswersAtTheSensor) {
  for (const bool takes_looks : {false, true}) {
    const auto asked = node({{"takes_looks", takes_looks}});
    for (std::size_t i = 0; i < 60; ++i) {
      rclcpp::recorded().now_s += 10;
      drive_to(site_m(i));
      const RangeAnswer range = *reader_->observation_range(site_m(i), 0.10);
      const LookAnswer look = *reader_->look(site_m(i), 0.10);
      const double range_m = takes_looks ? look.look.range_m : range.range_m;
      EXPECT_EQ(last<std_msgs::msg::Float64>("~/output/range_m").data, range_m);
      EXPECT_EQ(last<std_msgs::msg::Float64>("~/output/probability").data,
                takes_looks ? look.probability : range.probability);
      const std::uint32_t flags = takes_looks ? look.flags : range.flags;
      const bool is_unmet = (flags & sightline::kAnswerUnmet) != 0;
      const auto diagnostics = last<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics");
      EXPECT_EQ(diagnostics.status.at(0).level, is_unmet ? 1 : 0) << diagnostics.status[0].message;
      // Where nothing is good enough: as far as the map looks anywhere.
      const double box_m = is_unmet ? 50.0 : std::max(12.0, range_m);
      const auto box = last_set(kCropBox);
      EXPECT_EQ(std::get<double>(box.at("max_x")), 1.0 + box_m);
      EXPECT_EQ(std::get<double>(box.at("min_x")), 1.0 - box_m);
      EXPECT_EQ(std::get<double>(box.at("max_y")), 0.5 + box_m);
      EXPECT_EQ(box.size(), 8U) << "Autoware's filter takes all of them or none";
      const std::int64_t points =
          takes_looks && !is_unmet ? std::max<std::int64_t>(200, look.look.point_count) : 1500;
      EXPECT_EQ(std::get<std::int64_t>(last_set(kDownsample).at("sample_num")), points);
    }
  }
}

TEST_F(Ros2Node, WidensAtOnceAndNarrowsWhenThatLasts) {
  const auto asked = node();
  std::size_t wide = 0;
  std::size_t narrow = 0;
  for (std::size_t i = 0; i < 60; ++i) {
    const RangeAnswer range = *reader_->observation_range(site_m(i), 0.10);
    if (range.range_m == 20.0 && !(range.flags & sightline::kAnswerUnmet)) wide = i;
    if (range.range_m == 10.0 && !(range.flags & sightline::kAnswerUnmet)) narrow = i;
  }
  const auto box_m = [] { return std::get<double>(last_set(kCropBox).at("max_x")) - 1.0; };
  drive_to(site_m(narrow));
  EXPECT_EQ(box_m(), 12.0);
  drive_to(site_m(wide));
  EXPECT_EQ(box_m(), 20.0);
  drive_to(site_m(narrow));
  EXPECT_EQ(box_m(), 20.0);
  rclcpp::recorded().now_s += 1;
  drive_to(site_m(narrow));
  EXPECT_EQ(box_m(), 12.0);
  const std::size_t count = rclcpp::recorded().set_parameters[kCropBox].size();
  drive_to(site_m(narrow));
  EXPECT_EQ(rclcpp::recorded().set_parameters[kCropBox].size(), count) << "nothing is new";
}

TEST_F(Ros2Node, FiltersThatAreNotThereYetAreSetLater) {
  rclcpp::recorded().is_ready[kCropBox] = false;
  const auto asked = node();
  drive_to(site_m(0));
  EXPECT_TRUE(rclcpp::recorded().set_parameters.empty());
  rclcpp::recorded().is_ready[kCropBox] = true;
  drive_to(site_m(0));
  EXPECT_EQ(rclcpp::recorded().set_parameters.size(), 2U);
}

TEST_F(Ros2Node, FarFromTheMapItLooksAsFarAsItGoesAndWarns) {
  const auto asked = node({{"takes_looks", true}});
  drive_to({0.0, 0.0, 0.0});
  EXPECT_EQ(std::get<double>(last_set(kCropBox).at("max_x")), 51.0);
  EXPECT_EQ(std::get<std::int64_t>(last_set(kDownsample).at("sample_num")), 1500);
  EXPECT_EQ(last<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics").status[0].level, 1);
}

TEST_F(Ros2Node, APoseThatIsNoneIsAnErrorAndTheBoxIsWide) {
  const auto asked = node();
  drive_to({std::nan(""), 0.0, 0.0});
  EXPECT_EQ(last<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics").status[0].level, 2);
  EXPECT_EQ(std::get<double>(last_set(kCropBox).at("max_x")), 51.0);
}

TEST_F(Ros2Node, AnotherLocalizersProbabilityIsUnknown) {
  const auto asked = node({{"localizer", std::string("lost-ndt")}});
  drive_to(site_m(0));
  EXPECT_TRUE(std::isnan(last<std_msgs::msg::Float64>("~/output/probability").data));
  EXPECT_EQ(last<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics").status[0].level, 1);
}

TEST_F(Ros2Node, DoesNotBeginWithoutItsMap) {
  EXPECT_THROW(node({{"map_file", std::string("/no/such.slmap")}}), std::runtime_error);
  EXPECT_THROW(node({{"sensor_in_base_m", std::vector<double>{1.0}}}), std::runtime_error);
}

}  // namespace
}  // namespace sightline_ros2
