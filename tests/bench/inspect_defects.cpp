// SPDX-License-Identifier: GPL-3.0-or-later
// Parts with one known defect, scanned in random poses and inspected with profile_mm 0.1 (limits +- 0.05 mm):
// is the right face named, is the amount right within U, is nothing passed that is out, nothing failed that
// is good?
#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <optional>
#include <random>
#include <set>

#include "host/inspect/inspect.hpp"
#include "host/simulate/simulate.hpp"

namespace tetragauge {
namespace {

constexpr double kLimit_mm = 0.05;
constexpr double kDegree = std::numbers::pi / 180;

using Point2 = Eigen::Vector2d;

// None is symmetric, so that every face can be named. A polygon in (x, z), counter-clockwise seen from -y,
// swept over y = 0 .. depth; mm.
struct Prism {
  const char* name;
  std::vector<Point2> outline;
  double depth_mm;
};

const std::vector<Prism>& prisms() {
  static const std::vector<Prism> parts{
      {"staircase of the thesis",
       {{0, 0},
        {80, 0},
        {80, 20},
        {60, 20},
        {60, 40},
        {40, 40},
        {40, 50},
        {20, 50},
        {20, 60},
        {0, 60},
        {0, 40},
        {30, 10},
        {0, 10}},
       60},
      {"bracket", {{0, 0}, {80, 0}, {80, 14}, {16, 14}, {16, 52}, {0, 52}}, 50},
      {"wedge", {{0, 0}, {75, 0}, {75, 12}, {0, 48}}, 55},
      {"rail with a dovetail",
       {{0, 0}, {90, 0}, {90, 40}, {62, 40}, {70, 18}, {30, 18}, {38, 40}, {0, 40}},
       60},
      {"roof", {{0, 0}, {70, 0}, {70, 30}, {42, 52}, {0, 30}}, 64}};
  return parts;
}

constexpr int kFront = -1, kBack = -2;  // the ends y = 0 and y = depth

struct Defect {
  int face = 0;           // edge of the outline, or an end
  double moved_mm = 0;    // outwards
  double tilted_rad = 0;  // about the middle of the edge
};

Point2 outward(const Point2& a, const Point2& b) {
  const Point2 along = (b - a).normalized();
  return {along.y(), -along.x()};
}

// Where the lines a + s u and b + t v meet; nothing where they are parallel.
std::optional<Point2> meeting(const Point2& a, const Point2& u, const Point2& b, const Point2& v) {
  const double across = u.x() * v.y() - u.y() * v.x();
  if (std::abs(across) < 1e-6) return std::nullopt;
  const Point2 d = b - a;
  return Point2(a + u * ((d.x() * v.y() - d.y() * v.x()) / across));
}

std::optional<Prism> with_defect(const Prism& part, const Defect& defect) {
  Prism made = part;
  if (defect.face < 0) {
    made.depth_mm += defect.moved_mm;  // the front end: the sweep is shifted in csg_of
    return made;
  }
  const size_t n = part.outline.size(), k = static_cast<size_t>(defect.face);
  const auto corner = [&](size_t i) { return part.outline[i % n]; };
  const Point2 a = corner(k), b = corner(k + 1), normal = outward(a, b);
  const Eigen::Rotation2Dd turn(defect.tilted_rad);
  const Point2 middle = 0.5 * (a + b) + defect.moved_mm * normal, along = turn * (b - a);
  const auto start = meeting(middle, along, corner(k + n - 1), a - corner(k + n - 1));
  const auto end = meeting(middle, along, b, corner(k + 2) - b);
  if (!start || !end) return std::nullopt;
  made.outline[k] = *start;
  made.outline[(k + 1) % n] = *end;
  return made;
}

std::string csg_of(const Prism& part, double front_mm) {
  std::string points;
  for (const Point2& p : part.outline) {
    std::array<char, 80> text{};
    std::snprintf(text.data(), text.size(), "%s[%.9f, %.9f]", points.empty() ? "" : ", ", p.x(), p.y());
    points += text.data();
  }
  std::array<char, 200> head{};
  std::snprintf(
      head.data(), head.size(),
      "multmatrix([[1, 0, 0, 0], [0, 0, -1, %.9f], [0, 1, 0, 0], [0, 0, 0, 1]]) { linear_extrude(height = "
      "%.9f, scale = [1, 1]) { polygon(points = [",
      front_mm + part.depth_mm, part.depth_mm);
  return head.data() + points + "], paths = undef); } }\n";
}

Solid solid_of(const std::string& csg) {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() /
      ("tetragauge_defects_" + std::to_string(std::random_device{}()) + ".csg");
  std::ofstream(path, std::ios::binary) << csg;
  Result<Solid> solid = read_solid(path);
  std::filesystem::remove(path);
  if (!solid) {
    std::fprintf(stderr, "%s\n", solid.error().message.c_str());
    std::exit(70);
  }
  return std::move(solid).value();
}

Solid solid_with(const Prism& part, const Defect& defect, const Prism& made) {
  return solid_of(csg_of(made, part.depth_mm > 0 && defect.face == kFront ? -defect.moved_mm : 0));
}

// The model's face on an edge of the outline, or an end.
const Face& face_on(const Solid& model, const Prism& part, int face) {
  Vec3 middle(0, face == kBack ? part.depth_mm : 0, 0), normal(0, face == kBack ? 1 : -1, 0);
  if (face >= 0) {
    const size_t n = part.outline.size(), k = static_cast<size_t>(face);
    const Point2 a = part.outline[k], b = part.outline[(k + 1) % n], out = outward(a, b);
    middle = {0.5 * (a.x() + b.x()), 0.5 * part.depth_mm, 0.5 * (a.y() + b.y())};
    normal = {out.x(), 0, out.y()};
  }
  const Face* nearest = nullptr;
  for (const Face& candidate : model.faces()) {
    if (candidate.normal.dot(normal) < 0.999) continue;
    if (face < 0) return candidate;
    if (!nearest || (candidate.point_mm - middle).norm() < (nearest->point_mm - middle).norm())
      nearest = &candidate;
  }
  return *nearest;
}

// Nothing but one opposed face holds the part along this face's normal: which of the two moved cannot be
// told.
const Face* lone_opposite(const Solid& model, const Face& face) {
  const Face* opposite = nullptr;
  for (const Face& other : model.faces()) {
    if (other.id == face.id || std::abs(other.normal.dot(face.normal)) < 0.999) continue;
    if (opposite || other.normal.dot(face.normal) > 0) return nullptr;
    opposite = &other;
  }
  if (!opposite) return nullptr;
  // A slanted face holds the part along the normals of others too.
  for (const Face& other : model.faces()) {
    const double cosine = std::abs(other.normal.dot(face.normal));
    if (cosine > 0.01 && cosine < 0.999) return nullptr;
  }
  return opposite;
}

struct Setting {
  size_t points = 20000;
  double sigma_mm = 0.03;
};

InspectionRun inspected(const Solid& part, const Solid& model, const Tolerances& tolerances, uint64_t seed,
                        const Setting& setting) {
  std::mt19937_64 random(seed);
  const auto even = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1.0p-53;
  };
  SimulateOptions options;
  options.points = setting.points;
  options.sigma_mm = setting.sigma_mm;
  options.seed = seed;
  options.T_scan_model = {rotation_from_degrees(even(-180, 180), even(-90, 90), even(-180, 180)),
                          Vec3(even(-100, 100), even(-100, 100), even(-100, 100))};
  Result<Scan> scan = simulate(part, RayCaster(part), options);
  if (!scan) {
    std::fprintf(stderr, "%s\n", scan.error().message.c_str());
    std::exit(70);
  }
  Result<InspectionRun> run = inspect(*scan, model, tolerances);
  if (!run) {
    std::fprintf(stderr, "%s\n", run.error().message.c_str());
    std::exit(70);
  }
  return std::move(run).value();
}

Tolerances profile_tolerance() {
  Tolerances tolerances;
  tolerances.given = true;
  tolerances.by_default.profile_mm = 2 * kLimit_mm;
  return tolerances;
}

struct Tally {
  int runs = 0;
  int named = 0, beyond = 0;           // of those clearly beyond the limit, failed with the right face alone
  int undecided = 0, in_band = 0;      // of those within U of the limit, not decided
  int passed = 0, within = 0;          // of those clearly within, passed
  int right = 0, amounts = 0;          // amounts that hold the truth within U
  int wrong_pass = 0, wrong_fail = 0;  // beyond limit + 2 U passed; a good face or a face within failed

  void add(const Tally& other) {
    runs += other.runs;
    named += other.named;
    beyond += other.beyond;
    undecided += other.undecided;
    in_band += other.in_band;
    passed += other.passed;
    within += other.within;
    right += other.right;
    amounts += other.amounts;
    wrong_pass += other.wrong_pass;
    wrong_fail += other.wrong_fail;
  }
};

void head() {
  std::printf("%-44s %5s %12s %12s %12s %12s %6s %6s\n", "", "runs", "named", "undecided", "passed",
              "within U", "wrong", "false");
  std::printf("%-44s %5s %12s %12s %12s %12s %6s %6s\n", "", "", "of beyond", "of in band", "of within",
              "of amounts", "pass", "alarm");
}

void line(const std::string& what, const Tally& t) {
  const auto share = [](int part, int all) {
    return all > 0 ? std::to_string(part) + "/" + std::to_string(all) : std::string("-");
  };
  std::printf("%-44s %5d %12s %12s %12s %12s %6d %6d\n", what.c_str(), t.runs,
              share(t.named, t.beyond).c_str(), share(t.undecided, t.in_band).c_str(),
              share(t.passed, t.within).c_str(), share(t.right, t.amounts).c_str(), t.wrong_pass,
              t.wrong_fail);
  std::fflush(stdout);
}

// One run's result against what was made.
Tally judge(const InspectionRun& run, const Solid& model, const Prism& part, const Defect& defect,
            bool is_held, uint64_t seed) {
  const Face& face = face_on(model, part, defect.face);
  const Face* opposite = is_held || defect.tilted_rad != 0 ? nullptr : lone_opposite(model, face);
  const FaceInspection& found = run.inspection.faces[static_cast<size_t>(face.id) - 1];
  std::set<int> failed;
  for (const FaceInspection& other : run.inspection.faces)
    if (other.verdict == Verdict::fail) failed.insert(other.model_id);

  double true_mm = std::abs(defect.moved_mm), U_mm = found.U_profile_mm, limit_mm = kLimit_mm;
  std::set<int> expected{face.id};
  Tally tally;
  tally.runs = tally.amounts = 1;
  double distance_mm = 0;
  if (opposite) {
    // Their limits add up; the distance has a U of its own.
    expected.insert(opposite->id);
    limit_mm = 2 * kLimit_mm;
    for (const FaceRelation& relation : run.inspection.relations) {
      if (std::set<int>{relation.first, relation.second} != expected) continue;
      U_mm = relation.U_distance_mm;
      distance_mm = relation.distance_deviation_mm;
      tally.right = std::abs(relation.distance_deviation_mm - defect.moved_mm) <= relation.U_distance_mm;
    }
  } else if (defect.tilted_rad != 0) {
    double half_mm = 0;
    if (defect.face >= 0) {
      const size_t n = part.outline.size(), k = static_cast<size_t>(defect.face);
      half_mm = 0.5 * (part.outline[(k + 1) % n] - part.outline[k]).norm();
    }
    true_mm = std::tan(std::abs(defect.tilted_rad)) * half_mm;
    tally.right = std::abs(found.tilt_rad - std::abs(defect.tilted_rad)) <= found.U_tilt_rad;
  } else {
    tally.right = std::abs(found.offset_mm - defect.moved_mm) <= found.U_offset_mm;
  }
  // What is measured scatters by U about the truth, and U stands about the measured value: clear is 2 U.
  if (true_mm > limit_mm + 2 * U_mm) {
    tally.beyond = 1;
    tally.named = failed == expected && run.inspection.verdict == Verdict::fail;
    tally.wrong_pass = run.inspection.verdict == Verdict::pass;
  } else if (opposite && true_mm < limit_mm - 2 * U_mm && true_mm > kLimit_mm - U_mm) {
    // Too much if one of the two has moved alone, within their limits if they share it.
    tally.in_band = 1;
    tally.undecided = run.inspection.verdict == Verdict::undecided;
  } else if (true_mm < limit_mm - 2 * U_mm) {
    tally.within = 1;
    tally.passed = run.inspection.verdict == Verdict::pass;
    tally.wrong_fail = run.inspection.verdict == Verdict::fail;
  } else if (std::abs(true_mm - limit_mm) < 0.5 * U_mm) {
    tally.in_band = 1;
    tally.undecided = run.inspection.verdict == Verdict::undecided;
  }
  if ((tally.beyond && !tally.named) || !tally.right) {
    std::string ids;
    for (const int id : failed) ids += " " + std::to_string(id);
    std::fprintf(
        stderr,
        "%s, face %d moved %.3f mm tilted %.2f degrees: failed are%s; offset %.4f +- %.4f mm, tilt %.4f +- "
        "%.4f mrad, distance %.4f, U %.4f mm, seed %llu\n",
        part.name, face.id, defect.moved_mm, defect.tilted_rad / kDegree, ids.c_str(), found.offset_mm,
        found.U_offset_mm, 1e3 * found.tilt_rad, 1e3 * found.U_tilt_rad, distance_mm, U_mm,
        static_cast<unsigned long long>(seed));
  }
  return tally;
}

// Every `step`-th of all faces x amounts of one kind, over all parts.
Tally moved_or_tilted(const std::vector<Defect>& amounts, int step, const Setting& setting, int& counter) {
  Tally tally;
  for (const Prism& part : prisms()) {
    const Solid model = solid_of(csg_of(part, 0));
    for (int face = kBack; face < static_cast<int>(part.outline.size()); ++face) {
      for (Defect defect : amounts) {
        if (counter++ % step != 0) continue;
        if (face < 0 && defect.tilted_rad != 0) continue;
        defect.face = face;
        const std::optional<Prism> made = with_defect(part, defect);
        if (!made) continue;
        const auto seed = static_cast<uint64_t>(counter);
        tally.add(judge(inspected(solid_with(part, defect, *made), model, profile_tolerance(), seed, setting),
                        model, part, defect, false, seed));
      }
    }
  }
  return tally;
}

// One of two opposing faces alone in their direction is moved; held by datums, the other one among them.
Tally held_by_datums(int step, const Setting& setting, int& counter) {
  Tally tally;
  for (const Prism& part : prisms()) {
    const Solid model = solid_of(csg_of(part, 0));
    Tolerances tolerances = profile_tolerance();
    const int sideways = static_cast<int>(part.outline.size()) - 1;
    const Face &a = face_on(model, part, 0), &b = face_on(model, part, sideways),
               &c = face_on(model, part, kFront);
    tolerances.datums = {{"A", a.id, a.normal}, {"B", b.id, b.normal}, {"C", c.id, c.normal}};
    for (const double moved : {0.1, -0.1, 0.2, -0.2, 0.3, -0.3}) {
      if (counter++ % step != 0) continue;
      const Defect defect{kBack, moved, 0};
      const Prism made = *with_defect(part, defect);
      const auto seed = static_cast<uint64_t>(counter);
      tally.add(judge(inspected(solid_with(part, defect, made), model, tolerances, seed, setting), model,
                      part, defect, true, seed));
    }
  }
  return tally;
}

Tally good_parts(int runs, const Setting& setting) {
  Tally tally;
  for (int k = 0; k < runs; ++k) {
    const Prism& part = prisms()[static_cast<size_t>(k) % prisms().size()];
    const Solid model = solid_of(csg_of(part, 0));
    const InspectionRun run =
        inspected(model, model, profile_tolerance(), 1000 + static_cast<uint64_t>(k), setting);
    Tally one;
    one.runs = 1;
    // From some sides the slope under the staircase's overhang is hardly seen: rightly no pass, and no alarm.
    one.within = run.inspection.verdict != Verdict::not_measured;
    one.passed = run.inspection.verdict == Verdict::pass;
    one.wrong_fail = run.inspection.verdict == Verdict::fail;
    if (!one.passed)
      std::fprintf(stderr, "%s, good, run %d: %s\n", part.name, k,
                   std::string(verdict_name(run.inspection.verdict)).c_str());
    tally.add(one);
  }
  return tally;
}

// What is wrong is a feature, not a face: the verdict and what it names.
Tally features(const Setting& setting) {
  const auto at = [](double x, double y, double z, double turn_deg, const std::string& body) {
    const double c = std::cos(turn_deg * kDegree), s = std::sin(turn_deg * kDegree);
    std::array<char, 240> text{};
    std::snprintf(
        text.data(), text.size(),
        "multmatrix([[%.12f, %.12f, 0, %.6f], [%.12f, %.12f, 0, %.6f], [0, 0, 1, %.6f], [0, 0, 0, 1]]) { ", c,
        -s, x, s, c, y, z);
    return text.data() + body + " }\n";
  };
  const std::string slab = "cube(size = [90, 70, 24], center = false);\n";
  const std::string step = at(0, 0, 20, 0, "cube(size = [30, 70, 18], center = false);");
  const auto pocket = [&](double turn_deg) {
    return at(62, 35, 8, turn_deg, at(-14, -11, 0, 0, "cube(size = [28, 22, 30], center = false);"));
  };
  const auto body = [&](const std::string& more, double turn_deg, bool has_step) {
    return "difference() { union() { " + slab + (has_step ? step : "") + more + "} " + pocket(turn_deg) +
           "}\n";
  };
  const Solid model = solid_of(body("", 0, true));
  Tally tally;
  const auto check = [&](const char* what, const std::string& csg, const auto& is_named) {
    const InspectionRun run = inspected(solid_of(csg), model, profile_tolerance(), 77, setting);
    Tally one;
    one.runs = one.beyond = 1;
    one.named = run.inspection.verdict == Verdict::fail && is_named(run);
    one.wrong_pass = run.inspection.verdict == Verdict::pass;
    if (!one.named) std::fprintf(stderr, "%s: not named\n", what);
    tally.add(one);
  };
  const auto faces_within = [&](const Vec3& low, const Vec3& high) {
    std::set<int> ids;
    for (const Face& face : model.faces())
      if ((face.point_mm - low).minCoeff() > 0 && (high - face.point_mm).minCoeff() > 0) ids.insert(face.id);
    return ids;
  };
  check("a missing step", body("", 0, false), [&](const InspectionRun& run) {
    const auto& missing = run.inspection.missing_faces;
    return std::set<int>(missing.begin(), missing.end()) == faces_within({25, 0, 24.1}, {35, 70, 38}) ||
           std::set<int>(missing.begin(), missing.end()) == faces_within({0.1, 0, 24.1}, {35, 70, 38.1});
  });
  check("an extra boss", body(at(40, 8, 20, 0, "cube(size = [14, 10, 12], center = false);"), 0, true),
        [](const InspectionRun& run) {
          const auto& extra = run.inspection.extra_faces;
          return std::any_of(extra.begin(), extra.end(), [](const ExtraFace& face) {
            return face.out_of_tolerance && face.face.point_mm.x() > 39 && face.face.point_mm.x() < 55;
          });
        });
  check("a hole block turned by 2 degrees", body("", 2, true), [&](const InspectionRun& run) {
    const std::set<int> walls = faces_within({45, 20, 8.1}, {80, 50, 23.9});
    for (const SetUp& set_up : run.set_ups) {
      for (const MisplacedFeature& feature : set_up.match.misplaced) {
        std::set<int> ids;
        for (const FaceIds& pair : feature.pairs) ids.insert(pair.model);
        if (std::includes(ids.begin(), ids.end(), walls.begin(), walls.end()) &&
            std::abs(feature.turn_rad / kDegree - 2) < 0.1)
          return walls.size() == 4;
      }
    }
    return false;
  });
  return tally;
}

}  // namespace
}  // namespace tetragauge

int main(int argc, char** argv) {
  using namespace tetragauge;
  CLI::App app{"Parts with one known defect: right face named, amount right within U, no false alarm"};
  Setting setting;
  int step = 1, good = 200;
  app.add_option("--every", step, "Every N-th of all defects (1: all)")->check(CLI::PositiveNumber);
  app.add_option("--good", good, "Scans of good parts");
  app.add_option("--points", setting.points, "Points of a scan");
  app.add_option("--sigma", setting.sigma_mm, "Along the ray, mm");
  CLI11_PARSE(app, argc, argv);

  std::printf("profile_mm 0.1 (limits +- 0.05 mm), %zu points, sigma %.3f mm\n", setting.points,
              setting.sigma_mm);
  head();
  int counter = 0;
  Tally all;
  const auto show = [&](const std::string& what, const Tally& tally) {
    line(what, tally);
    all.add(tally);
  };
  for (const double moved : {0.05, 0.1, 0.2, 0.3}) {
    std::array<char, 60> what{};
    std::snprintf(what.data(), what.size(), "one face moved by +- %.2f mm", moved);
    show(what.data(), moved_or_tilted({{0, moved, 0}, {0, -moved, 0}}, step, setting, counter));
  }
  for (const double tilted : {0.1, 0.3, 1.0}) {
    std::array<char, 60> what{};
    std::snprintf(what.data(), what.size(), "one face tilted by +- %.1f degrees", tilted);
    show(what.data(),
         moved_or_tilted({{0, 0, tilted * kDegree}, {0, 0, -tilted * kDegree}}, step, setting, counter));
  }
  show("an end moved, held by datums A, B, C", held_by_datums(step, setting, counter));
  show("missing step, extra boss, turned hole block", features(setting));
  show("good parts", good_parts(good, setting));
  line("all", all);
  // U is at k = 2: 95 % of the amounts; of n draws three standard deviations fewer are no chance.
  const double least = 0.95 * all.amounts - 3 * std::sqrt(0.95 * 0.05 * all.amounts);
  const bool is_good = all.named == all.beyond && all.passed == all.within && all.wrong_pass == 0 &&
                       all.wrong_fail == 0 && all.right >= least;
  return is_good ? 0 : 1;
}
