// SPDX-License-Identifier: GPL-3.0-or-later
// The whole host pipeline on simulated scans of parts whose defects are known from their drawings.
#include <algorithm>
#include <numbers>
#include <random>

#include "host/inspect/join_set_ups.hpp"
#include "host/inspect/measure_faces.hpp"
#include "host/inspect/part_pose.hpp"
#include "host/inspect/test_scans.hpp"

namespace tetragauge {
namespace {

using namespace test;

bool has_surplus(const InspectionRun& run) {
  const auto& faces = run.inspection.extra_faces;
  return std::any_of(faces.begin(), faces.end(), [](const ExtraFace& face) { return face.out_of_tolerance; });
}

TEST(Inspect, GoodPartPassesInRandomPoses) {
  const Solid model = staircase();
  const int slope = face_at(model, -Vec3(1, 0, 1).normalized(), -40 / std::sqrt(2.0));
  const int under = face_at(model, Vec3::UnitZ(), 10);
  std::mt19937_64 random(1989);
  std::uniform_real_distribution<double> angle(-180, 180), shift(-100, 100);
  for (uint64_t n = 0; n < 2; ++n) {
    View view;
    view.points = 20000;
    view.seed = n;
    view.T_scan_model = {rotation_from_degrees(angle(random), angle(random) / 2, angle(random)),
                         Vec3(shift(random), shift(random), shift(random))};
    const InspectionRun run = run_inspect(scan_of(model, view), model, profile(0.1));
    const Inspection& inspection = run.inspection;
    EXPECT_EQ(inspection.verdict, Verdict::pass) << n;
    EXPECT_EQ(run.set_ups[0].match.pairs.size(), 15u);
    EXPECT_TRUE(run.set_ups[0].match.equivalents.empty());
    EXPECT_TRUE(run.set_ups[0].match.undetermined.empty());
    EXPECT_TRUE(inspection.missing_faces.empty());
    EXPECT_TRUE(inspection.extra_faces.empty());
    const RigidTransform error = run.set_ups[0].match.T_model_part * view.T_scan_model;
    EXPECT_LT(rotation_angle(error.R), 0.02 * std::numbers::pi / 180);
    EXPECT_LT((error * model.centroid_mm - model.centroid_mm).norm(), 0.02);
    for (const FaceInspection& face : inspection.faces) {
      EXPECT_TRUE(face.measured) << face.model_id;
      // The slope and the plane above it lie under an overhang, which some of the eight views cannot look
      // under.
      const bool overhung = face.model_id == slope || face.model_id == under;
      EXPECT_GT(face.coverage, overhung ? 0.5 : 0.95) << face.model_id;
      EXPECT_LT(std::abs(face.offset_mm), 0.01) << face.model_id;
    }
    ASSERT_EQ(inspection.timing.stages_s().size(), 4u);
    EXPECT_EQ(inspection.timing.stages_s()[0].first, "reconstruct");
    EXPECT_EQ(inspection.timing.stages_s()[3].first, "inspect");
  }
}

TEST(Inspect, OneRiserOutOfPlaceIsNamed) {
  Outline outline = kStaircase;
  outline[3][0] = outline[4][0] = 60.4;  // the riser x = 60
  const Solid model = staircase(), part = solid(swept(outline, 0, 60));
  const InspectionRun run = run_inspect(scan_of(part), model, profile(0.2));
  const int riser = face_at(model, Vec3::UnitX(), 60);
  EXPECT_EQ(run.inspection.verdict, Verdict::fail);
  for (const FaceInspection& face : run.inspection.faces)
    EXPECT_EQ(face.verdict, face.model_id == riser ? Verdict::fail : Verdict::pass) << face.model_id;
  const FaceInspection& out = result(run, riser);
  EXPECT_NEAR(out.offset_mm, 0.4, three_sigma(out.U_offset_mm));
  EXPECT_LT(out.U_offset_mm, 0.01);
  EXPECT_EQ(out.decided_by->name, "profile");
  EXPECT_NEAR(out.profile_mm, 0.4, three_sigma(out.U_profile_mm));
}

TEST(Inspect, ATiltedFaceIsMeasured) {
  Outline outline = kStaircase;
  outline[4][0] = 60.2;  // the riser's upper edge leans out by 0.2 mm over 20 mm: 10 mrad
  const Solid model = staircase(), part = solid(swept(outline, 0, 60));
  const InspectionRun run = run_inspect(scan_of(part), model, profile(0.1));
  const FaceInspection& riser = result(run, face_at(model, Vec3::UnitX(), 60));
  EXPECT_EQ(riser.verdict, Verdict::fail);
  EXPECT_NEAR(riser.tilt_rad, 0.01, three_sigma(riser.U_tilt_rad));
  EXPECT_NEAR(riser.offset_mm, 0.1, three_sigma(riser.U_offset_mm));
  EXPECT_NEAR(riser.profile_mm, 0.2, three_sigma(riser.U_profile_mm));
  EXPECT_EQ(run.inspection.verdict, Verdict::fail);
}

TEST(Inspect, TwoEndsAtAWrongDistanceAreBothCandidates) {
  const Solid model = staircase(), part = solid(swept(kStaircase, 0, 60.4));
  const InspectionRun run = run_inspect(scan_of(part), model, profile(0.1));
  const int front = face_at(model, -Vec3::UnitY(), 0), back = face_at(model, Vec3::UnitY(), 60);
  EXPECT_EQ(run.inspection.verdict, Verdict::fail);
  for (const FaceInspection& face : run.inspection.faces) {
    if (face.model_id == front || face.model_id == back) {
      EXPECT_EQ(face.verdict, Verdict::fail);
      EXPECT_EQ(face.candidate_with, face.model_id == front ? back : front);
      EXPECT_NEAR(face.decided_by->deviation, 0.4, three_sigma(face.decided_by->U));
      EXPECT_LT(face.decided_by->U, 0.02);
    } else {
      EXPECT_EQ(face.verdict, Verdict::pass) << face.model_id;
    }
  }
}

TEST(Inspect, AMissingStepIsProvedAbsentByRays) {
  Outline outline = kStaircase;
  outline.erase(outline.begin() + 7, outline.begin() + 10);  // the uppermost step, z 50..60, is cut off
  outline.insert(outline.begin() + 7, {0, 50});
  const Solid model = staircase(), part = solid(swept(outline, 0, 60));
  const InspectionRun run = run_inspect(scan_of(part), model, profile(0.2));
  const int top = face_at(model, Vec3::UnitZ(), 60), riser = face_at(model, Vec3::UnitX(), 20);
  EXPECT_EQ(run.inspection.verdict, Verdict::fail);
  EXPECT_EQ(result(run, top).verdict, Verdict::fail);
  EXPECT_EQ(result(run, riser).verdict, Verdict::fail);
  std::vector<int> missing = run.inspection.missing_faces;
  std::vector<int> expected{top, riser};
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(missing, expected);
}

TEST(Inspect, WhereTheFacesEndIsNotKnownNoneIsAbsent) {
  Outline outline = kStaircase;
  outline.erase(outline.begin() + 7, outline.begin() + 10);  // the uppermost step is cut off
  outline.insert(outline.begin() + 7, {0, 50});
  const Solid model = staircase(), part = solid(swept(outline, 0, 60));
  const Scan scan = scan_of(part);
  InspectionRun run = run_inspect(scan, model, profile(0.2));
  const RayCaster caster(model);
  const auto missing = [&] {
    const JoinedScan joined = join_set_ups(std::span(&scan, 1), model, caster, run.set_ups);
    return measure_faces(joined, model, caster, face_outlines(model), best_fit(run.set_ups), profile(0.2))
        .missing;
  };
  EXPECT_EQ(missing().size(), 2u);
  // Were the pose free to shift, rays through their places would prove nothing of these faces.
  FreeDirection along;
  along.kind = FreeDirection::Kind::translation;
  along.axis = Vec3::UnitX();
  run.set_ups[0].match.undetermined.push_back(along);
  EXPECT_TRUE(missing().empty());
}

TEST(Inspect, AnExtraBossFails) {
  // A block of 12 x 20 x 6 mm on the tread z = 20.
  const std::string boss =
      "multmatrix([[1, 0, 0, 64], [0, 1, 0, 20], [0, 0, 1, 19], [0, 0, 0, 1]]) { cube(size = "
      "[12, 20, 7], center = false); }\n";
  const Solid model = staircase(), part = solid("union() {\n" + swept(kStaircase, 0, 60) + boss + "}\n");
  const InspectionRun run = run_inspect(scan_of(part), model, profile(0.2));
  EXPECT_EQ(run.inspection.verdict, Verdict::fail);
  EXPECT_TRUE(has_surplus(run));
  EXPECT_EQ(run.set_ups[0].match.pairs.size(), 15u);
  const RigidTransform error = run.set_ups[0].match.T_model_part * View{}.T_scan_model;
  EXPECT_LT((error * model.centroid_mm - model.centroid_mm).norm(), 0.02);
  for (const FaceInspection& face : run.inspection.faces)
    EXPECT_EQ(face.verdict, Verdict::pass) << face.model_id;
}

// A block with a step, so that its pose is unique; mm.
const std::string kBlock =
    "difference() { cube(size = [80, 60, 30], center = false); multmatrix([[1, 0, 0, 60], [0, 1, 0, -1], [0, "
    "0, 1, 20], "
    "[0, 0, 0, 1]]) { cube(size = [30, 30, 20], center = false); } }\n";

std::string at(double x, double y, double z, const std::string& shape) {
  return "multmatrix([[1, 0, 0, " + std::to_string(x) + "], [0, 1, 0, " + std::to_string(y) +
         "], [0, 0, 1, " + std::to_string(z) + "], [0, 0, 0, 1]]) { " + shape + " }\n";
}

TEST(Inspect, APocketAHoleOrADomeThatTheModelDoesNotHaveFails) {
  const Solid model = solid(kBlock);
  const int top = face_at(model, Vec3::UnitZ(), 30);
  struct Case {
    std::string csg;
    bool missing;
    double depth_mm;  // by the drawing; the hole's is seen from one wall to the other
  };
  const Case cases[] = {
      {"difference() { " + kBlock + at(20, 20, 26, "cube(size = [12, 12, 20], center = false);") + "}", true,
       4},
      {"difference() { " + kBlock + at(26, 26, -1, "cylinder(h = 50, r1 = 4, r2 = 4);") + "}", true, 0},
      {"union() { " + kBlock + at(26, 26, 27, "sphere(r = 6);") + "}", false, 0},
  };
  for (const Case& c : cases) {
    const InspectionRun run = run_inspect(scan_of(solid(c.csg), {.points = 20000}), model, profile(0.4));
    EXPECT_EQ(run.inspection.verdict, Verdict::fail) << c.csg;
    const auto& faults = run.inspection.material_faults;
    const auto found = std::find_if(faults.begin(), faults.end(), [&](const MaterialFault& fault) {
      return fault.face == top && fault.missing == c.missing;
    });
    ASSERT_NE(found, faults.end()) << c.csg;
    EXPECT_LT((found->point_mm - Vec3(26, 26, 30)).norm(), 3) << c.csg;
    if (c.depth_mm > 0) {
      EXPECT_NEAR(found->depth_mm, c.depth_mm, 0.05) << c.csg;
    }
  }
  // The other way about: the model has the hole, the part does not.
  const Solid with_hole =
      solid("difference() { " + kBlock + at(26, 26, -1, "cylinder(h = 50, r1 = 5, r2 = 5);") + "}");
  const InspectionRun filled = run_inspect(scan_of(model, {.points = 20000}), with_hole, profile(0.4));
  EXPECT_EQ(filled.inspection.verdict, Verdict::fail);
  EXPECT_TRUE(std::any_of(filled.inspection.material_faults.begin(), filled.inspection.material_faults.end(),
                          [](const MaterialFault& fault) { return !fault.missing; }));
  // An edge cut off by 3 mm leaves a face that the model does not have.
  const Solid chamfered =
      solid("difference() { " + kBlock +
            at(0, 0, 27,
               "multmatrix([[1, 0, 0, 0], [0, 0.70710678, -0.70710678, 0], [0, 0.70710678, "
               "0.70710678, 0], [0, 0, 0, 1]]) { multmatrix([[1, 0, 0, -1], [0, 1, 0, -1], [0, "
               "0, 1, 0], [0, 0, 0, 1]]) { cube(size = [82, 20, 20], center = false); } }") +
            "}");
  const InspectionRun cut = run_inspect(scan_of(chamfered, {.points = 20000}), model, profile(0.4));
  EXPECT_EQ(cut.inspection.verdict, Verdict::fail);
  EXPECT_TRUE(has_surplus(cut));

  const InspectionRun good = run_inspect(scan_of(model, {.points = 20000}), model, profile(0.4));
  EXPECT_EQ(good.inspection.verdict, Verdict::pass);
  EXPECT_TRUE(good.inspection.material_faults.empty());
}

TEST(Inspect, AHoleThatWasNotMadeIsAbsentAndOneThatIsCoveredIsNot) {
  const std::string with_hole =
      "difference() { " + kBlock + at(26, 26, -1, "cylinder(h = 50, r1 = 5, r2 = 5);") + "}";
  const Solid model = solid(with_hole);
  const auto hole = std::find_if(model.faces().begin(), model.faces().end(),
                                 [](const Face& face) { return face.type == SurfaceType::cylinder; });
  ASSERT_NE(hole, model.faces().end());
  const InspectionRun filled = run_inspect(scan_of(solid(kBlock), {.points = 20000}), model, profile(0.4));
  EXPECT_EQ(filled.inspection.verdict, Verdict::fail);
  EXPECT_EQ(filled.inspection.missing_faces, std::vector<int>{hole->id});
  EXPECT_EQ(result(filled, hole->id).verdict, Verdict::fail);

  // Lids of 5 mm on both its mouths: the hole may be there all the same.
  const std::string lid = "cube(size = [18, 18, 6], center = false);";
  const Solid lidded = solid("union() { " + with_hole + at(17, 17, -5, lid) + at(17, 17, 29, lid) + "}");
  const InspectionRun covered = run_inspect(scan_of(lidded, {.points = 20000}), model, profile(0.4));
  EXPECT_EQ(covered.inspection.verdict, Verdict::fail);  // for the lids
  EXPECT_TRUE(covered.inspection.missing_faces.empty());
  EXPECT_EQ(result(covered, hole->id).verdict, Verdict::not_measured);
}

TEST(Inspect, NoiseAcrossAFlatEdgeIsNoMaterial) {
  // A flat on a shaft meets it at 46 degrees: noise of 0.3 mm carries points of either over the edge.
  const Solid model =
      solid("difference() { cylinder($fn = 0, $fa = 12, $fs = 2, h = 40, r1 = 10, r2 = 10); " +
            at(7, -20, 15, "cube(size = [40, 40, 40], center = false);") + "}");
  for (const uint64_t seed : {uint64_t{1}, uint64_t{2}}) {
    const Scan scan = scan_of(model, {.points = 5000, .sigma_mm = 0.3, .seed = seed});
    const InspectionRun run = run_inspect(scan, model, profile(0.2));
    EXPECT_NE(run.inspection.verdict, Verdict::fail) << seed;
    EXPECT_TRUE(run.inspection.material_faults.empty()) << seed;
  }
}

TEST(Inspect, AFaceNobodySawIsNeverAPass) {
  const Solid model = staircase();
  const int bottom = face_at(model, -Vec3::UnitZ(), 0), left = face_at(model, -Vec3::UnitX(), 0);
  const Scan scan = scan_of(model);
  const RigidTransform T_model_scan = View{}.T_scan_model.inverse();
  const Scan part = points_of(scan, [&](size_t i) {
    const Vec3 p = T_model_scan * scan.points[i];
    const bool on_bottom = p.z() < 0.5;
    const bool on_two_thirds_of_the_upper_left = p.x() < 0.5 && p.z() > 40 && p.y() > 20;
    return !on_bottom && !on_two_thirds_of_the_upper_left;
  });
  const InspectionRun run = run_inspect(part, model, profile(0.2));
  EXPECT_EQ(run.inspection.verdict, Verdict::not_measured);
  EXPECT_EQ(result(run, bottom).verdict, Verdict::not_measured);
  EXPECT_TRUE(run.inspection.missing_faces.empty());
  int too_little = 0;
  for (const FaceInspection& face : run.inspection.faces) {
    if (face.model_id == bottom) continue;
    if (model.faces()[static_cast<size_t>(face.model_id) - 1].surface ==
            model.faces()[static_cast<size_t>(left) - 1].surface &&
        face.coverage < 0.5) {
      ++too_little;
      EXPECT_EQ(face.verdict, Verdict::not_measured);
      EXPECT_NEAR(face.coverage, 1.0 / 3, 0.08);
    } else {
      EXPECT_EQ(face.verdict, Verdict::pass) << face.model_id;
    }
  }
  EXPECT_EQ(too_little, 1);
  // Skipped faces do not count.
  Tolerances skipping = profile(0.2);
  for (const FaceInspection& face : run.inspection.faces)
    if (face.verdict == Verdict::not_measured) skipping.skip.insert(face.model_id);
  const InspectionRun again = run_inspect(part, model, skipping);
  EXPECT_EQ(again.inspection.verdict, Verdict::pass);
  EXPECT_EQ(result(again, bottom).verdict, Verdict::skipped);
}

TEST(Inspect, WithoutTolerancesThereIsNoVerdict) {
  View view;
  view.points = 5000;
  const Solid model = staircase();
  const InspectionRun run = run_inspect(scan_of(model, view), model, {});
  EXPECT_EQ(run.inspection.verdict, Verdict::none);
  for (const FaceInspection& face : run.inspection.faces) EXPECT_EQ(face.verdict, Verdict::none);
}

TEST(Inspect, ABoreIsComparedPointByPoint) {
  const auto block = [](double radius) {
    return "difference() { cube(size = [60, 50, 20], center = false); multmatrix([[1, 0, 0, 20], [0, 1, 0, "
           "20], [0, 0, 1, "
           "-1], [0, 0, 0, 1]]) { cylinder($fn = 0, $fa = 12, $fs = 2, h = 22, r1 = " +
           std::to_string(radius) + ", r2 = " + std::to_string(radius) + ", center = false); } }\n";
  };
  const Solid model = solid(block(12)), part = solid(block(12.2));
  const InspectionRun run = run_inspect(scan_of(part), model, profile(0.2));
  int bores = 0;
  for (size_t k = 0; k < model.faces().size(); ++k) {
    const FaceInspection& face = run.inspection.faces[k];
    if (model.faces()[k].type == SurfaceType::plane) {
      EXPECT_EQ(face.verdict, Verdict::pass) << face.model_id;
      continue;
    }
    ++bores;
    EXPECT_TRUE(face.measured);
    EXPECT_NEAR(face.offset_mm, -0.2, three_sigma(face.U_offset_mm));  // material is missing
    EXPECT_NEAR(face.point_mean_mm, -0.2, 0.01);
    ASSERT_TRUE(face.radius_mm.has_value());
    EXPECT_NEAR(*face.radius_mm, 0.2, three_sigma(face.U_radius_mm));
    EXPECT_LT(face.U_radius_mm, 0.02);
    EXPECT_NEAR(face.position_mm.value_or(1), 0, three_sigma(face.U_position_mm));
    EXPECT_EQ(face.verdict, Verdict::fail);
  }
  EXPECT_GE(bores, 1);
  EXPECT_EQ(run.inspection.verdict, Verdict::fail);
}

TEST(Inspect, SetUpsAreJudgedTogether) {
  // Seen from above in one set-up and from below in the other: neither sees all of the part.
  const Solid model = staircase();
  const auto seen_along = [&](const Vec3& from, const RigidTransform& T_scan_model, uint64_t seed) {
    View view;
    view.points = 16000;
    view.seed = seed;
    view.T_scan_model = T_scan_model;
    const Scan whole = scan_of(model, view);
    return points_of(
        whole, [&](size_t i) { return from.dot(T_scan_model.R.transpose() * -whole.ray_direction(i)) >= 0; });
  };
  const std::vector<Scan> scans{
      seen_along(Vec3::UnitZ(), {rotation_from_degrees(0, 0, 0), Vec3(0, 0, 0)}, 1),
      seen_along(-Vec3::UnitZ(), {rotation_from_degrees(180, 10, 40), Vec3(30, -20, 60)}, 2)};
  EXPECT_EQ(run_inspect(scans[0], model, profile(0.1)).inspection.verdict, Verdict::not_measured);
  EXPECT_EQ(run_inspect(scans[1], model, profile(0.1)).inspection.verdict, Verdict::not_measured);
  const Result<InspectionRun> together = inspect(scans, model, profile(0.1));
  ASSERT_TRUE(together.ok()) << together.error().message;
  EXPECT_EQ(together->inspection.verdict, Verdict::pass);
  ASSERT_EQ(together->set_ups.size(), 2u);
  EXPECT_EQ(together->inspection.point_face.size(), scans[0].size() + scans[1].size());
  for (const FaceInspection& face : together->inspection.faces) {
    EXPECT_TRUE(face.measured) << face.model_id;
    EXPECT_LT(std::abs(face.offset_mm), 2 * face.U_offset_mm) << face.model_id;
  }
  // A datum seen in one of them holds the faces of both.
  Tolerances held = profile(0.1);
  held.datums = {{"A", face_at(model, -Vec3::UnitZ(), 0), -Vec3::UnitZ()}};
  const Result<InspectionRun> on_datum = inspect(scans, model, held);
  ASSERT_TRUE(on_datum.ok()) << on_datum.error().message;
  EXPECT_EQ(on_datum->inspection.alignment.datums.size(), 1u);
  EXPECT_EQ(on_datum->inspection.verdict, Verdict::pass);
}

TEST(Inspect, UncertaintyHoldsTheTruth) {
  // On a perfect part every offset is error: |offset| > U (k = 2) in at most 5 % of the faces, and U not far
  // larger.
  const Solid model = staircase();
  int beyond = 0, faces = 0;
  double mean_square = 0;  // of offset in standard uncertainties
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    View view;
    view.points = 4000;
    view.seed = seed;
    const InspectionRun run = run_inspect(scan_of(model, view), model, {});
    for (const FaceInspection& face : run.inspection.faces) {
      ++faces;
      beyond += std::abs(face.offset_mm) > face.U_offset_mm;
      mean_square += std::pow(2 * face.offset_mm / face.U_offset_mm, 2);
    }
  }
  EXPECT_EQ(faces, 12 * 15);
  EXPECT_LE(beyond, 16);  // 9 expected, standard deviation 3
  EXPECT_GT(mean_square / faces, 0.3);
  EXPECT_LT(mean_square / faces, 1.4);
}

}  // namespace
}  // namespace tetragauge
