#pragma once

#include <cmath>

namespace sightline {

// Functions whose last bit differs between C libraries, and even between processors with one
// library; here made of +, -, *, / and sqrt, which IEEE 754 rounds correctly, and of moves of bits,
// so that results reach the same bits everywhere. Compile with -ffp-contract=off.
//
// Special values are those of <cmath>: nan gives nan, signs of zero and infinities are kept. Errors
// are in units of the last place (ulp) of the exact result, where nothing else is said.

struct SinCos {
  double sin = 0.0;
  double cos = 1.0;
};
// Up to 1e5 rad in size within 1 ulp. Farther out the angle is first taken modulo the double that
// is nearest to 2 pi, which costs 4e-17 of the angle; nan where it is infinite.
SinCos portable_sin_cos(double angle_rad);

double portable_atan2(double y, double x);  // within 2 ulp
double portable_asin(double x);             // within 3 ulp; nan outside [-1, 1]
double portable_acos(double x);             // within 3 ulp; nan outside [-1, 1]
double portable_exp(double x);              // within 1 ulp, to the smallest subnormal
double portable_log(double x);              // within 1 ulp
double portable_log2(double x);             // within 3 ulp; exact for powers of two

// sqrt(x^2 + y^2) within 2 ulp, where the squares neither overflow nor vanish (1e-150 to 1e150).
inline double portable_hypot(double x, double y) { return std::sqrt(x * x + y * y); }

}  // namespace sightline
