#include "passes/model/forest/same_street.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "formats/grid/point_grid.h"

// Two maps of one street may have nothing in common but the street: each drive has axes of its own,
// begins and ends elsewhere, and may go the other way. So rows of factors along both routes are
// laid beside each other at every lag, forwards and backwards, as a signal is looked for in a
// recording of it (normalized cross-correlation). What all streets of a kind have in common changes
// slowly along the route; a mean over 30 m removes it.

namespace sightline {
namespace {

constexpr double kNear_m = 20.0;
constexpr double kShare = 0.2;
constexpr double kFarthestOwn_m = 1e5;
constexpr std::size_t kMostRows = 2000;  // of a longer route each is a mean over several sites
constexpr std::size_t kHop = 10;         // rows between two stretches that are compared
constexpr double kMeanWithin_m = 15.0;   // either way
constexpr std::size_t kFewestColumns = 5;

std::vector<Eigen::Vector3d> route_of(const DrivenPlace& place) {
  std::vector<Eigen::Vector3d> route_m;
  for (const Site& site : place.sites.sites) {
    route_m.push_back(place.sites.frame.origin_world_m + site.p_map_m);
  }
  return route_m;
}

double length_m(const DrivenPlace& place) {
  return static_cast<double>(place.sites.sites.size()) * place.sites.spacing_m;
}

bool is_of_the_world(const std::vector<Eigen::Vector3d>& route_m) {
  return !route_m.empty() && route_m.front().head<2>().cwiseAbs().maxCoeff() > kFarthestOwn_m;
}

// Whether more than a fifth of `a` is near `b`.
bool share_a_route(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b) {
  const PointGrid grid(b);
  const auto near = std::ranges::count_if(
      a, [&](const Eigen::Vector3d& site_m) { return grid.nearest(site_m, kNear_m).has_value(); });
  return static_cast<double>(near) > kShare * static_cast<double>(a.size());
}

// What a map looks like: neither a direction, which turns with its axes, nor an error.
bool is_appearance(const std::string& factor) {
  return !factor.ends_with("_heading") && !factor.ends_with("error") &&
         !factor.starts_with("measured_");
}

// Rows of factors along a route, each without its mean nearby.
struct Details {
  std::size_t columns = 0;
  std::size_t rows = 0;
  std::vector<double> values;   // [row][column]
  std::vector<double> squares;  // [row][column]: sum of the squares of all rows before

  [[nodiscard]] const double* row(std::size_t i) const { return &values[i * columns]; }
  // Of `count` rows from `first` on.
  [[nodiscard]] double power(std::size_t first, std::size_t count, std::size_t column) const {
    return squares[(first + count) * columns + column] - squares[first * columns + column];
  }
};

// As a share of its greatest value; the mean is over `within` rows either way.
std::vector<double> details_of(const std::vector<double>& column, std::ptrdiff_t within) {
  double greatest = 0.0;
  std::vector<double> before = {0.0};  // [row]: sum of all rows before
  for (const double value : column) {
    greatest = std::max(greatest, std::abs(value));
    before.push_back(before.back() + value);
  }
  std::vector<double> details(column.size(), 0.0);
  if (greatest == 0.0) return details;
  for (std::ptrdiff_t i = 0; i < std::ssize(column); ++i) {
    const auto first = static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, i - within));
    const auto end = static_cast<std::size_t>(std::min(std::ssize(column), i + within + 1));
    const double mean = (before[end] - before[first]) / static_cast<double>(end - first);
    const auto row = static_cast<std::size_t>(i);
    details[row] = (column[row] - mean) / greatest;
  }
  return details;
}

// Of so many sites each, a mean.
std::vector<double> rows_of(const std::vector<double>& values, std::size_t sites_of_row) {
  std::vector<double> rows;
  for (std::size_t first = 0; first + sites_of_row <= values.size(); first += sites_of_row) {
    double sum = 0.0;
    for (std::size_t i = first; i < first + sites_of_row; ++i) sum += values[i];
    rows.push_back(sum / static_cast<double>(sites_of_row));
  }
  return rows;
}

// [column][row]: each factor at each look.
std::vector<std::vector<double>> columns_of(const DrivenPlace& place, std::size_t sites_of_row) {
  const FactorTable& factors = place.factors;
  std::vector<std::vector<double>> columns;
  for (std::size_t factor = 0; factor < factors.factors.size(); ++factor) {
    if (!is_appearance(factors.factors[factor])) continue;
    const std::size_t looks = factor < factors.shared_count ? 1 : factors.looks.size();
    for (std::size_t look = 0; look < looks; ++look) {
      std::vector<double> values;
      for (std::size_t site = 0; site < factors.site_count; ++site) {
        values.push_back(factors.at(site, look, factor));
      }
      columns.push_back(rows_of(values, sites_of_row));
    }
  }
  return columns;
}

Details details_of(const DrivenPlace& place, std::size_t sites_of_row) {
  const std::vector<std::vector<double>> columns = columns_of(place, sites_of_row);
  const auto within = static_cast<std::ptrdiff_t>(
      kMeanWithin_m / (place.sites.spacing_m * static_cast<double>(sites_of_row)));
  Details details;
  details.columns = columns.size();
  details.rows = columns.empty() ? 0 : columns.front().size();
  details.values.resize(details.rows * details.columns);
  details.squares.resize((details.rows + 1) * details.columns, 0.0);
  for (std::size_t column = 0; column < columns.size(); ++column) {
    const std::vector<double> of_column = details_of(columns[column], within);
    for (std::size_t row = 0; row < details.rows; ++row) {
      const std::size_t i = row * details.columns + column;
      details.values[i] = of_column[row];
      details.squares[i + details.columns] = details.squares[i] + of_column[row] * of_column[row];
    }
  }
  return details;
}

// The same route from its end.
Details reversed(const Details& details) {
  Details back = details;
  for (std::size_t row = 0; row < details.rows; ++row) {
    const double* const from = details.row(details.rows - 1 - row);
    for (std::size_t column = 0; column < details.columns; ++column) {
      const std::size_t i = row * details.columns + column;
      back.values[i] = from[column];
      back.squares[i + details.columns] = back.squares[i] + from[column] * from[column];
    }
  }
  return back;
}

// Two stretches of equal length: rows from `of_a` and `of_b` on.
struct Stretches {
  std::size_t of_a = 0, of_b = 0, rows = 0;
};

// Median over the columns that vary in both; 0 where few do. `products`: sums of their products.
double correlation(const Details& a, const Details& b, const Stretches& stretches,
                   const std::vector<double>& products) {
  constexpr double kLeastShare = 1e-6;  // of a column's greatest value, root mean square
  const double least = kLeastShare * kLeastShare * static_cast<double>(stretches.rows);
  std::vector<double> correlations;
  for (std::size_t column = 0; column < a.columns; ++column) {
    const double power_a = a.power(stretches.of_a, stretches.rows, column);
    const double power_b = b.power(stretches.of_b, stretches.rows, column);
    if (power_a < least || power_b < least) continue;
    correlations.push_back(products[column] / std::sqrt(power_a * power_b));
  }
  if (correlations.size() < kFewestColumns) return 0.0;
  const auto middle = correlations.begin() + std::ssize(correlations) / 2;
  std::ranges::nth_element(correlations, middle);
  return *middle;
}

void add_products(const Details& a, std::size_t of_a, const Details& b, std::size_t of_b,
                  double sign, std::vector<double>& products) {
  const double* const row_a = a.row(of_a);
  const double* const row_b = b.row(of_b);
  for (std::size_t column = 0; column < a.columns; ++column) {
    products[column] += sign * row_a[column] * row_b[column];
  }
}

// Of all stretches of `rows` at a lag; it has room for one at least.
double greatest_at(const Details& a, const Details& b, Stretches first) {
  const std::size_t room = std::min(a.rows - first.of_a, b.rows - first.of_b);
  std::vector<double> products(a.columns, 0.0);
  double greatest = 0.0;
  for (std::size_t end = 0; end < room; ++end) {
    add_products(a, first.of_a + end, b, first.of_b + end, 1.0, products);
    if (end < first.rows - 1) continue;
    const std::size_t begin = end + 1 - first.rows;
    const Stretches stretches = {first.of_a + begin, first.of_b + begin, first.rows};
    if (begin % kHop == 0) greatest = std::max(greatest, correlation(a, b, stretches, products));
    add_products(a, stretches.of_a, b, stretches.of_b, -1.0, products);
  }
  return greatest;
}

double greatest_correlation(const Details& a, const Details& b, std::size_t rows) {
  double greatest = 0.0;
  for (std::size_t lag = 0; lag + rows <= b.rows; ++lag) {
    greatest = std::max(greatest, greatest_at(a, b, {0, lag, rows}));
  }
  for (std::size_t lag = 1; lag + rows <= a.rows; ++lag) {
    greatest = std::max(greatest, greatest_at(a, b, {lag, 0, rows}));
  }
  return greatest;
}

}  // namespace

double street_likeness(const DrivenPlace& a, const DrivenPlace& b) {
  const bool is_comparable = a.factors.factors == b.factors.factors &&
                             a.factors.looks == b.factors.looks &&
                             a.sites.spacing_m == b.sites.spacing_m;
  if (!is_comparable) return 0.0;
  const double shorter_m = std::min(length_m(a), length_m(b));
  const double compared_m = std::max(kLeastStretch_m, kShare * shorter_m);
  if (shorter_m < compared_m) return 0.0;
  const std::size_t longer = std::max(a.sites.sites.size(), b.sites.sites.size());
  const std::size_t sites_of_row = (longer + kMostRows - 1) / kMostRows;
  const double row_m = a.sites.spacing_m * static_cast<double>(sites_of_row);
  const auto rows = static_cast<std::size_t>(compared_m / row_m);
  const Details of_a = details_of(a, sites_of_row);
  const Details of_b = details_of(b, sites_of_row);
  return std::max(greatest_correlation(of_a, of_b, rows),
                  greatest_correlation(of_a, reversed(of_b), rows));
}

bool is_one_street(const DrivenPlace& a, const DrivenPlace& b) {
  if (length_m(b) < length_m(a)) return is_one_street(b, a);
  const std::vector<Eigen::Vector3d> of_a = route_of(a);
  const std::vector<Eigen::Vector3d> of_b = route_of(b);
  if (is_of_the_world(of_a) && is_of_the_world(of_b)) return share_a_route(of_a, of_b);
  return street_likeness(a, b) >= kOneStreet;
}

Origins origins_of(const DrivenPlaces& places) {
  std::vector<const RecordingCards*> recordings;
  for (const DrivenPlace& place : places.places) recordings.push_back(&place.recordings);
  Origins origins = origins_by_recording(recordings);
  for (std::size_t i = 0; i < places.places.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (origins.places[i] == origins.places[j]) continue;
      if (is_one_street(places.places[i], places.places[j])) join_places(i, j, origins);
    }
  }
  return origins;
}

}  // namespace sightline
