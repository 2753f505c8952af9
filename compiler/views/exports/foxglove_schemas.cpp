#include "compiler/views/exports/foxglove_schemas.h"

#include <initializer_list>
#include <string>
#include <utility>

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

Json number() { return {{"type", "number"}}; }
Json count() { return {{"type", "integer"}, {"minimum", 0}}; }
Json text() { return {{"type", "string"}}; }
Json boolean() { return {{"type", "boolean"}}; }
Json list_of(const Json& items) { return {{"type", "array"}, {"items", items}}; }
// Arrays that are always empty here.
Json no_list() { return {{"type", "array"}, {"items", {{"type", "object"}}}}; }

// All members are required.
Json object(const std::string& title, std::initializer_list<std::pair<const char*, Json>> members) {
  Json properties = Json::object();
  Json required = Json::array();
  for (const auto& [name, schema] : members) {
    properties[name] = schema;
    required.push_back(name);
  }
  return {{"title", title},
          {"type", "object"},
          {"properties", std::move(properties)},
          {"required", std::move(required)}};
}

Json one_of(const std::string& title, std::initializer_list<std::pair<const char*, int>> values) {
  Json choices = Json::array();
  for (const auto& [name, value] : values) choices.push_back({{"title", name}, {"const", value}});
  return {{"title", title}, {"oneOf", std::move(choices)}};
}

Json nanoseconds() { return {{"type", "integer"}, {"minimum", 0}, {"maximum", 999999999}}; }
Json time() { return object("time", {{"sec", count()}, {"nsec", nanoseconds()}}); }
Json duration() {
  return object("duration", {{"sec", {{"type", "integer"}}}, {"nsec", nanoseconds()}});
}

Json vector(const std::string& title) {
  return object(title, {{"x", number()}, {"y", number()}, {"z", number()}});
}
Json quaternion() {
  return object("foxglove.Quaternion",
                {{"x", number()}, {"y", number()}, {"z", number()}, {"w", number()}});
}
Json pose() {
  return object("foxglove.Pose",
                {{"position", vector("foxglove.Vector3")}, {"orientation", quaternion()}});
}
Json color() {
  return object("foxglove.Color",
                {{"r", number()}, {"g", number()}, {"b", number()}, {"a", number()}});
}
Json pair() { return object("foxglove.KeyValuePair", {{"key", text()}, {"value", text()}}); }

Json sphere() {
  return object("foxglove.SpherePrimitive",
                {{"pose", pose()}, {"size", vector("foxglove.Vector3")}, {"color", color()}});
}

Json line() {
  const Json type =
      one_of("foxglove.LineType", {{"LINE_STRIP", 0}, {"LINE_LOOP", 1}, {"LINE_LIST", 2}});
  return object("foxglove.LinePrimitive", {{"type", type},
                                           {"pose", pose()},
                                           {"thickness", number()},
                                           {"scale_invariant", boolean()},
                                           {"points", list_of(vector("foxglove.Point3"))},
                                           {"color", color()},
                                           {"colors", list_of(color())},
                                           {"indices", list_of(count())}});
}

Json scene_entity() {
  return object("foxglove.SceneEntity", {{"timestamp", time()},
                                         {"frame_id", text()},
                                         {"id", text()},
                                         {"lifetime", duration()},
                                         {"frame_locked", boolean()},
                                         {"metadata", list_of(pair())},
                                         {"arrows", no_list()},
                                         {"cubes", no_list()},
                                         {"spheres", list_of(sphere())},
                                         {"cylinders", no_list()},
                                         {"lines", list_of(line())},
                                         {"triangles", no_list()},
                                         {"texts", no_list()},
                                         {"models", no_list()}});
}

Json packed_field() {
  const Json type = one_of("foxglove.NumericType", {{"UNKNOWN", 0},
                                                    {"UINT8", 1},
                                                    {"INT8", 2},
                                                    {"UINT16", 3},
                                                    {"INT16", 4},
                                                    {"UINT32", 5},
                                                    {"INT32", 6},
                                                    {"FLOAT32", 7},
                                                    {"FLOAT64", 8}});
  return object("foxglove.PackedElementField",
                {{"name", text()}, {"offset", count()}, {"type", type}});
}

}  // namespace

Json foxglove_point_cloud_schema() {
  return object("foxglove.PointCloud",
                {{"timestamp", time()},
                 {"frame_id", text()},
                 {"pose", pose()},
                 {"point_stride", count()},
                 {"fields", list_of(packed_field())},
                 {"data", {{"type", "string"}, {"contentEncoding", "base64"}}}});
}

Json foxglove_scene_update_schema() {
  return object("foxglove.SceneUpdate",
                {{"deletions", no_list()}, {"entities", list_of(scene_entity())}});
}

Json foxglove_poses_in_frame_schema() {
  return object("foxglove.PosesInFrame",
                {{"timestamp", time()}, {"frame_id", text()}, {"poses", list_of(pose())}});
}

Json foxglove_pose_in_frame_schema() {
  return object("foxglove.PoseInFrame",
                {{"timestamp", time()}, {"frame_id", text()}, {"pose", pose()}});
}

Json foxglove_frame_transform_schema() {
  return object("foxglove.FrameTransform", {{"timestamp", time()},
                                            {"parent_frame_id", text()},
                                            {"child_frame_id", text()},
                                            {"translation", vector("foxglove.Vector3")},
                                            {"rotation", quaternion()}});
}

Json foxglove_location_fix_schema() {
  Json covariance = list_of(number());
  covariance["minItems"] = 9;
  covariance["maxItems"] = 9;
  const Json type =
      one_of("foxglove.PositionCovarianceType",
             {{"UNKNOWN", 0}, {"APPROXIMATED", 1}, {"DIAGONAL_KNOWN", 2}, {"KNOWN", 3}});
  return object("foxglove.LocationFix", {{"timestamp", time()},
                                         {"frame_id", text()},
                                         {"latitude", number()},
                                         {"longitude", number()},
                                         {"altitude", number()},
                                         {"position_covariance", std::move(covariance)},
                                         {"position_covariance_type", type}});
}

}  // namespace sightline
