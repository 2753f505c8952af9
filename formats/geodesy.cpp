#include "formats/geodesy.h"

#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>

namespace sightline {
namespace {

// WGS 84.
constexpr double kSemiMajorM = 6378137.0;
constexpr double kFlattening = 1.0 / 298.257223563;

// UTM.
constexpr double kScale = 0.9996;
constexpr double kFalseEastingM = 500000.0;
constexpr double kFalseNorthingSouthM = 10000000.0;

// tan(latitude) from that of the conformal latitude: Newton's method on Karney's equations 7 to 9.
double tan_latitude(double tan_conformal) {
  const double eccentricity = std::sqrt(kFlattening * (2.0 - kFlattening));
  double tau = tan_conformal;
  for (int step = 0; step < 5; ++step) {
    const double sine = tau / std::hypot(1.0, tau);
    const double sigma = std::sinh(eccentricity * std::atanh(eccentricity * sine));
    const double guess = tau * std::hypot(1.0, sigma) - sigma * std::hypot(1.0, tau);
    const double squared = 1.0 - eccentricity * eccentricity;
    tau += (tan_conformal - guess) / std::hypot(1.0, guess) * (1.0 + squared * tau * tau) /
           (squared * std::hypot(1.0, tau));
  }
  return tau;
}

}  // namespace

Result<UtmZone> parse_utm_zone(std::string_view text) {
  UtmZone zone;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), zone.number);
  const std::string_view rest(end, static_cast<std::size_t>(text.data() + text.size() - end));
  const int letter = rest.size() == 1 ? std::toupper(static_cast<unsigned char>(rest[0])) : 0;
  if (failure != std::errc() || zone.number < 1 || zone.number > 60 ||
      (letter != 'N' && letter != 'S')) {
    return Error{ErrorCode::kBadArgument,
                 "found UTM zone \"" + std::string(text) + "\", expected 1 to 60 and N or S", "",
                 ""};
  }
  zone.is_south = letter == 'S';
  return zone;
}

LongitudeLatitude from_utm(const UtmZone& zone, double easting_m, double northing_m) {
  const double n = kFlattening / (2.0 - kFlattening);
  const double n2 = n * n;
  // Karney's b_1 (equation 14) and beta (equation 36).
  const double rectifying_m = kSemiMajorM / (1.0 + n) * (1.0 + n2 / 4.0 + n2 * n2 / 64.0);
  const std::array<double, 4> beta = {
      n / 2.0 - 2.0 / 3.0 * n2 + 37.0 / 96.0 * n2 * n - 1.0 / 360.0 * n2 * n2,
      n2 / 48.0 + n2 * n / 15.0 - 437.0 / 1440.0 * n2 * n2,
      17.0 / 480.0 * n2 * n - 37.0 / 840.0 * n2 * n2, 4397.0 / 161280.0 * n2 * n2};
  const double y_m = northing_m - (zone.is_south ? kFalseNorthingSouthM : 0.0);
  const std::complex<double> zeta(y_m / (kScale * rectifying_m),
                                  (easting_m - kFalseEastingM) / (kScale * rectifying_m));
  std::complex<double> conformal = zeta;
  for (std::size_t j = 0; j < beta.size(); ++j) {
    conformal -= beta[j] * std::sin(2.0 * static_cast<double>(j + 1) * zeta);
  }
  const double xi = conformal.real();
  const double eta = conformal.imag();
  const double tan_conformal = std::sin(xi) / std::hypot(std::sinh(eta), std::cos(xi));
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  const double middle_deg = 6.0 * zone.number - 183.0;
  const double longitude_deg = middle_deg + std::atan2(std::sinh(eta), std::cos(xi)) * kDegrees;
  return {std::remainder(longitude_deg, 360.0),  // a zone's edge may lie beyond the date line
          std::atan(tan_latitude(tan_conformal)) * kDegrees};
}

}  // namespace sightline
