#pragma once

#include <cstddef>
#include <cstdint>

// The score's inner loop behind plain pointers, in three versions that give the same bits. Files
// with vector flags must not leak inline code to the rest of the program: this header includes no
// Eigen, and its inline functions are unnamed.

namespace sightline {

// The cells above one place in the plane: from the cell `low_z` on, size_z follow each other
// upwards, and records[first] is the number of the first one's record.
struct KernelColumn {
  std::uint32_t first;
  std::int16_t low_z;
  std::uint16_t size_z;
};

// Cells by columns, row by row of y from low_y on, each row from low_x on. A cell that is not there
// has record 0.
struct KernelColumns {
  const KernelColumn* columns = nullptr;  // null: cells are given in another way
  const std::int32_t* records = nullptr;
  std::int32_t low_x = 0, low_y = 0;
  std::uint32_t size_x = 0, size_y = 0;
};

namespace {

// So far beyond the first; below it a number too large.
inline std::uint32_t beyond(std::int32_t first, std::int32_t number) {
  return static_cast<std::uint32_t>(number) - static_cast<std::uint32_t>(first);
}

// Null outside of all.
inline const KernelColumn* find_column(const KernelColumns& all, std::int32_t x, std::int32_t y) {
  const std::uint32_t column = beyond(all.low_x, x);
  const std::uint32_t row = beyond(all.low_y, y);
  if (column >= all.size_x || row >= all.size_y) return nullptr;
  return all.columns + std::size_t{row} * all.size_x + column;
}

inline std::int32_t find_record(const KernelColumns& all, std::int32_t x, std::int32_t y,
                                std::int32_t z) {
  const KernelColumn* const column = find_column(all, x, y);
  if (column == nullptr) return 0;
  const std::uint32_t number = beyond(column->low_z, z);
  return number < column->size_z ? all.records[column->first + number] : 0;
}

}  // namespace

// The NDs that a cell's points score with, each in a lane (own, -x, +x, -y, +y, -z, +z, none),
// positions relative to the centre of the cell. Information is times d2 of the Gauss constants, so
// that exp(-m^2 / 2) is the term. Where there is no ND the term vanishes.
struct alignas(32) KernelRecord {
  float mean_m[3][8];
  float information_per_m2[6][8];  // xx, xy, xz, yy, yz, zz
};

// Records of cells with few NDs are narrower: nine rows of fewer lanes, in any order of the lanes
// that gives the same sums. Where a record begins is counted in the size of the narrowest.
inline constexpr std::size_t kRecordRows = 9;
struct KernelPlace {
  std::uint32_t begin : 29;            // so many times kRecordRows floats
  std::uint32_t lanes_beyond_one : 3;  // 0 to 7
};

namespace {

inline std::size_t lane_count(KernelPlace place) { return std::size_t{place.lanes_beyond_one} + 1; }

inline const float* record_at(const float* records, KernelPlace place) {
  return records + kRecordRows * place.begin;
}

// Brings a record nearer.
inline void fetch_record(const float* records, KernelPlace place) {
  const char* const begin = reinterpret_cast<const char*>(record_at(records, place));
  const std::size_t size = kRecordRows * lane_count(place) * sizeof(float);
  for (std::size_t line = 0; line < size; line += 64) __builtin_prefetch(begin + line);
  __builtin_prefetch(begin + size - 1);
}

}  // namespace

// One evaluation. Arrays of points hold `count` rounded up to kKernelBatch.
struct KernelInput {
  const double* x_m = nullptr;  // points in the frame of the pose
  const double* y_m = nullptr;
  const double* z_m = nullptr;
  std::size_t count = 0;
  double rotation[9] = {};  // of the pose, row by row
  double translation_m[3] = {};
  double cell_m = 0.0;
  double cells_per_m = 0.0;
  // What the last evaluation found for each point: its cell (NaN at first) and that cell's record.
  double* cell_x = nullptr;
  double* cell_y = nullptr;
  double* cell_z = nullptr;
  std::int32_t* record = nullptr;
  // After the last record there are seven more finite floats.
  const float* records = nullptr;
  const KernelPlace* places = nullptr;  // of records, by their numbers; the first is without any ND
  KernelColumns columns;
  // Where these tell nothing.
  std::int32_t (*find)(const void* grid, double cell_x, double cell_y, double cell_z) = nullptr;
  // Brings what find() reads nearer.
  void (*fetch)(const void* grid, double cell_x, double cell_y, double cell_z) = nullptr;
  const void* grid = nullptr;
};

inline constexpr std::size_t kKernelBatch = 16;
inline constexpr int kKernelSums = 29;
// Lane l of sum s adds the points with index l modulo 16: sum of terms, sum of largest terms, force
// (3), torque (3), and the second derivatives by translation (xx xy xz yy yz zz), by translation
// and rotation (9, row by row) and by rotation (6); of the score over d1.
struct alignas(64) KernelSums {
  float lanes[kKernelSums][kKernelBatch];
};

// `score` computes the sum of terms alone, to the same bits, and leaves the others as they are.
struct KernelVersion {
  void (*all)(const KernelInput& input, KernelSums& sums);
  void (*score)(const KernelInput& input, KernelSums& sums);
};
KernelVersion kernel_portable();
#ifdef SIGHTLINE_X86_KERNELS
KernelVersion kernel_avx2();
KernelVersion kernel_avx512();
#endif

}  // namespace sightline
