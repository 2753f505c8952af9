#include "formats/drive/identity/scan_sketch.h"

#include <gtest/gtest.h>

#include "tests/formats/drive/identity/street_scans.h"

namespace sightline {
namespace {

constexpr int kScans = 20;

// The least likeness of scans to what `change` makes of them.
template <class Change>
double least_likeness(const Change& change) {
  double least = 1.0;
  for (int i = 0; i < kScans; ++i) {
    const ScanPoints scan = street_scan({}, i);
    least = std::min(least, likeness(sketch_of(scan), sketch_of(change(scan, i))));
  }
  return least;
}

TEST(ScanSketch, OfThreePointsIsTheirCells) {
  const ScanPoints points_m = {{5.0, 0.0, 0.0}, {0.0, 6.0, 0.0}, {0.0, 0.0, 7.0}};
  const ScanSketch sketch = sketch_of(points_m);
  EXPECT_LT(sketch[0], sketch[1]);
  EXPECT_LT(sketch[2], kNoHash);
  EXPECT_EQ(sketch[3], kNoHash);
  ScanPoints again = {
      points_m[2], points_m[0], points_m[1], {5.004, 0.004, 0.004}, {1.0, 1.0, 1.0}};
  EXPECT_EQ(sketch_of(again), sketch) << "order, a point of the same cell and a near one";
  again[0].x() += 0.02;
  EXPECT_NE(sketch_of(again), sketch);
  EXPECT_EQ(likeness(sketch, sketch), 0.0) << "three cells say nothing";
}

TEST(ScanSketch, RecognizesCopies) {
  EXPECT_EQ(least_likeness([](const ScanPoints& scan, int) { return scan; }), 1.0);
  EXPECT_EQ(least_likeness([](const ScanPoints& scan, int i) { return thinned(scan, 0.5, i); }),
            1.0);
  EXPECT_EQ(least_likeness([](const ScanPoints& scan, int) { return cropped(scan, 30.0); }), 1.0);
  EXPECT_GE(least_likeness([](const ScanPoints& scan, int) { return in_float(scan); }), 0.95);
  EXPECT_GE(least_likeness([](const ScanPoints& scan, int) { return in_millimetres(scan); }),
            kCopyLikeness);
  EXPECT_GE(least_likeness([](const ScanPoints& scan, int i) { return with_noise(scan, 1e-3, i); }),
            kCopyLikeness);
}

TEST(ScanSketch, IsTheSameForWholeMillimetresInEveryContainer) {
  EXPECT_EQ(least_likeness([](const ScanPoints& scan, int) {
              const ScanPoints stored = in_millimetres(scan);
              return likeness(sketch_of(stored), sketch_of(in_float(stored))) == 1.0 ? scan
                                                                                     : ScanPoints();
            }),
            1.0);
}

TEST(ScanSketch, DistinguishesDrivesOfOneStreet) {
  std::vector<ScanSketch> others;
  for (int i = 0; i < kScans; ++i) {
    others.push_back(sketch_of(street_scan({.noise = 3, .lateral_m = 0.3}, i + 0.1)));
  }
  for (int i = 0; i < kScans; ++i) {
    const ScanSketch scan = sketch_of(street_scan({}, i));
    const ScanSketch other_noise = sketch_of(street_scan({.noise = 2}, i));
    EXPECT_LT(likeness(scan, other_noise), kCopyLikeness) << "from the same pose, scan " << i;
    for (const ScanSketch& other : others) EXPECT_LT(likeness(scan, other), 0.5) << i;
  }
}

}  // namespace
}  // namespace sightline
