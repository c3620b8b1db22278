// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/match_trials.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "host/base/parse_json.hpp"
#include "host/base/whole_file.hpp"
#include "host/match/free_directions.hpp"

namespace tetragauge::bench {
namespace {

constexpr double kRightAngle_rad = std::numbers::pi / 180, kRightShift_mm = 1;

// The same numbers from every standard library.
class Random {
 public:
  explicit Random(uint64_t seed) : bits_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(bits_() >> 11) * 0x1.0p-53;
  }
  size_t below(size_t n) {
    return std::min(n - 1, static_cast<size_t>(uniform(0, 1) * static_cast<double>(n)));
  }
  Vec3 direction() {
    const double z = uniform(-1, 1), turn = uniform(-std::numbers::pi, std::numbers::pi);
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(turn), r * std::sin(turn), z};
  }
  // Uniform over all rotations (Shoemake, Graphics Gems III (1992) 124).
  Mat3 rotation() {
    const double u = uniform(0, 1), a = uniform(0, 2 * std::numbers::pi),
                 b = uniform(0, 2 * std::numbers::pi);
    return Eigen::Quaterniond(std::sqrt(u) * std::cos(b), std::sqrt(1 - u) * std::sin(a),
                              std::sqrt(1 - u) * std::cos(a), std::sqrt(u) * std::sin(b))
        .toRotationMatrix();
  }

 private:
  std::mt19937_64 bits_;
};

struct Box {
  Vec3 low = Vec3::Constant(1e9), high = Vec3::Constant(-1e9);
};

// Of the part: each coordinate is bounded by the faces across it, or by the centroids where there are none.
Box box_of(const FaceList& model) {
  Box box;
  for (const Face& face : model.faces) {
    box.low = box.low.cwiseMin(face.point_mm);
    box.high = box.high.cwiseMax(face.point_mm);
  }
  return box;
}

Face moved(Face face, const RigidTransform& T) {
  face.normal = T.R * face.normal;
  face.point_mm = T * face.point_mm;
  face.d_mm = face.normal.dot(face.point_mm);
  return face;
}

// Takes one unit vector to another; Eigen's own draws in a singular value decomposition for opposite ones,
// and with it seconds of compiling.
Mat3 smallest_turn(const Vec3& from, const Vec3& to) {
  const Vec3 across = from.cross(to);
  const double sine = across.norm();
  const Vec3 axis = sine > 0 ? Vec3(across / sine) : tangent_frame(from).first;
  return Eigen::AngleAxisd(std::atan2(sine, from.dot(to)), axis).toRotationMatrix();
}

// How far `found` is from `truth`, not counting what is free, at the part's middle.
struct PoseError {
  double angle_rad, shift_mm;
};
PoseError pose_error(const RigidTransform& found, const RigidTransform& truth,
                     const std::vector<FreeDirection>& free, const Vec3& middle) {
  Mat3 turn = found.R * truth.R.transpose();
  Vec3 move = found * (truth.inverse() * middle) - middle;
  for (const FreeDirection& direction : free) {
    const Vec3& axis = direction.axis;
    if (direction.kind == FreeDirection::Kind::translation) {
      move -= axis * axis.dot(move);
    } else {
      turn = smallest_turn(turn * axis, axis);
    }
  }
  return {rotation_angle(turn), move.norm()};
}

bool is_right(const PoseError& error) {
  return error.angle_rad <= kRightAngle_rad && error.shift_mm <= kRightShift_mm;
}

// Null directions of all the rows that the faces put on a small motion, by their singular values.
Eigen::Index free_by_brute_force(const std::vector<Face>& seen, const Vec3& middle) {
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(3 * seen.size()), 6);
  for (size_t k = 0; k < seen.size(); ++k) {
    const Vec3& n = seen[k].normal;
    const auto [u, v] = tangent_frame(n);
    const Vec3 arm = (seen[k].point_mm - middle) / 50;
    const auto r = static_cast<Eigen::Index>(3 * k);
    rows.row(r) << arm.cross(n).transpose(), n.transpose();
    rows.row(r + 1) << u.transpose(), Eigen::RowVector3d::Zero();
    rows.row(r + 2) << v.transpose(), Eigen::RowVector3d::Zero();
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(rows);
  return 6 - (svd.singularValues().array() > 1e-3).count();
}

// The pose that takes three planes to three others exactly, if there is one.
bool pose_of_three(const std::array<const Face*, 3>& from, const std::array<const Face*, 3>& to,
                   RigidTransform& T) {
  Mat3 a, b;
  Vec3 da, db;
  for (int k = 0; k < 3; ++k) {
    a.row(k) = from[static_cast<size_t>(k)]->normal.transpose();
    b.row(k) = to[static_cast<size_t>(k)]->normal.transpose();
    da[k] = from[static_cast<size_t>(k)]->d_mm;
    db[k] = to[static_cast<size_t>(k)]->d_mm;
  }
  if (std::abs(a.determinant()) < 0.05) return false;
  T.R = (a.inverse() * b).transpose();  // b = a R'
  if (T.R.determinant() < 0 || (T.R * T.R.transpose() - Mat3::Identity()).norm() > 1e-4) return false;
  T.R = Eigen::Quaterniond(T.R).normalized().toRotationMatrix();
  T.t = b.inverse() * db - T.R * (a.inverse() * da);
  return true;
}

// Motions of the model that put each face seen on a face of the same area, its centroid on that one's:
// what no list of these faces could ever tell apart.
std::vector<RigidTransform> exact_equivalents(const FaceList& model, const std::vector<Face>& seen,
                                              const Vec3& middle) {
  std::vector<RigidTransform> found;
  const auto lands = [&](const Face& face, const RigidTransform& T) {
    return std::any_of(model.faces.begin(), model.faces.end(), [&](const Face& image) {
      // A .csg has six digits.
      return (T.R * face.normal - image.normal).norm() < 1e-4 &&
             (T * face.point_mm - image.point_mm).norm() < 2e-3 &&
             std::abs(face.area_mm2 - image.area_mm2) < 1e-3 * image.area_mm2;
    });
  };
  size_t first[3] = {0, 0, 0};
  bool spans = false;
  for (size_t i = 0; i < seen.size() && !spans; ++i)
    for (size_t j = i + 1; j < seen.size() && !spans; ++j)
      for (size_t k = j + 1; k < seen.size() && !spans; ++k)
        if (std::abs(seen[i].normal.cross(seen[j].normal).dot(seen[k].normal)) > 0.05) {
          first[0] = i, first[1] = j, first[2] = k;
          spans = true;
        }
  if (!spans) return found;
  const std::array<const Face*, 3> from{&seen[first[0]], &seen[first[1]], &seen[first[2]]};
  for (const Face& a : model.faces)
    for (const Face& b : model.faces)
      for (const Face& c : model.faces) {
        RigidTransform T;
        if (!pose_of_three(from, {&a, &b, &c}, T)) continue;
        if (!std::all_of(seen.begin(), seen.end(), [&](const Face& face) { return lands(face, T); }))
          continue;
        if (std::none_of(found.begin(), found.end(), [&](const RigidTransform& other) {
              return (other.R - T.R).norm() < 1e-3 && (other * middle - T * middle).norm() < 1e-2;
            }))
          found.push_back(T);
      }
  return found;
}

// A face is [id, normal, centroid, area].
nlohmann::ordered_json faces_json(const FaceList& list) {
  auto json = nlohmann::ordered_json::array();
  for (const Face& f : list.faces)
    json.push_back({f.id, f.normal.x(), f.normal.y(), f.normal.z(), f.point_mm.x(), f.point_mm.y(),
                    f.point_mm.z(), f.area_mm2});
  return json;
}

FaceList faces_from_json(const nlohmann::json& json) {
  FaceList list;
  for (const nlohmann::json& row : json) {
    Face face;
    face.id = face.surface = row.at(0);
    for (int k = 0; k < 3; ++k) {
      face.normal[k] = row.at(static_cast<size_t>(1 + k));
      face.point_mm[k] = row.at(static_cast<size_t>(4 + k));
    }
    face.area_mm2 = row.at(7);
    face.d_mm = face.normal.dot(face.point_mm);
    list.faces.push_back(face);
  }
  return list;
}

}  // namespace

namespace {

std::vector<Vec3> true_normals(const Trial& trial) {
  std::vector<Vec3> normals;
  for (const Face& face : trial.model.faces)
    if (std::find(trial.truth.begin(), trial.truth.end(), face.id) != trial.truth.end())
      normals.push_back(face.normal);
  return normals;
}

// The pose that someone would fit who knows which face is which: normals and offsets by least squares, in
// units of their noise.
RigidTransform fit_to_known_pairs(const Trial& trial) {
  RigidTransform T = trial.T_model_part;
  const TrialNoise noise;
  for (int pass = 0; pass < 5; ++pass) {
    Mat6 normal = 1e-9 * Mat6::Identity();
    Vec6 right = Vec6::Zero();
    const Vec3 pivot = T * trial.measured.faces[0].point_mm;
    for (size_t k = 0; k < trial.truth.size(); ++k) {
      const auto model = std::find_if(trial.model.faces.begin(), trial.model.faces.end(),
                                      [&](const Face& face) { return face.id == trial.truth[k]; });
      if (model == trial.model.faces.end()) continue;
      const Face& seen = trial.measured.faces[k];
      const Vec3 n = T.R * seen.normal, p = T * seen.point_mm;
      Vec6 row;
      row << (p - pivot).cross(model->normal), model->normal;
      const double offset = model->normal.dot(p) - model->d_mm;
      normal += row * row.transpose() / (noise.offset_mm * noise.offset_mm);
      right -= row * offset / (noise.offset_mm * noise.offset_mm);
      for (int axis = 0; axis < 3; ++axis) {  // n + w x n = model normal
        Vec6 tilt = Vec6::Zero();
        tilt.head<3>() = n.cross(Vec3::Unit(axis));
        const double miss = model->normal[axis] - n[axis];
        normal += tilt * tilt.transpose() / (noise.normal_rad * noise.normal_rad);
        right += tilt * miss / (noise.normal_rad * noise.normal_rad);
      }
    }
    const Vec6 step = normal.ldlt().solve(right);
    const Vec3 turn = step.head<3>();
    const Mat3 R = turn.norm() > 0 ? Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix()
                                   : Mat3(Mat3::Identity());
    T = RigidTransform{R, pivot + step.tail<3>() - R * pivot} * T;
  }
  return T;
}

// Measured faces that lie on a model face in this pose, but for twice what the trial's noise does to them.
size_t faces_on_model(const Trial& trial, const RigidTransform& T) {
  const TrialNoise noise;
  return static_cast<size_t>(
      std::count_if(trial.measured.faces.begin(), trial.measured.faces.end(), [&](const Face& face) {
        const Face seen = moved(face, T);
        return std::any_of(trial.model.faces.begin(), trial.model.faces.end(), [&](const Face& at) {
          return seen.normal.dot(at.normal) >= std::cos(2 * noise.normal_rad) &&
                 std::abs(at.normal.dot(seen.point_mm) - at.d_mm) <= 2 * noise.offset_mm;
        });
      }));
}

}  // namespace

double processor_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

std::vector<RigidTransform> symmetries(const FaceList& model) {
  std::vector<Face> planes;
  for (const Face& face : model.faces)
    if (face.type == SurfaceType::plane) planes.push_back(face);
  const Box box = box_of(model);
  return exact_equivalents(model, planes, 0.5 * (box.low + box.high));
}

Trial random_trial(const std::string& part, const FaceList& model, uint64_t seed, const TrialNoise& noise) {
  Random random(seed * 0x9e3779b97f4a7c15u + 1);
  Trial trial;
  trial.name = part + " " + std::to_string(seed);
  trial.model = model;
  trial.T_model_part.R = random.rotation();
  for (int k = 0; k < 3; ++k) trial.T_model_part.t[k] = random.uniform(-100, 100);
  std::vector<Face> faces = model.faces;
  for (size_t k = faces.size(); k > 1; --k) std::swap(faces[k - 1], faces[random.below(k)]);
  const auto n = static_cast<double>(model.faces.size());
  const auto missing = static_cast<size_t>(random.uniform(0, 1) * (noise.missing * n + 1));
  faces.resize(faces.size() - std::min(missing, static_cast<size_t>(noise.missing * n)));
  for (const Face& face : faces) trial.truth.push_back(face.id);
  const Box box = box_of(model);
  const auto extra = std::min(static_cast<size_t>(random.uniform(0, 1) * (noise.extra * n + 1)),
                              static_cast<size_t>(noise.extra * n));
  for (size_t k = 0; k < extra; ++k) {
    Face face;
    face.normal = random.direction();
    for (int axis = 0; axis < 3; ++axis) face.point_mm[axis] = random.uniform(box.low[axis], box.high[axis]);
    face.area_mm2 = model.faces[random.below(model.faces.size())].area_mm2;
    faces.push_back(face);
    trial.truth.push_back(0);
  }
  const RigidTransform T_part_model = trial.T_model_part.inverse();
  for (size_t k = 0; k < faces.size(); ++k) {
    Face& face = faces[k];
    const auto [u, v] = tangent_frame(face.normal);
    const double about = random.uniform(-std::numbers::pi, std::numbers::pi);
    const double tilt = random.uniform(0, noise.normal_rad);
    face.point_mm += random.uniform(-noise.offset_mm, noise.offset_mm) * face.normal;
    face.normal = std::cos(tilt) * face.normal + std::sin(tilt) * (std::cos(about) * u + std::sin(about) * v);
    face = moved(face, T_part_model);
    face.area_mm2 *= random.uniform(1 - noise.area, 1 + noise.area);
    face.id = face.surface = static_cast<int>(k) + 1;
    face.neighbours.clear();
  }
  trial.measured.faces = std::move(faces);
  return trial;
}

TrialResult run_trial(const Trial& trial, bool with_oracle) {
  TrialResult result;
  const double start_ms = processor_ms();
  const Result<Match> match = match_face_lists(trial.model, trial.measured);
  result.time_ms = processor_ms() - start_ms;
  if (!match) {
    result.error = match.error().message;
    return result;
  }
  const Box box = box_of(trial.model);
  const Vec3 middle = 0.5 * (box.low + box.high);
  std::vector<EquivalentPose> poses = match->equivalents;
  poses.push_back({match->T_model_part, {}, match->undetermined});
  result.poses = poses.size();
  Eigen::Index free =
      static_cast<Eigen::Index>(match->undetermined.size());  // of the pose nearest to the truth
  const auto nearest = [&](const RigidTransform& truth) {
    PoseError best{10, 1e9};
    for (const EquivalentPose& pose : poses) {
      const PoseError error = pose_error(pose.T_model_part, truth, pose.undetermined, middle);
      if (std::max(error.angle_rad / kRightAngle_rad, error.shift_mm / kRightShift_mm) <
          std::max(best.angle_rad / kRightAngle_rad, best.shift_mm / kRightShift_mm)) {
        best = error;
        free = static_cast<Eigen::Index>(pose.undetermined.size());
      }
    }
    return best;
  };
  const PoseError error = nearest(trial.T_model_part);
  if (is_right(error)) result.miss = Miss::none;
  result.angle_deg = error.angle_rad * 180 / std::numbers::pi;
  result.shift_mm = error.shift_mm;
  const Eigen::Index free_at_truth = free;
  if (result.miss == Miss::fault) {
    const PoseError known = pose_error(fit_to_known_pairs(trial), trial.T_model_part,
                                       free_directions(true_normals(trial), middle), middle);
    const size_t at_truth = faces_on_model(trial, trial.T_model_part);
    const bool fits_better = std::any_of(poses.begin(), poses.end(), [&](const EquivalentPose& pose) {
      return faces_on_model(trial, pose.T_model_part) > at_truth;
    });
    if (is_right(known)) {
      if (fits_better) result.miss = Miss::chance;
    } else {
      result.miss = Miss::noise;
    }
  }
  if (!with_oracle) return result;

  std::vector<Face> seen;  // as the model has them
  for (const int id : trial.truth) {
    const auto at = std::find_if(trial.model.faces.begin(), trial.model.faces.end(),
                                 [&](const Face& face) { return face.id == id; });
    if (at != trial.model.faces.end()) seen.push_back(*at);
  }
  result.free_right = free_at_truth == free_by_brute_force(seen, middle);
  for (const RigidTransform& motion : exact_equivalents(trial.model, seen, middle))
    result.equivalents_missed += !is_right(nearest(motion * trial.T_model_part));
  return result;
}

Status write_trial(const std::filesystem::path& path, const Trial& trial, const std::string& what_failed) {
  nlohmann::ordered_json json;
  json["name"] = trial.name;
  json["failed"] = what_failed;
  json["rotation"] = nlohmann::ordered_json::array();
  for (int r = 0; r < 3; ++r)
    json["rotation"].push_back(
        {trial.T_model_part.R(r, 0), trial.T_model_part.R(r, 1), trial.T_model_part.R(r, 2)});
  json["translation_mm"] = {trial.T_model_part.t.x(), trial.T_model_part.t.y(), trial.T_model_part.t.z()};
  json["truth"] = trial.truth;
  json["model"] = faces_json(trial.model);
  json["measured"] = faces_json(trial.measured);
  return write_whole_file(path, json.dump() + "\n");
}

Result<Trial> read_trial(const std::filesystem::path& path) {
  const Result<std::string> text = read_whole_file(path);
  if (!text) return text.error();
  const Result<nlohmann::json> json = parse_json(*text, path.string());
  if (!json) return json.error();
  Trial trial;
  try {
    trial.name = json->at("name");
    trial.open = json->value("open", std::string());
    trial.truth = json->at("truth").get<std::vector<int>>();
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) trial.T_model_part.R(r, c) = json->at("rotation").at(r).at(c);
      trial.T_model_part.t[r] = json->at("translation_mm").at(r);
    }
    trial.model = faces_from_json(json->at("model"));
    trial.measured = faces_from_json(json->at("measured"));
  } catch (const std::exception& error) {
    return bad_input(path.string() + ": " + error.what());
  }
  return trial;
}

}  // namespace tetragauge::bench
