#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

// Names a scan by its points ("Identity of recordings" in schemas/definitions.md), so that a copy
// is recognized that was written to another container, thinned, cropped or shifted in time. Stamps,
// intensities and the order of points do not count.

namespace sightline {

inline constexpr std::size_t kSketchSize = 32;

// The least hashes of the cells of 2 cm that contain a return beyond 4 m, ascending, each rounded
// to 16 bits; kNoHash behind the last where a scan has fewer cells.
using ScanSketch = std::array<std::uint16_t, kSketchSize>;
inline constexpr std::uint16_t kNoHash = 0xFFFF;

// Points in the sensor's frame, finite.
ScanSketch sketch_of(std::span<const Eigen::Vector3d> points_m);

// Of the hashes up to the lesser of both greatest ones: those in common, over those of the scan
// with fewer. 0 where either has fewer than four. 1 for a scan and a part of it; scans of different
// drives have at most 0.25, even from one pose 0.5 by noise of 2 cm, copies with noise of 1 mm 0.7
// and more.
double likeness(const ScanSketch& a, const ScanSketch& b);

// Above it a scan is a copy of another, or a part of one.
inline constexpr double kCopyLikeness = 0.6;

}  // namespace sightline
