// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/faces/triangle_normals.hpp"

#include <algorithm>
#include <cmath>

namespace tetragauge {
namespace {

constexpr double kGate = 4;  // standard deviations of the angle between two neighbours
constexpr int kCorrections = 10;
// Flatter triangles than this have no normal worth the name.
constexpr double kMostSigma = 0.35;  // rad

double angle_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// Normal, centre and noise of one triangle; no area: no element.
FacetElement element_of(const Reconstruction& reconstruction, uint32_t t) {
  const auto& v = reconstruction.surface[t].vertex;
  const Vec3 &a = reconstruction.vertices[v[0]], &b = reconstruction.vertices[v[1]],
             &c = reconstruction.vertices[v[2]];
  FacetElement e;
  e.triangle = t;
  const Vec3 cross = (b - a).cross(c - a);
  e.area_mm2 = 0.5 * cross.norm();
  if (!(e.area_mm2 > 0)) return e;
  e.normal = cross.normalized();
  e.centre = (a + b + c) / 3;
  double variance = 0;
  for (uint32_t i : v)
    variance +=
        std::pow(sigma_across(reconstruction.vertex_sigma_mm[i], reconstruction.vertex_ray[i], e.normal), 2);
  e.height_sigma_mm = std::sqrt(variance) / 3;
  const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  e.normal_sigma = std::sqrt(variance / 3) * longest / (2 * e.area_mm2);  // over the smallest altitude
  return e;
}

}  // namespace

std::vector<FacetElement> facet_elements(const Reconstruction& reconstruction, double neighbour_weight) {
  const auto& surface = reconstruction.surface;
  std::vector<FacetElement> all(surface.size());
  for (uint32_t t = 0; t < surface.size(); ++t) all[t] = element_of(reconstruction, t);

  // Who is trusted: seen, with a normal, and no neighbour at an angle that noise does not explain.
  const auto has_normal = [&](uint32_t t) {
    return !surface[t].unseen && all[t].area_mm2 > 0 && all[t].normal_sigma < kMostSigma;
  };
  std::vector<uint8_t> trusted(surface.size(), 0);
  for (uint32_t t = 0; t < surface.size(); ++t) {
    trusted[t] = has_normal(t);
    for (const int32_t n : surface[t].neighbour) {
      if (n < 0 || !trusted[t]) continue;
      const auto other = static_cast<uint32_t>(n);
      if (!has_normal(other)) continue;
      const double noise = std::hypot(all[t].normal_sigma, all[other].normal_sigma);
      if (angle_between(all[t].normal, all[other].normal) > kGate * noise) trusted[t] = 0;
    }
  }
  std::vector<uint32_t> index(surface.size(), UINT32_MAX);
  std::vector<FacetElement> elements;
  for (uint32_t t = 0; t < surface.size(); ++t) {
    if (!trusted[t]) continue;
    index[t] = static_cast<uint32_t>(elements.size());
    elements.push_back(all[t]);
  }
  for (FacetElement& e : elements) {
    for (const int32_t n : surface[e.triangle].neighbour) {
      if (n >= 0 && index[static_cast<size_t>(n)] != UINT32_MAX)
        e.neighbours.push_back(index[static_cast<size_t>(n)]);
    }
  }

  if (!(neighbour_weight > 0)) return elements;
  std::vector<Vec3> corrected(elements.size());
  std::vector<double> sigma(elements.size());
  for (int round = 0; round < kCorrections; ++round) {
    for (size_t k = 0; k < elements.size(); ++k) {
      const FacetElement& e = elements[k];
      double total = 1 / (e.normal_sigma * e.normal_sigma);
      double variance = total;
      Vec3 sum = total * e.normal;
      for (const uint32_t n : e.neighbours) {
        const double weight = neighbour_weight / std::pow(elements[n].normal_sigma, 2);
        sum += weight * elements[n].normal;
        total += weight;
        variance += weight * neighbour_weight;
      }
      corrected[k] = sum.normalized();
      sigma[k] = std::sqrt(variance) / total;
    }
    for (size_t k = 0; k < elements.size(); ++k) {
      elements[k].normal = corrected[k];
      // Neighbours share vertices and, from the second round on, one another: less is gained than independent
      // normals would give.
      elements[k].normal_sigma = std::max(sigma[k], 0.8 * elements[k].normal_sigma);
    }
  }
  return elements;
}

}  // namespace tetragauge
