// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/report/report.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "host/base/whole_file.hpp"
#include "host/inspect/decide.hpp"
#include "host/report/deviation_ply.hpp"
#include "host/report/json_values.hpp"

namespace tetragauge {
namespace {

namespace fs = std::filesystem;

// A made-up run with one face of every verdict, an extra face, an equivalent pose and a free direction.
struct Made {
  Scan scan;
  Solid model;
  Tolerances tolerances;
  InspectionRun run;
  ReportInput input;

  Made() {
    tolerances.given = true;
    tolerances.by_default.profile_mm = 0.2;
    tolerances.skip = {5};
    const Verdict verdicts[] = {Verdict::pass, Verdict::fail, Verdict::undecided, Verdict::not_measured,
                                Verdict::skipped};
    Inspection& inspection = run.inspection;
    inspection.rule = "guarded";
    for (int k = 0; k < 5; ++k) {
      Face face;
      face.id = face.surface = k + 1;
      face.type = k == 2 ? SurfaceType::cylinder : SurfaceType::plane;
      face.normal = Vec3::UnitZ();
      face.area_mm2 = 100;
      model.list.faces.push_back(face);
      FaceInspection in;
      in.model_id = k + 1;
      in.verdict = verdicts[k];
      if (k < 3) {
        in.measured = true;
        in.coverage = 0.98;
        in.points_used = 1234;
        in.offset_mm = k == 1 ? 0.4 : -0.0;
        in.U_offset_mm = 0.02;
        in.profile_mm = in.offset_mm;
        in.criterion = "profile";
        in.deviation_mm = in.offset_mm;
        in.U_mm = 0.02;
        in.limit_mm = 0.1;
      } else {
        in.reason = "not seen: 3 points";
      }
      inspection.faces.push_back(in);
    }
    inspection.verdict = judge_part(inspection, model, tolerances);
    inspection.match.pairs = {{1, 1, 0.0, 0.0, true}, {2, 2, 0.4, 0.0, false}};
    inspection.match.unmatched_model = {3, 4, 5};
    inspection.match.unmatched_measured = {3};
    inspection.match.equivalents = {{RigidTransform{rotation_from_degrees(0, 0, 180), Vec3(1, 2, 3)},
                                     std::string(150, 'w') + " long words and " + std::string(40, 'x')}};
    inspection.match.undetermined = {{FreeDirection::Kind::translation, Vec3::UnitY(), Vec3::Zero()}};
    inspection.extra_faces = {3};
    inspection.missing_faces = {4};
    for (int k = 0; k < 3; ++k) {
      Face face;
      face.id = k + 1;
      face.normal = Vec3::UnitX();
      face.area_mm2 = 50;
      run.measured.list.faces.push_back(face);
    }
    for (int k = 0; k < 4; ++k) {
      scan.points.emplace_back(k, 2 * k, 0.5);
      scan.ray_origins.emplace_back(0, 0, 100);
      scan.sigma_mm.push_back(0.02f);
      inspection.point_deviation_mm.push_back(0.1f * static_cast<float>(k - 1));
      inspection.point_face.push_back(k);
    }
    input = {"scan.ply",           std::string(64, 'a'), "model.step",
             std::string(64, 'b'), "tolerances.json",    std::string(64, 'c')};
  }
};

fs::path folder() {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  return fs::path(testing::TempDir()) / (std::string("tetragauge_report_") + info->name());
}

TEST(Report, JsonKeepsToItsSchema) {
  const Made made;
  const fs::path out = folder();
  ASSERT_TRUE(write_report(out, made.run, made.scan, made.model, made.tolerances, made.input).ok());
  const std::string schema = std::string(TETRAGAUGE_SOURCE_DIR) + "/host/report/report.schema.json";
  const std::string script =
      "import json, sys, jsonschema; jsonschema.Draft202012Validator(json.load(open(sys.argv[1]))).validate("
      "json.load(open(sys.argv[2])))";
  const auto validates = [&](const fs::path& report) {
    return std::system(
               ("/usr/bin/python3 -c '" + script + "' '" + schema + "' '" + report.string() + "' 2>/dev/null")
                   .c_str()) == 0;
  };
  EXPECT_TRUE(validates(out / "report.json"));
  // The check can fail: an unknown key, and a wrong type.
  Result<std::string> text = read_whole_file(out / "report.json");
  ASSERT_TRUE(text.ok());
  nlohmann::ordered_json json = nlohmann::ordered_json::parse(*text);
  json["surprise"] = 1;
  std::ofstream(out / "wrong.json") << json.dump();
  EXPECT_FALSE(validates(out / "wrong.json"));
  json.erase("surprise");
  json["faces"][0]["verdict"] = "good";
  std::ofstream(out / "wrong.json") << json.dump();
  EXPECT_FALSE(validates(out / "wrong.json"));
  fs::remove_all(out);
}

TEST(Report, JsonHoldsTheRun) {
  const Made made;
  const auto json = report_json(made.run, made.scan, made.model, made.tolerances, made.input);
  EXPECT_EQ(json["verdict"], "fail");
  ASSERT_EQ(json["faces"].size(), 5u);
  EXPECT_EQ(json["faces"][1]["deviations"]["offset_mm"], 0.4);
  EXPECT_EQ(json["faces"][1]["U_mm"]["offset"], 0.02);
  EXPECT_EQ(json["faces"][1]["tolerance"]["profile_mm"], 0.2);
  EXPECT_EQ(json["faces"][4]["verdict"], "skipped");
  EXPECT_TRUE(json["faces"][3]["deviations"].empty());
  EXPECT_EQ(json["extra_faces"].size(), 1u);
  EXPECT_EQ(json["undetermined"][0]["kind"], "translation");
  const std::string text = json.dump();
  EXPECT_EQ(text.find("-0.0"), std::string::npos);
  EXPECT_EQ(text.find("null"), std::string::npos);
  EXPECT_EQ(match_json(made.run.inspection.match, "search")["pairs"], json["pairs"]);
}

TEST(Report, NumbersAreNeverNanOrMinusZero) {
  EXPECT_EQ(json_number(-0.0).dump(), "0.0");
  EXPECT_EQ(json_number(std::numeric_limits<double>::quiet_NaN()).dump(), "null");
  EXPECT_EQ(json_number(0.1).dump(), "0.1");
}

TEST(Report, TextSaysTheVerdictFirstAndFits100Columns) {
  Made made;
  const auto text = [&] { return report_text(made.run, made.scan, made.model, made.tolerances, made.input); };
  const auto first_line = [&] { return text().substr(0, text().find('\n')); };
  EXPECT_EQ(first_line(), "FAIL: face 2 (plane) is 0.400 mm +- 0.020 mm out, limit 0.100 mm");
  std::istringstream lines(text());
  // A single word may be longer than a line; nothing else.
  for (std::string line; std::getline(lines, line);) {
    const bool long_word = line.find("www") != std::string::npos;
    EXPECT_TRUE(long_word || line.size() <= 100) << line;
  }

  made.run.inspection.faces[1].verdict = Verdict::pass;
  made.run.inspection.verdict = Verdict::undecided;
  EXPECT_EQ(first_line().substr(0, 30), "UNDECIDED: face 3 (cylinder) i");
  made.run.inspection.verdict = Verdict::not_measured;
  EXPECT_EQ(first_line(), "NOT MEASURED: face 4 (plane): not seen: 3 points");
  made.run.inspection.verdict = Verdict::pass;
  EXPECT_EQ(first_line().substr(0, 5), "PASS:");
  made.run.inspection.verdict = Verdict::none;
  EXPECT_EQ(first_line().substr(0, 11), "NO VERDICT:");
}

TEST(Report, DeviationPlyHoldsEveryPoint) {
  const Made made;
  const std::string ply = deviation_ply(made.scan, made.run.inspection, 0.1);
  const size_t body = ply.find("end_header\n") + 11;
  constexpr size_t kRow = 3 * 8 + 3 + 4 + 4;
  ASSERT_EQ(ply.size() - body, 4 * kRow);
  EXPECT_NE(ply.find("element vertex 4\n"), std::string::npos);
  for (size_t i = 0; i < 4; ++i) {
    const char* row = ply.data() + body + i * kRow;
    double x = 0;
    float deviation = 0;
    int face = 0;
    std::memcpy(&x, row, 8);
    std::memcpy(&deviation, row + 27, 4);
    std::memcpy(&face, row + 31, 4);
    EXPECT_EQ(x, static_cast<double>(i));
    EXPECT_EQ(deviation, made.run.inspection.point_deviation_mm[i]);
    EXPECT_EQ(face, static_cast<int>(i));
  }
  const auto rgb = [&](size_t i) {
    const auto* at = reinterpret_cast<const unsigned char*>(ply.data()) + body + i * kRow + 24;
    return std::array<int, 3>{at[0], at[1], at[2]};
  };
  EXPECT_EQ(rgb(0), (std::array<int, 3>{128, 128, 128}));  // on no face
  EXPECT_EQ(rgb(1), (std::array<int, 3>{0, 255, 0}));      // deviation 0
  EXPECT_EQ(rgb(2), (std::array<int, 3>{255, 0, 0}));      // at the limit, too much
}

TEST(Report, AFolderThatCannotBeMadeIsAnError) {
  const Made made;
  const Status status =
      write_report("/dev/null/report", made.run, made.scan, made.model, made.tolerances, made.input);
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().message.find("/dev/null/report"), std::string::npos);
}

TEST(Report, ExitCodes) {
  EXPECT_EQ(exit_code(Verdict::pass), 0);
  EXPECT_EQ(exit_code(Verdict::none), 0);
  EXPECT_EQ(exit_code(Verdict::fail), 1);
  EXPECT_EQ(exit_code(Verdict::undecided), 5);
  EXPECT_EQ(exit_code(Verdict::not_measured), 5);
}

}  // namespace
}  // namespace tetragauge
