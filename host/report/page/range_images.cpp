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

// Views with their rays, put together where their beams fan out from one place.
struct Place {
  size_t set_up = 0;
  std::vector<uint32_t> views;
  std::vector<std::vector<uint32_t>> rays;  // of each view
  Vec3 origin_mm = Vec3::Zero();            // of the first view
  double pixel = 0;                         // of the coarsest view
  Raster raster;                            // of all
  std::vector<uint32_t> all_rays;
};

// Windows of one view point differ in the mirror's point, not in the table's angle or the slide's height.
constexpr double kSamePlace = 0.02;  // of the distance to the part

std::vector<Place> places_of(const Scan& scan, size_t set_up) {
  std::map<uint32_t, std::vector<uint32_t>> rays_of;
  for (uint32_t i = 0; i < scan.size(); ++i) rays_of[scan.view[i]].push_back(i);
  std::vector<Place> places;
  for (auto& [view, rays] : rays_of) {
    Vec3 origin = Vec3::Zero();
    double range = 0;
    for (const uint32_t i : rays) {
      origin += scan.ray_origins[i] / static_cast<double>(rays.size());
      range += (scan.points[i] - scan.ray_origins[i]).norm() / static_cast<double>(rays.size());
    }
    auto at = std::find_if(places.begin(), places.end(), [&](const Place& place) {
      return (place.origin_mm - origin).norm() < kSamePlace * range;
    });
    if (at == places.end()) {
      at = places.insert(places.end(), Place{});
      at->set_up = set_up;
      at->origin_mm = origin;
    }
    at->views.push_back(view);
    at->all_rays.insert(at->all_rays.end(), rays.begin(), rays.end());
    at->rays.push_back(std::move(rays));
  }
  std::erase_if(places, [](const Place& place) { return place.all_rays.size() < kLeastRays; });
  for (Place& place : places) {
    place.raster = raster(scan, place.all_rays);
    // A few directions, shot one by one, do not make the picture coarse.
    for (const auto& rays : place.rays)
      if (rays.size() >= kLeastRays) place.pixel = std::max(place.pixel, pixel_for(raster(scan, rays)));
    if (place.pixel == 0) place.pixel = pixel_for(place.raster);
  }
  return places;
}

}  // namespace

std::vector<RangeImage> range_images(const Report& report, size_t most_pixels) {
  std::vector<Place> places;
  for (size_t s = 0; s < report.scans.size(); ++s)
    for (Place& place : places_of(report.scans[s], s)) places.push_back(std::move(place));
  const auto pixels_at = [&](double coarser) {
    double pixels = 0;
    for (const Place& place : places) {
      const Eigen::Vector2d size = (place.raster.high - place.raster.low) / (coarser * place.pixel);
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
  for (const Place& place : places) {
    images.push_back(image(place.raster, casts[place.set_up], place.all_rays, coarser * place.pixel));
    images.back().set_up = place.set_up;
    images.back().views = place.views;
  }
  return images;
}

}  // namespace tetragauge
