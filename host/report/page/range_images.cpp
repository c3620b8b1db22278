// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/report/page/range_images.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "host/inspect/cast_scan.hpp"

namespace tetragauge {
namespace {

constexpr size_t kLeastRays = 50;
constexpr double kRaysPerPixel = 1.4;  // so that few pixels between rays stay empty

// Where a view's rays pierce the picture, x to the right and y up.
struct Raster {
  bool is_perspective = true;
  std::vector<Eigen::Vector2d> at;
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300), high = -low;
};

Raster raster(const Scan& scan, const std::vector<uint32_t>& rays) {
  Vec3 forward = Vec3::Zero(), origin = Vec3::Zero(), middle = Vec3::Zero();
  for (const uint32_t i : rays) {
    forward += scan.ray_direction(i);
    origin += scan.ray_origins[i] / static_cast<double>(rays.size());
    middle += scan.points[i] / static_cast<double>(rays.size());
  }
  forward.normalize();
  const Vec3 up_hint = std::abs(forward.z()) < 0.99 ? Vec3::UnitZ() : Vec3::UnitY();
  const Vec3 right = forward.cross(up_hint).normalized(), up = right.cross(forward);
  const auto across = [&](const Vec3& p, const Vec3& from) {
    return Eigen::Vector2d((p - from).dot(right), (p - from).dot(up));
  };
  double origins_spread = 0, points_spread = 0;
  for (const uint32_t i : rays) {
    origins_spread += across(scan.ray_origins[i], origin).squaredNorm();
    points_spread += across(scan.points[i], middle).squaredNorm();
  }
  // Beams that fan out from one place, or that run side by side.
  Raster out;
  out.is_perspective = origins_spread < 0.25 * points_spread;
  for (const uint32_t i : rays) {
    const Vec3 d = scan.ray_direction(i);
    const Eigen::Vector2d at = out.is_perspective
                                   ? Eigen::Vector2d(d.dot(right), d.dot(up)) / std::max(0.1, d.dot(forward))
                                   : across(scan.points[i], middle);
    out.at.push_back(at);
    out.low = out.low.cwiseMin(at);
    out.high = out.high.cwiseMax(at);
  }
  return out;
}

// A pixel holds about kRaysPerPixel rays where there are any: the area with rays is counted in coarse
// squares.
double pixel_for(const Raster& raster) {
  const Eigen::Vector2d size = (raster.high - raster.low).cwiseMax(1e-9);
  const double n = static_cast<double>(raster.at.size());
  const double square = 3 * std::sqrt(size.prod() / n);
  std::set<std::pair<int, int>> squares;
  for (const Eigen::Vector2d& at : raster.at) {
    const Eigen::Vector2d place = (at - raster.low) / square;
    squares.emplace(static_cast<int>(place.x()), static_cast<int>(place.y()));
  }
  return std::sqrt(kRaysPerPixel * static_cast<double>(squares.size()) / n) * square;
}

RangeImage image(const Raster& raster, const CastScan& cast, const std::vector<uint32_t>& rays,
                 double pixel) {
  RangeImage out;
  out.is_perspective = raster.is_perspective;
  out.pixel = pixel;
  const Eigen::Vector2d size = raster.high - raster.low;
  out.width = static_cast<size_t>(size.x() / pixel) + 1;
  out.height = static_cast<size_t>(size.y() / pixel) + 1;
  const size_t pixels = out.width * out.height;
  out.beyond_mm.assign(pixels, RangeImage::kNoRay);
  out.face.assign(pixels, 0);
  std::vector<double> sum(pixels, 0.0), count(pixels, 0.0);
  double total = 0, squares = 0;
  for (size_t k = 0; k < rays.size(); ++k) {
    const Eigen::Vector2d place = (raster.at[k] - raster.low) / pixel;
    const size_t x = std::min(out.width - 1, static_cast<size_t>(place.x()));
    const size_t y = std::min(out.height - 1, static_cast<size_t>(place.y()));
    const size_t at = (out.height - 1 - y) * out.width + x;
    ++out.rays;
    if (cast.face[rays[k]] < 0) {
      if (count[at] == 0) out.beyond_mm[at] = RangeImage::kNoModel;
      continue;
    }
    const double beyond = cast.beyond_mm[rays[k]];
    ++out.on_model;
    total += beyond;
    squares += beyond * beyond;
    if (out.face[at] == 0) out.face[at] = static_cast<uint16_t>(cast.face[rays[k]] + 1);
    sum[at] += beyond;
    count[at] += 1;
    out.beyond_mm[at] = static_cast<float>(sum[at] / count[at]);
  }
  const double on_model = static_cast<double>(std::max<size_t>(1, out.on_model));
  out.mean_mm = total / on_model;
  out.rms_mm = std::sqrt(squares / on_model);
  return out;
}

}  // namespace

std::vector<RangeImage> range_images(const Report& report, size_t most_pixels) {
  struct View {
    size_t set_up = 0;
    uint32_t view = 0;
    std::vector<uint32_t> rays;
    Raster raster;
  };
  std::vector<View> views;
  for (size_t s = 0; s < report.scans.size(); ++s) {
    std::map<uint32_t, std::vector<uint32_t>> rays_of;
    for (uint32_t i = 0; i < report.scans[s].size(); ++i) rays_of[report.scans[s].view[i]].push_back(i);
    for (auto& [view, rays] : rays_of) {
      if (rays.size() < kLeastRays) continue;
      Raster of_view = raster(report.scans[s], rays);
      views.push_back({s, view, std::move(rays), std::move(of_view)});
    }
  }
  const auto pixels_at = [&](double coarser) {
    double pixels = 0;
    for (const View& view : views) {
      const Eigen::Vector2d size = (view.raster.high - view.raster.low) / (coarser * pixel_for(view.raster));
      pixels += (size.x() + 1) * (size.y() + 1);
    }
    return pixels;
  };
  double coarser = 1;
  while (pixels_at(coarser) > static_cast<double>(most_pixels)) coarser *= 1.1;

  const RayCaster caster(report.model);
  std::vector<CastScan> casts;
  for (size_t s = 0; s < report.scans.size(); ++s)
    casts.push_back(
        cast_scan(report.scans[s], report.model, caster, report.run.set_ups[s].match.T_model_part));
  std::vector<RangeImage> images;
  for (const View& view : views) {
    images.push_back(image(view.raster, casts[view.set_up], view.rays, coarser * pixel_for(view.raster)));
    images.back().set_up = view.set_up;
    images.back().view = view.view;
  }
  return images;
}

}  // namespace tetragauge
