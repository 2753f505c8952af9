#include "observation_node.h"

#include <limits>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

namespace sightline_ros2 {
namespace {

using diagnostic_msgs::msg::DiagnosticStatus;
using sightline::LookAnswer;
using sightline::MapReader;
using sightline::RangeAnswer;
using sightline::Result;

std::string number(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

// "20 m, 650 returns, 40 points by normals, settles"
std::string in_words(const sightline::MapLook& look) {
  std::string text = number(look.range_m) + " m, ";
  text += look.return_count == 0 ? "every return" : std::to_string(look.return_count) + " returns";
  if (look.even_beyond_m > 0.0)
    text += ", evenly spaced beyond " + number(look.even_beyond_m) + " m";
  if (look.point_count > 0) text += ", " + std::to_string(look.point_count) + " points";
  if (look.is_by_normals) text += " by normals";
  if (look.settles) text += ", settles";
  return text;
}

std::string flags_in_words(std::uint32_t flags) {
  const std::pair<std::uint32_t, const char*> names[] = {
      {sightline::kAnswerUnmet, "no range or look is good enough here"},
      {sightline::kAnswerExtrapolated, "unlike the places that the model was trained on"},
      {sightline::kAnswerFar, "no site of the map is in reach"},
      {sightline::kAnswerTighterLimit, "the limit is tighter than every limit of the map"},
      {sightline::kAnswerUnknownLocalizer, "the map is of another localizer"},
      {sightline::kAnswerNotVisible, "neither look nor range is visible now"},
      {sightline::kAnswerSimulated, "simulated: no drive was recorded here"}};
  std::string text;
  for (const auto& [flag, name] : names) {
    if ((flags & flag) != 0) text += (text.empty() ? "" : "; ") + std::string(name);
  }
  return text.empty() ? "within the limit" : text;
}

// Every answer as a look: of a map asked for ranges alone, all returns within the range.
Result<LookAnswer> ask(const MapReader& map, const std::array<double, 3>& p_world_m, double limit_m,
                       double visible_m, bool takes_looks) {
  if (takes_looks) return map.look(p_world_m, limit_m, visible_m);
  const Result<RangeAnswer> range = map.observation_range(p_world_m, limit_m);
  if (!range) return range.error();
  LookAnswer answer;
  answer.look.range_m = range->range_m;
  answer.probability = range->probability;
  answer.mean_error_m = range->mean_error_m;
  answer.distance_m = range->distance_m;
  answer.flags = range->flags;
  answer.site = range->site;
  if (range->range_m > visible_m) answer.flags |= sightline::kAnswerNotVisible;
  return answer;
}

bool is_wider(const FilterSettings& a, const FilterSettings& b) {
  return a.max_x_m > b.max_x_m || a.sample_num > b.sample_num;
}

}  // namespace

ObservationNode::ObservationNode(const rclcpp::NodeOptions& options)
    : Node("observation_node", options), wanted_at_(0, 0, RCL_ROS_TIME) {
  const auto map_file = declare_parameter<std::string>("map_file");
  // The name under which the map holds errors of the vehicle's localizer; anything else: unknown.
  const auto localizer = declare_parameter<std::string>("localizer", "pcl-ndt");
  limit_m_ = declare_parameter<double>("limit_m", 0.10);
  visible_m_ = declare_parameter<double>("visible_m", 0.0);
  if (!(visible_m_ > 0.0)) visible_m_ = std::numeric_limits<double>::infinity();
  takes_looks_ = declare_parameter<bool>("takes_looks", false);
  Result<MapReader> map = MapReader::open(map_file, localizer);
  if (!map) throw std::runtime_error(to_string(map.error()));
  map_ = std::move(*map);
  if (!map_->info().is_for_caller) {
    RCLCPP_WARN(get_logger(),
                "the map holds errors of the localizer '%s', not of '%s': every answer is the "
                "longest range, its probability unknown",
                std::string(map_->info().localizer).c_str(), localizer.c_str());
  }
  declare_filters();
  range_publisher_ = create_publisher<std_msgs::msg::Float64>("~/output/range_m", 10);
  probability_publisher_ = create_publisher<std_msgs::msg::Float64>("~/output/probability", 10);
  look_publisher_ = create_publisher<std_msgs::msg::String>("~/output/look", 10);
  diagnostics_publisher_ =
      create_publisher<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics", 10);
  pose_subscription_ = create_subscription<geometry_msgs::msg::PoseStamped>(
      "~/input/pose", rclcpp::QoS(1),
      [this](const geometry_msgs::msg::PoseStamped::ConstSharedPtr pose) { answer(*pose); });
}

void ObservationNode::declare_filters() {
  const auto sensor_m =
      declare_parameter<std::vector<double>>("sensor_in_base_m", std::vector<double>{0, 0, 0});
  if (sensor_m.size() != 3) throw std::runtime_error("sensor_in_base_m takes three numbers");
  for (std::size_t i = 0; i < 3; ++i) filters_.sensor_in_base_m[i] = sensor_m[i];
  filters_.least_range_m = declare_parameter<double>("least_range_m", filters_.least_range_m);
  filters_.min_z_m = declare_parameter<double>("min_z_m", filters_.min_z_m);
  filters_.max_z_m = declare_parameter<double>("max_z_m", filters_.max_z_m);
  filters_.usual_sample_num =
      declare_parameter<std::int64_t>("usual_sample_num", filters_.usual_sample_num);
  filters_.least_sample_num =
      declare_parameter<std::int64_t>("least_sample_num", filters_.least_sample_num);
  hold_s_ = declare_parameter<double>("hold_s", hold_s_);
  has_ray_intersection_ = declare_parameter<bool>("crop_box_has_ray_intersection", true);
  const auto crop_box = declare_parameter<std::string>("crop_box_node", "");
  const auto downsample = declare_parameter<std::string>("downsample_node", "");
  if (!crop_box.empty()) {
    crop_box_ = std::make_shared<rclcpp::AsyncParametersClient>(this, crop_box);
  }
  if (!downsample.empty()) {
    downsample_ = std::make_shared<rclcpp::AsyncParametersClient>(this, downsample);
  }
}

void ObservationNode::answer(const geometry_msgs::msg::PoseStamped& pose) {
  const auto& position = pose.pose.position;
  const auto& q = pose.pose.orientation;
  // The map is asked where its sensor is, in the world of its recording; a point cloud map that was
  // exported from it leaves out whole 100 km of that.
  std::array<double, 3> p_world_m = transformed({position.x, position.y, position.z},
                                                {q.x, q.y, q.z, q.w}, filters_.sensor_in_base_m);
  for (std::size_t i = 0; i < 3; ++i) p_world_m[i] += map_->info().export_origin_world_m[i];
  const Result<LookAnswer> look = ask(*map_, p_world_m, limit_m_, visible_m_, takes_looks_);
  const double longest_m = map_->info().ranges_m.back();
  if (!look) {
    LookAnswer longest;
    longest.look.range_m = longest_m;
    longest.flags = sightline::kAnswerFar;
    publish_diagnostics(pose, DiagnosticStatus::ERROR, to_string(look.error()), longest);
    set_filters(settings_for(longest, longest_m, filters_));
    return;
  }
  publish(pose, *look);
  set_filters(settings_for(*look, longest_m, filters_));
}

void ObservationNode::publish(const geometry_msgs::msg::PoseStamped& pose, const LookAnswer& look) {
  std_msgs::msg::Float64 range;
  range.data = look.look.range_m;
  range_publisher_->publish(range);
  std_msgs::msg::Float64 probability;
  probability.data = look.probability;
  probability_publisher_->publish(probability);
  std_msgs::msg::String words;
  words.data = in_words(look.look);
  look_publisher_->publish(words);
  publish_diagnostics(pose, is_trusted(look.flags) ? DiagnosticStatus::OK : DiagnosticStatus::WARN,
                      flags_in_words(look.flags), look);
}

void ObservationNode::publish_diagnostics(const geometry_msgs::msg::PoseStamped& pose,
                                          unsigned char level, const std::string& message,
                                          const LookAnswer& look) {
  DiagnosticStatus status;
  status.level = level;
  status.name = std::string(get_name()) + ": observation range";
  status.hardware_id = std::string(map_->info().map_id);
  status.message = message;
  const auto add = [&](const char* key, const std::string& value) {
    diagnostic_msgs::msg::KeyValue pair;
    pair.key = key;
    pair.value = value;
    status.values.push_back(pair);
  };
  add("limit_m", number(limit_m_));
  add("range_m", number(look.look.range_m));
  add("look", in_words(look.look));
  add("probability", number(look.probability));
  add("mean_error_m", number(look.mean_error_m));
  add("distance_to_site_m", number(look.distance_m));
  add("flags", std::to_string(look.flags));
  add("map_version", std::string(map_->info().version));
  diagnostic_msgs::msg::DiagnosticArray all;
  all.header = pose.header;
  all.status.push_back(status);
  diagnostics_publisher_->publish(all);
}

// Wider at once, narrower when it was wanted for a while: between two sites answers may alternate.
void ObservationNode::set_filters(const FilterSettings& settings) {
  const rclcpp::Time now = this->now();
  const bool holds = wanted_ && settings != *wanted_ && !is_wider(settings, *wanted_) &&
                     (now - wanted_at_).seconds() < hold_s_;
  if (holds) return;
  wanted_at_ = now;
  if (wanted_ && settings == *wanted_) return;
  const bool is_ready = (!crop_box_ || crop_box_->service_is_ready()) &&
                        (!downsample_ || downsample_->service_is_ready());
  if (!is_ready) return;  // tried again at the next pose
  wanted_ = settings;
  set_crop_box(settings);
  if (!downsample_) return;
  downsample_->set_parameters_atomically({rclcpp::Parameter("sample_num", settings.sample_num)});
}

// All in one request: Autoware's filter ignores a box of which one bound is missing.
void ObservationNode::set_crop_box(const FilterSettings& settings) {
  if (!crop_box_) return;
  std::vector<rclcpp::Parameter> parameters = {
      rclcpp::Parameter("min_x", settings.min_x_m), rclcpp::Parameter("max_x", settings.max_x_m),
      rclcpp::Parameter("min_y", settings.min_y_m), rclcpp::Parameter("max_y", settings.max_y_m),
      rclcpp::Parameter("min_z", settings.min_z_m), rclcpp::Parameter("max_z", settings.max_z_m),
      rclcpp::Parameter("negative", false)};
  if (has_ray_intersection_) parameters.emplace_back("use_ray_intersection", false);
  crop_box_->set_parameters_atomically(parameters);
}

}  // namespace sightline_ros2
