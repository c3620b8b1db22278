// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/match_procrustes.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "host/match/allowed_pairs.hpp"
#include "host/match/rank_poses.hpp"

namespace tetragauge {
namespace {

// Links seldom change after the third turn; two sets of links that follow each other for ever end here.
constexpr int kMostTurns = 30;

struct Link {
  size_t model, measured;
  bool operator==(const Link&) const = default;
};
using Links = std::vector<Link>;  // ascending by model

// The plane's normal, away from the plane centre, as long as distance times area.
std::vector<Vec3> scaled_normals(const PlaneSet& set, const Vec3& centre) {
  std::vector<Vec3> vectors;
  for (const MatchPlane& plane : set.planes)
    vectors.push_back(plane.area_mm2 * (plane.d_mm - plane.normal.dot(centre)) * plane.normal);
  return vectors;
}

class Procrustes {
 public:
  Procrustes(std::vector<Vec3> model, std::vector<Vec3> measured, const AllowedPairs& allowed,
             ProcrustesOptions::Links links)
      : model_(std::move(model)), measured_(std::move(measured)), allowed_(allowed), links_(links) {
    for (const auto& [i, j] : allowed.fixed) fixed_.push_back({i, j});
  }

  struct Solution {
    Mat3 R = Mat3::Identity();  // model from part
    Links links;
    double residual = 1;
    int half_turn_axis = 0;
  };

  Solution run() const {
    const Links by_radius = link_nearest(
        {}, [&](size_t i, size_t j) { return std::abs(model_[i].norm() - measured_[j].norm()); });
    const Mat3 first = turn(by_radius);
    Solution best;
    for (int axis = 0; axis <= 3; ++axis) {
      const Mat3 half =
          axis == 0 ? Mat3(Mat3::Identity())
                    : Mat3(2 * Vec3::Unit(axis - 1) * Vec3::Unit(axis - 1).transpose() - Mat3::Identity());
      Solution tried = settle(half * first, by_radius);
      tried.half_turn_axis = axis;
      if (axis == 0 || tried.residual < best.residual) best = std::move(tried);
    }
    return best;
  }

 private:
  // Allowed pairs that are each other's nearest among those not in `kept`, added to `kept`. Ties go to the
  // first.
  Links link_nearest(Links kept, const std::function<double(size_t, size_t)>& distance) const {
    std::vector<bool> model_taken(model_.size()), measured_taken(measured_.size());
    for (const Link& link : kept) model_taken[link.model] = measured_taken[link.measured] = true;
    constexpr double kNever = std::numeric_limits<double>::infinity();
    const auto nearest = [&](const std::vector<bool>& taken, const auto& distance_to) {
      size_t best = taken.size();
      double least = kNever;
      for (size_t k = 0; k < taken.size(); ++k) {
        const double here = taken[k] ? kNever : distance_to(k);
        if (here < least) {
          least = here;
          best = k;
        }
      }
      return best;
    };
    const auto allowed_distance = [&](size_t i, size_t j) {
      return allowed_(i, j) ? distance(i, j) : kNever;
    };
    Links links = kept;
    for (size_t i = 0; i < model_.size(); ++i) {
      if (model_taken[i]) continue;
      const size_t j = nearest(measured_taken, [&](size_t k) { return allowed_distance(i, k); });
      if (j == measured_.size()) continue;
      if (nearest(model_taken, [&](size_t k) { return allowed_distance(k, j); }) == i)
        links.push_back({i, j});
    }
    std::sort(links.begin(), links.end(), [](const Link& a, const Link& b) { return a.model < b.model; });
    return links;
  }

  // Orthogonal Procrustes, rotations only (Schoenemann, Psychometrika 31 (1966) 1; Kabsch, Acta Cryst. A32
  // (1976) 922).
  Mat3 turn(const Links& links) const {
    Mat3 scatter = Mat3::Zero();
    for (const Link& link : links) scatter += model_[link.model] * measured_[link.measured].transpose();
    const Eigen::JacobiSVD<Mat3> svd(scatter, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Vec3 sign(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
    return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  }

  double length(const Link& link, const Mat3& R) const {
    return (model_[link.model] - R * measured_[link.measured]).norm();
  }

  // The length at the minimum between the two highest modes of the density of link lengths (Gaussian kernels
  // of Silverman's width, Density Estimation (1986), eq. 3.31); beyond all of them when there is one mode.
  double longest_to_keep(const Links& links, const Mat3& R) const {
    constexpr int kCells = 256;
    std::vector<double> lengths;
    for (const Link& link : links) lengths.push_back(length(link, R));
    if (lengths.empty()) return 0;
    std::sort(lengths.begin(), lengths.end());
    const auto n = static_cast<double>(lengths.size());
    double mean = 0, square = 0;
    for (const double l : lengths) mean += l / n;
    for (const double l : lengths) square += (l - mean) * (l - mean) / n;
    const double quartiles = lengths[3 * lengths.size() / 4] - lengths[lengths.size() / 4];
    double spread = std::sqrt(square);
    if (quartiles > 0) spread = std::min(spread, quartiles / 1.34);
    const double width = 0.9 * spread * std::pow(n, -0.2);
    if (!(width > 0)) return lengths.back();
    std::array<double, kCells> density{};
    const double low = lengths.front(), step = (lengths.back() - low) / (kCells - 1);
    for (int k = 0; k < kCells; ++k)
      for (const double l : lengths)
        density[static_cast<size_t>(k)] += std::exp(-0.5 * std::pow((low + k * step - l) / width, 2));
    std::vector<size_t> modes;
    for (size_t k = 0; k < kCells; ++k)
      if ((k == 0 || density[k] > density[k - 1]) && (k + 1 == kCells || density[k] >= density[k + 1]))
        modes.push_back(k);
    if (modes.size() < 2) return lengths.back();
    std::stable_sort(modes.begin(), modes.end(), [&](size_t a, size_t b) { return density[a] > density[b]; });
    const auto [from, to] = std::minmax(modes[0], modes[1]);
    const auto least = std::min_element(density.begin() + static_cast<std::ptrdiff_t>(from),
                                        density.begin() + static_cast<std::ptrdiff_t>(to));
    return low + static_cast<double>(least - density.begin()) * step;
  }

  Links relink(const Links& links, const Mat3& R) const {
    Links kept = fixed_;
    if (links_ == ProcrustesOptions::Links::modes) {
      const double longest = longest_to_keep(links, R);
      for (const Link& link : links)
        if (length(link, R) <= longest && std::find(fixed_.begin(), fixed_.end(), link) == fixed_.end())
          kept.push_back(link);
    }
    return link_nearest(kept, [&](size_t i, size_t j) { return length({i, j}, R); });
  }

  Solution settle(Mat3 R, Links links) const {
    for (int k = 0; k < kMostTurns; ++k) {
      Links next = relink(links, R);
      R = turn(next);
      const bool same = next == links;
      links = std::move(next);
      if (same) break;
    }
    return {R, links, residual(links, R), 0};
  }

  // Squared lengths of the links, and of the vectors without one, over those of all vectors.
  double residual(const Links& links, const Mat3& R) const {
    double all = 0, rest = 0;
    for (const Vec3& v : model_) all += v.squaredNorm();
    for (const Vec3& v : measured_) all += v.squaredNorm();
    rest = all;
    for (const Link& link : links)
      rest += std::pow(length(link, R), 2) - model_[link.model].squaredNorm() -
              measured_[link.measured].squaredNorm();
    return all > 0 ? std::sqrt(std::max(0.0, rest) / all) : 1;
  }

  std::vector<Vec3> model_, measured_;
  const AllowedPairs& allowed_;
  Links fixed_;
  ProcrustesOptions::Links links_;
};

}  // namespace

Result<ProcrustesMatch> match_procrustes(const FaceList& model_list, const FaceList& measured_list,
                                         const ProcrustesOptions& options) {
  const Result<PlaneSet> model = model_planes(model_list);
  if (!model) return model.error();
  const Result<PlaneSet> measured = measured_planes(measured_list);
  if (!measured) return measured.error();

  const Result<AllowedPairs> allowed = allowed_pairs(*model, *measured, options.rules);
  if (!allowed) return allowed.error();

  ProcrustesMatch out;
  out.plane_centre_model_mm = plane_centre(model->planes);
  out.plane_centre_measured_mm = plane_centre(measured->planes);
  const Procrustes::Solution solution =
      Procrustes(scaled_normals(*model, out.plane_centre_model_mm),
                 scaled_normals(*measured, out.plane_centre_measured_mm), *allowed, options.links)
          .run();
  if (solution.links.empty()) return no_pose_error(*model, *measured);
  out.residual = solution.residual;
  out.half_turn_axis = solution.half_turn_axis;

  Match& match = out.match;
  match.T_model_part = {solution.R, out.plane_centre_model_mm - solution.R * out.plane_centre_measured_mm};
  match.centroid_mm = model->pivot_mm;
  match.poses_compared = 4;
  std::vector<PlanePair> pairs;
  for (const Link& link : solution.links) {
    const double cosine =
        model->planes[link.model].normal.dot(solution.R * measured->planes[link.measured].normal);
    pairs.push_back({link.model, link.measured, cosine < 0});
  }
  write_pairs(*model, *measured, pairs, std::vector<bool>(pairs.size(), true), match);
  for (const FacePair& pair : match.pairs)
    match.rms_mm += pair.offset_mm * pair.offset_mm / static_cast<double>(match.pairs.size());
  match.rms_mm = std::sqrt(match.rms_mm);
  return out;
}

}  // namespace tetragauge
