// SPDX-License-Identifier: Apache-2.0
// Sine, cosine and square root that give the same bits on host and ARM: additions and multiplications in a
// fixed order (compiled without contraction), and the hardware's correctly rounded square root.
#pragma once

namespace tetragauge {

// Both for |angle| up to some 1e4; error under 2 units in the last place of 1.
template <class Scalar>
struct SinCos {
  Scalar sin, cos;
};

template <class Scalar>
constexpr SinCos<Scalar> sin_cos(Scalar angle) {
  // Quadrant q and remainder r = angle - q pi/2 in [-pi/4, pi/4]; pi/2 in three parts, the first two short
  // enough that their products with q are exact (Cody and Waite 1980, chapter 8). In float the parts have 8,
  // 11 bits.
  constexpr double kTwoOverPi = 0.63661977236758134308;
  const Scalar scaled = angle * static_cast<Scalar>(kTwoOverPi);
  const int q = static_cast<int>(scaled + (scaled < 0 ? Scalar(-0.5) : Scalar(0.5)));
  const Scalar n = static_cast<Scalar>(q);
  Scalar r{};
  if constexpr (sizeof(Scalar) == 4) {
    r = ((angle - n * 1.5703125f) - n * 4.837512969970703125e-4f) - n * 7.54978995489188216e-8f;
  } else {
    r = ((angle - n * 1.57079632673412561417) - n * 6.07710050630396597660e-11) -
        n * 2.02226624879595063154e-21;
  }
  // Taylor series to beyond the last place at pi/4.
  const Scalar r2 = r * r;
  Scalar s{}, c{};
  if constexpr (sizeof(Scalar) == 4) {
    s = r + r * r2 * (-1.f / 6 + r2 * (1.f / 120 + r2 * (-1.f / 5040 + r2 * (1.f / 362880))));
    c = 1 + r2 * (-0.5f + r2 * (1.f / 24 + r2 * (-1.f / 720 + r2 * (1.f / 40320))));
  } else {
    s = r + r * r2 *
                (-1. / 6 +
                 r2 * (1. / 120 +
                       r2 * (-1. / 5040 +
                             r2 * (1. / 362880 +
                                   r2 * (-1. / 39916800 + r2 * (1. / 6227020800 - r2 / 1307674368000.))))));
    c = 1 +
        r2 * (-0.5 + r2 * (1. / 24 +
                           r2 * (-1. / 720 + r2 * (1. / 40320 + r2 * (-1. / 3628800 +
                                                                      r2 * (1. / 479001600 +
                                                                            r2 * (-1. / 87178291200. +
                                                                                  r2 / 20922789888000.)))))));
  }
  switch (q & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

inline float square_root(float x) {
  return __builtin_sqrtf(x);
}
inline double square_root(double x) {
  return __builtin_sqrt(x);
}

}  // namespace tetragauge
