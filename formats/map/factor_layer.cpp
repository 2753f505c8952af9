#include "formats/map/factor_layer.h"

#include <cstring>

#include "formats/base/check.h"
#include "formats/reader/map_layout.h"

namespace sightline {
namespace {

// Two columns: site u32[n], value f64[n][ranges][factors].
struct FactorLayout {
  std::uint64_t row_size = 0;
  std::uint64_t values = 0;
  std::uint64_t size = 0;

  FactorLayout(std::uint64_t rows, const FactorTable& factors)
      : row_size(sizeof(double) * factors.looks.size() * factors.factors.size()),
        values(aligned(rows * sizeof(std::uint32_t))),
        size(aligned(values + rows * row_size)) {}
};

// Of one site, [look][factor].
void put_values(const FactorTable& factors, std::size_t site, std::byte* into) {
  std::vector<double> values;
  values.reserve(factors.looks.size() * factors.factors.size());
  for (std::size_t look = 0; look < factors.looks.size(); ++look) {
    for (std::size_t factor = 0; factor < factors.factors.size(); ++factor) {
      values.push_back(factors.at(site, look, factor));
    }
  }
  std::memcpy(into, values.data(), sizeof(double) * values.size());
}

// `place_of`: where in the table the values of a row are.
template <class PlaceOf>
std::vector<std::byte> encode(const FactorTable& factors, std::span<const std::uint32_t> sites,
                              const PlaceOf& place_of) {
  const FactorLayout layout(sites.size(), factors);
  std::vector<std::byte> raw(layout.size);
  std::memcpy(raw.data(), sites.data(), sites.size_bytes());
  for (std::size_t row = 0; row < sites.size(); ++row) {
    put_values(factors, place_of(row), raw.data() + layout.values + row * layout.row_size);
  }
  return raw;
}

}  // namespace

std::vector<std::byte> encode_factor_layer(const FactorTable& factors,
                                           std::span<const std::uint32_t> sites) {
  return encode(factors, sites, [&](std::size_t row) { return sites[row]; });
}

std::vector<std::byte> encode_factor_rows(const FactorTable& of_sites,
                                          std::span<const std::uint32_t> sites) {
  SIGHTLINE_CHECK(of_sites.site_count == sites.size());
  return encode(of_sites, sites, [](std::size_t row) { return row; });
}

Result<void> decode_factor_layer(std::span<const std::byte> raw, std::uint64_t row_count,
                                 FactorTable& factors, std::vector<bool>& is_filled) {
  if (row_count > kMostRows || raw.size() != FactorLayout(row_count, factors).size) {
    return Error{ErrorCode::kBadLayer,
                 concat("found ", raw.size(), " bytes of factors of ", row_count, " sites")};
  }
  const FactorLayout layout(row_count, factors);
  const std::size_t row_values = layout.row_size / sizeof(double);
  for (std::uint64_t row = 0; row < row_count; ++row) {
    std::uint32_t site = 0;
    std::memcpy(&site, raw.data() + row * sizeof site, sizeof site);
    if (site >= is_filled.size() || is_filled[site]) {
      return Error{ErrorCode::kBadOrder,
                   "the factors of a site are of an unknown site or listed twice"};
    }
    is_filled[site] = true;
    std::memcpy(factors.values.data() + site * row_values,
                raw.data() + layout.values + row * layout.row_size, layout.row_size);
  }
  return {};
}

std::vector<std::byte> encode_factor_names(const FactorTable& factors) {
  std::string text;
  for (const std::string& name : factors.factors) text += name + "\n";
  const std::span<const std::byte> bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

Result<void> decode_factor_names(std::span<const std::byte> raw, FactorTable& factors) {
  std::vector<std::string> names;
  std::string name;
  for (const std::byte byte : raw) {
    if (byte == std::byte{'\n'}) {
      names.push_back(std::move(name));
      name.clear();
    } else {
      name += static_cast<char>(byte);
    }
  }
  if (!name.empty() || names.size() != factors.factors.size()) {
    return Error{
        ErrorCode::kBadLayer,
        concat("found ", names.size(), " names of factors, expected ", factors.factors.size())};
  }
  factors.factors = std::move(names);
  return {};
}

}  // namespace sightline
