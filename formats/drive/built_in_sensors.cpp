// The sensors that sensor_profile() knows by name.

#include <string>
#include <utility>

#include "formats/drive/sensor_profile.h"

namespace sightline {
namespace {

// Elevations from `first_deg` to `last_deg`, both included, evenly.
std::vector<double> even_beams(int count, double first_deg, double last_deg) {
  std::vector<double> beams;
  for (int i = 0; i < count; ++i) {
    beams.push_back(first_deg + (last_deg - first_deg) * i / (count - 1));
  }
  return beams;
}

SensorProfile named(const std::string& name, std::vector<double> beams_deg, double azimuth_step_deg,
                    double min_range_m, double max_range_m) {
  SensorProfile profile;
  profile.name = name;
  profile.beam_elevations_deg = std::move(beams_deg);
  profile.azimuth_step_deg = azimuth_step_deg;
  profile.min_range_m = min_range_m;
  profile.max_range_m = max_range_m;
  return profile;
}

SensorProfile generic(int rings) {
  return named(concat("generic-", rings), even_beams(rings, -15.0, 15.0), 0.2, 1.0, 100.0);
}

std::vector<double> joined(std::vector<double> beams, const std::vector<double>& upper) {
  beams.insert(beams.end(), upper.begin(), upper.end());
  return beams;
}

// Velodyne HDL-64E S2 manual: the lower bank of 32 beams 1/2 degree apart from -24.33 to -8.83, the
// upper 1/3 degree apart from -8.33 to +2. Height above ground as KITTI mounts it.
SensorProfile hdl_64e() {
  const std::vector<double> beams =
      joined(even_beams(32, -24.33, -8.83), even_beams(32, -8.33, 2.0));
  SensorProfile profile = named("hdl-64e", beams, 0.1728, 1.0, 120.0);
  profile.height_m = 1.73;
  return profile;
}

// Velodyne VLP-32C User Manual: 32 beams, closest between -4 and +1.67 degrees.
std::vector<double> vlp_32c_beams() {
  return {-25.0, -15.639, -11.31, -8.843, -7.254, -6.148, -5.333, -4.667, -4.0,   -3.667, -3.333,
          -3.0,  -2.667,  -2.333, -2.0,   -1.667, -1.333, -1.0,   -0.667, -0.333, 0.0,    0.333,
          0.667, 1.0,     1.333,  1.667,  2.333,  3.333,  4.667,  7.0,    10.333, 15.0};
}

// Velodyne VLS-128 (Alpha Prime) User Manual: 0.11 degrees apart from -6.5 to +4.83, wider to -25
// and +15.
std::vector<double> vls_128_beams() {
  std::vector<double> beams = {-25.0,  -19.582, -16.042, -13.565, -11.742, -10.346,
                               -9.244, -8.352,  -7.65,   -7.15,   -6.85,   -6.65};
  for (int i = -650; i <= 483; i += 11) beams.push_back(i / 100.0);
  return joined(beams, {4.98, 5.18, 5.43, 5.73, 6.08, 6.48, 6.98, 7.58, 8.43, 9.7, 11.75, 15.0});
}

// Hesai Pandar64 User Manual: 1/6 degree apart from -6 to +2, wider to -25 and +15.
std::vector<double> pandar64_beams() {
  std::vector<double> beams = {-25.0, -19.0, -14.0, -13.0, -12.0, -11.0, -10.0, -9.0, -8.0, -7.0};
  for (int i = -36; i <= 12; ++i) beams.push_back(i / 6.0);
  return joined(beams, {3.0, 5.0, 8.0, 11.0, 15.0});
}

// Hesai Pandar128 as it is designed (its maker's driver without an angle correction): 1/8 degree
// apart from -6.1 to +2, 1/2 or less beyond.
std::vector<double> pandar128_beams() {
  return {-25.016, -24.123, -23.68,  -23.219, -22.77,  -22.304, -21.85,  -21.379, -20.92,  -20.445,
          -19.981, -19.501, -19.031, -18.548, -18.073, -17.59,  -17.108, -16.62,  -16.135, -15.643,
          -15.154, -14.658, -14.166, -13.668, -13.173, -12.672, -12.174, -11.67,  -11.17,  -10.664,
          -10.16,  -9.652,  -9.149,  -8.64,   -8.135,  -7.624,  -7.118,  -6.607,  -6.099,  -5.968,
          -5.843,  -5.717,  -5.589,  -5.463,  -5.336,  -5.209,  -5.081,  -4.951,  -4.824,  -4.698,
          -4.571,  -4.444,  -4.318,  -4.19,   -4.062,  -3.933,  -3.806,  -3.68,   -3.552,  -3.425,
          -3.299,  -3.172,  -3.044,  -2.916,  -2.789,  -2.662,  -2.535,  -2.409,  -2.282,  -2.155,
          -2.027,  -1.901,  -1.773,  -1.646,  -1.519,  -1.393,  -1.266,  -1.141,  -1.012,  -0.887,
          -0.76,   -0.632,  -0.506,  -0.38,   -0.254,  -0.129,  0.0,     0.124,   0.251,   0.379,
          0.505,   0.63,    0.756,   0.88,    1.009,   1.13,    1.258,   1.386,   1.511,   1.637,
          1.761,   1.885,   2.014,   2.512,   3.014,   3.509,   4.009,   4.501,   4.997,   5.487,
          5.98,    6.467,   6.954,   7.437,   7.921,   8.401,   8.88,    9.355,   9.83,    10.301,
          10.771,  11.237,  11.702,  12.163,  12.624,  13.08,   13.535,  14.436};
}

// RoboSense RS-Helios-5515: 2 degrees apart or less from -10 to +15, 3 from there to -55.
std::vector<double> rs_helios_5515_beams() {
  std::vector<double> beams;
  for (int i = -55; i <= -10; i += 3) beams.push_back(i);
  return joined(beams, {-8.0, -6.67, -5.33, -4.0, -2.67, -1.33, 0.0, 1.33, 2.67, 4.0, 5.5, 7.0, 9.0,
                        11.0, 13.0, 15.0});
}

// RoboSense RS-Ruby, 128 beams: 0.1 degrees apart from -6.5 to +3.81, wider to -25 and +15.
// Calibrations of single units differ from it by 0.03 degrees, the lowest by 0.1.
std::vector<double> rs_ruby_128_beams() {
  std::vector<double> beams = {-25.0,  -19.582, -16.042, -13.565, -11.742, -10.346, -9.244,
                               -8.352, -7.65,   -7.15,   -6.85,   -6.65,   -6.5};
  for (int i = -639; i <= 381; i += 10) beams.push_back(i / 100.0);
  return joined(beams, {3.96, 4.16, 4.41, 4.71, 5.06, 5.46, 5.96, 6.56, 7.41, 9.0, 11.5, 15.0});
}

// Livox Avia User Manual: 70.4 degrees wide and 77.2 high, 24,000 points a tenth of a second on a
// rosette that lies elsewhere each time. Here as many spread evenly, on 150 rings of 160 points:
// what it sees of a place within a second, not where one of its points lies.
SensorProfile livox_avia() {
  SensorProfile profile = named("livox-avia", even_beams(150, -38.6, 38.6), 0.44, 1.0, 190.0);
  profile.azimuth_view_deg = 70.4;
  return profile;
}

// Ouster OS0, OS1 and OS2 data sheets (rev 06 and 7): beams spread evenly over 90, 45 and 22.5
// degrees; 1024 columns a turn. The real angles of a unit lie in its metadata.json, which `sensor`
// takes too.
void add_ousters(std::vector<SensorProfile>& all) {
  struct Series {
    const char* name;
    double half_deg, min_range_m, max_range_m;
  };
  for (const Series& series : {Series{"os0", 45.0, 0.3, 100.0}, Series{"os1", 22.5, 0.3, 120.0},
                               Series{"os2", 11.25, 1.0, 240.0}}) {
    for (const int rings : {32, 64, 128}) {
      std::string name = concat(series.name, "-", rings);
      if (name == "os1-64") name += "-gen2";  // the first generation has that name
      all.push_back(named(name, even_beams(rings, -series.half_deg, series.half_deg),
                          360.0 / 1024.0, series.min_range_m, series.max_range_m));
    }
  }
}

// Of profiles with the same beams the last is recognized (guess_sensor).
std::vector<SensorProfile> built_in_sensors() {
  std::vector<SensorProfile> all = {generic(16), generic(32), generic(64), generic(128)};
  add_ousters(all);
  // Velodyne Puck Hi-Res data sheet: 16 beams 4/3 degrees apart.
  all.push_back(named("vlp-16-hires", even_beams(16, -10.0, 10.0), 0.2, 1.0, 100.0));
  all.push_back(named("vlp-32c", vlp_32c_beams(), 0.2, 1.0, 200.0));
  all.push_back(named("rs-helios-5515", rs_helios_5515_beams(), 0.2, 0.2, 150.0));
  all.push_back(named("rs-ruby-128", rs_ruby_128_beams(), 0.2, 0.4, 250.0));
  all.push_back(named("vls-128", vls_128_beams(), 0.2, 1.0, 245.0));
  // Hesai PandarXT User Manual.
  all.push_back(named("xt16", even_beams(16, -15.0, 15.0), 0.18, 0.3, 120.0));
  all.push_back(named("xt32", even_beams(32, -16.0, 15.0), 0.18, 0.3, 120.0));
  all.push_back(named("pandar64", pandar64_beams(), 0.2, 0.3, 200.0));
  all.push_back(named("pandar128", pandar128_beams(), 0.2, 0.3, 200.0));
  // Livox Mid-360 User Manual: -7 to +52 degrees, 20,000 points a tenth of a second that lie
  // elsewhere each time. As many spread evenly, on rings as far apart as columns.
  all.push_back(named("livox-mid-360", even_beams(100, -7.0, 52.0), 1.8, 0.3, 70.0));
  all.push_back(livox_avia());
  // Velodyne VLP-16 manual: 16 beams 2 degrees apart; 0.2 degrees of azimuth at 10 Hz.
  all.push_back(named("vlp-16", even_beams(16, -15.0, 15.0), 0.2, 1.0, 100.0));
  // Velodyne HDL-32E manual: 32 beams 4/3 degrees apart, +10.67 to -30.67.
  all.push_back(named("hdl-32e", even_beams(32, -30.67, 10.67), 0.16, 1.0, 100.0));
  all.push_back(hdl_64e());
  // Ouster OS1-64 (first generation): 64 beams over 33.2 degrees; 1024 columns a turn.
  all.push_back(named("os1-64", even_beams(64, -16.6, 16.6), 360.0 / 1024.0, 1.0, 120.0));
  return all;
}

// Small letters and digits alone: "VLP-16" and "vlp_16" are "vlp16".
std::string letters_of(std::string_view name) {
  std::string letters;
  for (const char c : name) {
    const bool is_upper = c >= 'A' && c <= 'Z';
    const bool is_kept = is_upper || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
    if (is_kept) letters += static_cast<char>(is_upper ? c - 'A' + 'a' : c);
  }
  return letters;
}

// "velodyne" of "Velodyne" and of "vlp-16"; empty where neither the name nor a profile has it.
std::string maker_of(std::string_view name) {
  constexpr std::pair<std::string_view, std::string_view> kBeginnings[] = {
      {"velodyne", "velodyne"}, {"vlp", "velodyne"},  {"hdl", "velodyne"},
      {"vls", "velodyne"},      {"ouster", "ouster"}, {"os0", "ouster"},
      {"os1", "ouster"},        {"os2", "ouster"},    {"hesai", "hesai"},
      {"xt", "hesai"},          {"pandar", "hesai"},  {"robosense", "robosense"},
      {"rs", "robosense"},      {"livox", "livox"}};
  const std::string letters = letters_of(name);
  for (const auto& [beginning, maker] : kBeginnings) {
    if (letters.starts_with(beginning)) return std::string(maker);
  }
  return "";
}

// "VLP16" and "Velodyne VLP-16" mean vlp-16, "HDL64" hdl-64e.
bool is_meant(std::string_view profile, std::string_view name) {
  constexpr std::size_t kEnough = 4;
  const std::string wanted = letters_of(name);
  const std::string known = letters_of(profile);
  return wanted.ends_with(known) || (wanted.size() >= kEnough && known.starts_with(wanted));
}

}  // namespace

std::vector<std::string> sensor_profile_names() {
  std::vector<std::string> names;
  for (const SensorProfile& profile : built_in_sensors()) names.push_back(profile.name);
  return names;
}

Result<SensorProfile> sensor_profile(std::string_view name) {
  std::string known;
  std::string meant;
  const std::string maker = maker_of(name);
  for (SensorProfile& profile : built_in_sensors()) {
    if (profile.name == name) return std::move(profile);
    if (maker.empty() || maker == maker_of(profile.name)) known += " " + profile.name;
    if (is_meant(profile.name, name)) meant = concat("; did you mean ", profile.name, "?");
  }
  if (!maker.empty() && (meant.empty() || maker == letters_of(name))) {
    return Error{ErrorCode::kUnknownName,
                 concat("unknown sensor profile '", name, "'; those of ", maker, " are", known,
                        "; `sightline init` recognizes the sensor of a recording")};
  }
  return Error{ErrorCode::kUnknownName,
               concat("unknown sensor profile '", name, "', expected one of", known,
                      ", or a file (.yaml, .csv, .json) with its beams", meant)};
}

}  // namespace sightline
