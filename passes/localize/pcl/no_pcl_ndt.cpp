#include "formats/base/check.h"
#include "passes/localize/pcl/pcl_ndt.h"

// In place of pcl_ndt.cpp where PCL is not there.

namespace sightline {

struct PclNdt::State {};

PclNdt::PclNdt(const NdtMap&, const Eigen::Vector3d&) { SIGHTLINE_CHECK(false); }
PclNdt::PclNdt(std::span<const Eigen::Vector3d>, double, int) { SIGHTLINE_CHECK(false); }
PclNdt::~PclNdt() = default;
PclNdt::PclNdt(PclNdt&&) noexcept = default;
PclNdt& PclNdt::operator=(PclNdt&&) noexcept = default;

void PclNdt::set_scan(std::span<const Eigen::Vector3d>) {}
PclMatch PclNdt::match(const Pose& T_map_start) { return {T_map_start, 0}; }

bool has_pcl_ndt() { return false; }

}  // namespace sightline
