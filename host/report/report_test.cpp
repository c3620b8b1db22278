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
#include "host/report/page/page_sections.hpp"
#include "host/report/terminal_text.hpp"

namespace tetragauge {
namespace {

namespace fs = std::filesystem;

// A made-up run with one face of every verdict, an extra face, an equivalent pose and a free direction.
struct Made {
  std::vector<Scan> scans{Scan{}};
  Solid model;
  Tolerances tolerances;
  InspectionRun run;
  std::vector<ReportFile> scan_files{{"scan.ply", std::string(64, 'a')}};

  Report report() const {
    return {run,
            scans,
            model,
            tolerances,
            scan_files,
            {"model.step", std::string(64, 'b')},
            {"tolerances.json", std::string(64, 'c')}};
  }

  Made() {
    tolerances.given = true;
    tolerances.by_default.profile_mm = 0.2;
    tolerances.skip = {5};
    const Verdict verdicts[] = {Verdict::pass, Verdict::fail, Verdict::undecided, Verdict::not_measured,
                                Verdict::skipped};
    Inspection& inspection = run.inspection;
    run.set_ups.resize(1);
    SetUp& set_up = run.set_ups[0];
    Scan& scan = scans[0];
    tolerances.datums = {{"A", 1, Vec3::UnitZ()}};
    inspection.alignment.datums = {{"A", 1, 2, 1}};
    inspection.relations = {{1, 2, true, false, 1.5707963267948966, 0.001, 0.0002, 0, 0, 0},
                            {1, 4, false, true, 3.141592653589793, 0.001, 0.0002, 20, -0.3, 0.004}};
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
        in.decided_by = Criterion{"profile", in.offset_mm, 0.02, 0.1, verdicts[k], ""};
        in.criteria = {*in.decided_by, {"angularity", 0.3, 0.1, 0.5, Verdict::pass, "A"}};
        if (k == 2) in.radius_mm = 0.01;
        if (k == 2) in.position_mm = 0.02;
      } else {
        in.reason = "not seen: 3 points";
      }
      inspection.faces.push_back(in);
    }
    inspection.verdict = judge_part(inspection, model, tolerances);
    set_up.match.pairs = {{1, 1, 0.0, 0.0, true}, {2, 2, 0.4, 0.0, false}};
    set_up.match.unmatched_model = {3, 4, 5};
    set_up.match.unmatched_measured = {3};
    set_up.match.equivalents = {{RigidTransform{rotation_from_degrees(0, 0, 180), Vec3(1, 2, 3)},
                                 std::string(150, 'w') + " long words and " + std::string(40, 'x'),
                                 {}}};
    set_up.match.undetermined = {{FreeDirection::Kind::translation, Vec3::UnitY(), Vec3::Zero()}};
    ExtraFace extra;
    extra.measured_id = 3;
    extra.face.normal = Vec3::UnitX();
    extra.face.area_mm2 = 50;
    inspection.extra_faces = {extra};
    inspection.missing_faces = {4};
    for (int k = 0; k < 3; ++k) {
      Face face;
      face.id = k + 1;
      face.normal = Vec3::UnitX();
      face.area_mm2 = 50;
      set_up.measured.list.faces.push_back(face);
    }
    for (int k = 0; k < 4; ++k) {
      scan.points.emplace_back(k, 2 * k, 0.5);
      scan.ray_origins.emplace_back(0, 0, 100);
      scan.sigma_mm.push_back(0.02f);
      scan.view.push_back(0);
      inspection.point_deviation_mm.push_back(0.1f * static_cast<float>(k - 1));
      inspection.point_face.push_back(k);
    }
  }
};

fs::path folder() {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  return fs::path(testing::TempDir()) / (std::string("tetragauge_report_") + info->name());
}

TEST(Report, JsonKeepsToItsSchema) {
  const Made made;
  const fs::path out = folder();
  ASSERT_TRUE(write_report(out, made.report()).ok());
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
  // A pose by the surface says how, and only that does.
  Made by_surface;
  Match& match = by_surface.run.set_ups[0].match;
  match.found_by = MatchedBy::surface;
  match.surface_fit = {"its planes leave directions free", 0.0512, 0.983};
  ASSERT_TRUE(write_report(out, by_surface.report()).ok());
  EXPECT_TRUE(validates(out / "report.json"));
  nlohmann::ordered_json found = nlohmann::ordered_json::parse(*read_whole_file(out / "report.json"));
  EXPECT_EQ(found["surface_fit"]["explained"], 0.983);
  found["found_by"] = "planes";
  std::ofstream(out / "wrong.json") << found.dump();
  EXPECT_FALSE(validates(out / "wrong.json"));
  found["found_by"] = "surface";
  found.erase("surface_fit");
  std::ofstream(out / "wrong.json") << found.dump();
  EXPECT_FALSE(validates(out / "wrong.json"));
  ASSERT_TRUE(write_report(out, made.report()).ok());
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
  const auto json = report_json(made.report());
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
  EXPECT_EQ(match_json(made.run.set_ups[0].match, "search")["pairs"], json["pairs"]);
}

TEST(Report, NumbersAreNeverNanOrMinusZero) {
  EXPECT_EQ(json_number(-0.0).dump(), "0.0");
  EXPECT_EQ(json_number(std::numeric_limits<double>::quiet_NaN()).dump(), "null");
  EXPECT_EQ(json_number(0.1).dump(), "0.1");
}

TEST(Report, TextSaysTheVerdictFirstAndFits100Columns) {
  Made made;
  const auto text = [&] { return report_text(made.report()); };
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

TEST(Report, TextAndPageSayWhichWayThePoseWasFound) {
  Made made;
  const std::string planes = report_text(made.report());
  EXPECT_NE(planes.find("\n  found by: its planes, 1 of 2 paired faces, rms 0.0000 mm\n"), std::string::npos);
  Match& match = made.run.set_ups[0].match;
  match.found_by = MatchedBy::surface;
  match.surface_fit = {"its planes leave directions free", 0.0512, 0.9834};
  const std::string surface = report_text(made.report());
  EXPECT_EQ(surface.find("its planes, 1 of 2"), std::string::npos);
  EXPECT_NE(surface.find("found by: all points against the model's whole surface, since its planes leave "),
            std::string::npos);
  EXPECT_NE(surface.find("98.3"), std::string::npos);
  EXPECT_NE(surface.find("0.0512"), std::string::npos);
  const nlohmann::ordered_json json = report_json(made.report());
  EXPECT_EQ(json["found_by"], "surface");
  EXPECT_NE(pose_section(json).find("98.3 % of the points lie on it, scatter 0.0512 mm"), std::string::npos);
}

TEST(Report, NoZeroHasASignInText) {
  Made made;
  Match& match = made.run.set_ups[0].match;
  match.T_model_part.t = Vec3(-1e-9, 1, -2);
  match.undetermined[0].axis = Vec3(-1e-9, 1, -1e-9);
  const std::string text = report_text(made.report());
  EXPECT_NE(text.find("t = (0.0000, 1.0000, -2.0000) mm"), std::string::npos);
  EXPECT_NE(text.find("translation along (0.0000, 1.0000, 0.0000)\n"), std::string::npos);
}

TEST(Report, TheTerminalEndsWithTheVerdictAndThePage) {
  const Made made;
  const Report report = made.report();
  const auto last_line = [](const std::string& text) {
    return text.substr(text.rfind('\n', text.size() - 2) + 1);
  };
  const std::string plain = terminal_text(report, "out/report.html", false);
  // The beginning of report.txt, and where the rest is.
  EXPECT_TRUE(report_text(report).starts_with(summary_text(report)));
  EXPECT_TRUE(plain.starts_with(summary_text(report)));
  EXPECT_NE(plain.find("out/report.txt\n"), std::string::npos);
  EXPECT_EQ(last_line(plain),
            "FAIL: face 2 (plane) is 0.400 mm +- 0.020 mm out, limit 0.100 mm; report: out/report.html\n");
  // A long path cuts the sentence short, between words.
  EXPECT_EQ(last_line(terminal_text(report, std::string(50, 'p') + "/report.html", false)),
            "FAIL: face 2 (plane) is ...; report: " + std::string(50, 'p') + "/report.html\n");
  // Colour adds escapes and nothing else.
  std::string coloured = terminal_text(report, "out/report.html", true);
  EXPECT_NE(coloured, plain);
  for (size_t at = 0; (at = coloured.find("\033[", at)) != std::string::npos;)
    coloured.erase(at, coloured.find('m', at) + 1 - at);
  EXPECT_EQ(coloured, plain);
}

TEST(Report, NumbersTooWideForTheirColumnLoseDecimals) {
  Made made;
  made.run.inspection.faces[1].offset_mm = -123456.789;
  made.run.inspection.faces[1].tilt_rad = 1.2345678;
  made.run.inspection.faces[1].decided_by->deviation = 123456.789;
  std::istringstream lines(report_text(made.report()));
  size_t rows = 0;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("   2 plane")) continue;
    ++rows;
    EXPECT_LE(line.size(), 100u) << line;
    EXPECT_NE(line.find(" -123457 1234.57 "), std::string::npos) << line;
  }
  EXPECT_EQ(rows, 1u);
}

TEST(Report, DeviationPlyHoldsEveryPoint) {
  const Made made;
  const std::string ply = deviation_ply(made.report(), 0.1);
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
  const Status status = write_report("/dev/null/report", made.report());
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
