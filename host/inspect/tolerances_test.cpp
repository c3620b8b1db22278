// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/tolerances.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace tetragauge {
namespace {

FaceList model() {
  FaceList list;
  for (int id = 1; id <= 12; ++id) {
    Face face;
    face.id = id;
    face.surface = (id + 1) / 2;  // 1 to 6
    face.type = id > 10 ? SurfaceType::cylinder : SurfaceType::plane;
    // 1, 4, 7, 10 look along x, 2, 5, 8 along y, 3, 6, 9 along z; both cylinders stand on z.
    face.normal = Vec3::Unit((id - 1) % 3);
    face.axis = Vec3::UnitZ();
    list.faces.push_back(face);
  }
  return list;
}

Result<Tolerances> read(const std::string& text) {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) /
                                     (std::string("tetragauge_tolerances_") + info->name() + ".json");
  std::ofstream(path, std::ios::binary) << text;
  Result<Tolerances> result = read_tolerances(path, model());
  std::filesystem::remove(path);
  return result;
}

void expect_error(const std::string& text, const std::vector<std::string>& parts) {
  const Result<Tolerances> result = read(text);
  ASSERT_FALSE(result.ok()) << text;
  EXPECT_EQ(result.error().kind, ErrorKind::bad_input) << text;
  for (const std::string& part : parts)
    EXPECT_NE(result.error().message.find(part), std::string::npos)
        << text << "\n  says: " << result.error().message << "\n  without: " << part;
}

TEST(Tolerances, FaceOverSurfaceOverTypeOverDefault) {
  const Result<Tolerances> t =
      read(R"({"default": {"profile_mm": 0.4, "flatness_mm": 0.3}, "type": {"plane": {"profile_mm": 0.3}},
    "surface": {"2": {"profile_mm": 0.2}}, "face": {"4": {"profile_mm": 0.1, "offset_mm": 0.05}}, "skip": [7], "min_coverage": 0.7})");
  ASSERT_TRUE(t.ok()) << t.error().message;
  EXPECT_TRUE(t->given);
  const FaceList list = model();
  EXPECT_EQ(t->of(list.faces[11]).profile_mm, 0.4);  // cylinder
  EXPECT_EQ(t->of(list.faces[0]).profile_mm, 0.3);   // plane
  EXPECT_EQ(t->of(list.faces[2]).profile_mm, 0.2);   // face 3 on surface 2
  EXPECT_EQ(t->of(list.faces[3]).profile_mm, 0.1);   // face 4 on surface 2
  EXPECT_EQ(t->of(list.faces[3]).offset_mm, 0.05);
  EXPECT_EQ(t->of(list.faces[3]).flatness_mm, 0.3);  // key by key
  EXPECT_EQ(t->skip, std::set<int>{7});
  EXPECT_EQ(t->min_coverage, 0.7);
  EXPECT_EQ(read(R"({"default": {"profile_mm": 0.4}})")->min_coverage, 0.5);
}

TEST(Tolerances, DatumsHoldThePartInTheirOrder) {
  const Result<Tolerances> t = read(R"({"datums": {"C": 1, "A": 3, "B": 5, "D": 6}, "face": {
    "6": {"parallelism_mm": {"value": 0.05, "datum": "A"}}, "2": {"perpendicularity_mm": {"value": 0.04, "datum": "A"}},
    "4": {"angularity_mrad": {"value": 2, "datum": "B"}}, "11": {"position_mm": {"value": 0.2, "datum": "C"}, "radius_mm": 0.03}}})");
  ASSERT_TRUE(t.ok()) << t.error().message;
  ASSERT_EQ(t->datums.size(), 4u);
  EXPECT_EQ(t->datums[0].name, "A");
  EXPECT_EQ(t->datums[0].face, 3);
  EXPECT_EQ(t->datums[2].name, "C");
  EXPECT_EQ(t->datum("B")->face, 5);
  EXPECT_EQ(t->datum("E"), nullptr);
  const FaceList list = model();
  EXPECT_EQ(t->of(list.faces[5]).parallelism_mm->value, 0.05);
  EXPECT_EQ(t->of(list.faces[5]).parallelism_mm->datum, "A");
  EXPECT_EQ(t->of(list.faces[3]).angularity_mrad->value, 2);
  EXPECT_EQ(t->of(list.faces[10]).position_mm->value, 0.2);
  EXPECT_EQ(t->of(list.faces[10]).radius_mm, 0.03);
}

TEST(Tolerances, ADefaultHoldsWhereItMeansSomething) {
  const Result<Tolerances> t = read(R"({"datums": {"A": 3}, "default": {"radius_mm": 0.1,
    "parallelism_mm": {"value": 0.05, "datum": "A"}, "perpendicularity_mm": {"value": 0.04, "datum": "A"}}})");
  ASSERT_TRUE(t.ok()) << t.error().message;
  const FaceList list = model();
  EXPECT_FALSE(has_tolerance(t->of(list.faces[2])));  // the datum itself
  EXPECT_FALSE(t->of(list.faces[0]).radius_mm);
  EXPECT_FALSE(t->of(list.faces[0]).parallelism_mm);
  EXPECT_TRUE(t->of(list.faces[0]).perpendicularity_mm);
  EXPECT_TRUE(t->of(list.faces[5]).parallelism_mm);
  EXPECT_FALSE(t->of(list.faces[5]).perpendicularity_mm);
  EXPECT_TRUE(t->of(list.faces[10]).radius_mm);
  EXPECT_TRUE(t->of(list.faces[10]).perpendicularity_mm);  // an axis along the datum's normal
}

TEST(Tolerances, DatumsThatDoNotHoldAreErrors) {
  const std::string rest = R"(, "default": {"profile_mm": 0.1}})";
  expect_error(R"({"datums": {"A": 40})" + rest, {"datums.A", "40", "1 to 12"});
  expect_error(R"({"datums": {"A": 11})" + rest, {"datums.A", "11", "cylinder", "plane"});
  expect_error(R"({"datums": {"a": 1})" + rest, {"datums.a", "capital letter"});
  expect_error(R"({"datums": {"A": "top"})" + rest, {"datums.A", "face id"});
  expect_error(R"({"datums": {"A": 3, "B": 6})" + rest, {"datums.B", "6", "parallel", "A (face 3)"});
  expect_error(R"({"datums": {"A": 3, "B": 1, "C": 6})" + rest, {"datums.C", "A (face 3)", "B (face 1)"});
  expect_error(R"({"datums": [3])" + rest, {"datums", "object"});
  expect_error(R"({"datums": {})" + rest, {"datums", "no face"});
}

TEST(Tolerances, DatumTolerancesNameADatumThatIsThere) {
  const auto with = [](const std::string& face) {
    return R"({"datums": {"A": 3, "B": 1}, "face": {)" + face + "}}";
  };
  expect_error(with(R"("6": {"parallelism_mm": {"value": 0.1, "datum": "C"}})"),
               {"face.6.parallelism_mm.datum", "\"C\"", "A, B"});
  expect_error(R"({"face": {"6": {"parallelism_mm": {"value": 0.1, "datum": "A"}}}})",
               {"face.6.parallelism_mm.datum", "\"datums\": {\"A\": 3}"});
  expect_error(with(R"("6": {"parallelism_mm": 0.1})"), {"face.6.parallelism_mm", "\"value\"", "\"datum\""});
  expect_error(with(R"("6": {"parallelism_mm": {"value": 0.1}})"), {"face.6.parallelism_mm", "\"datum\""});
  expect_error(with(R"("6": {"parallelism_mm": {"valeu": 0.1, "datum": "A"}})"),
               {"face.6.parallelism_mm.valeu", "value"});
  expect_error(with(R"("6": {"parallelism_mm": {"value": 0, "datum": "A"}})"),
               {"face.6.parallelism_mm", "above 0"});
  // Said of a face on which it means nothing.
  expect_error(with(R"("2": {"parallelism_mm": {"value": 0.1, "datum": "A"}})"),
               {"face.2.parallelism_mm", "90.00 degrees", "datum A"});
  expect_error(with(R"("6": {"perpendicularity_mm": {"value": 0.1, "datum": "A"}})"),
               {"face.6.perpendicularity_mm", "0.00 degrees"});
  expect_error(with(R"("3": {"angularity_mrad": {"value": 1, "datum": "A"}})"), {"face.3", "datum A itself"});
  expect_error(with(R"("6": {"radius_mm": 0.1})"), {"face.6.radius_mm", "plane", "no radius"});
}

TEST(Tolerances, UnknownKeysNameTheNearest) {
  expect_error(R"({"defualt": {}})", {"defualt", "default"});
  expect_error(R"({"default": {"profil_mm": 0.1}})", {"default.profil_mm", "profile_mm"});
  expect_error(R"({"type": {"cylindr": {}}})", {"type.cylindr", "cylinder"});
  expect_error(R"({"face": {"3": {"flatnes_mm": 1}}})", {"face.3.flatnes_mm", "flatness_mm"});
}

TEST(Tolerances, UnknownDatumKeys) {
  expect_error(R"({"datum": {"A": 1}, "default": {"profile_mm": 0.1}})", {"datum", "did you mean datums"});
}

TEST(Tolerances, AFileThatJudgesNothingOrSaysAKeyTwiceIsAnError) {
  expect_error("{}", {"no face"});
  expect_error(R"({"default": {"profile_mm": 0.1}, "skip": [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]})",
               {"no face"});
  expect_error(R"({"default": {"profile_mm": 0.2}, "default": {"profile_mm": 9}})", {"default", "twice"});
  expect_error(R"({"default": {"profile_mm": 0.2, "profile_mm": 9}})", {"profile_mm", "twice"});
}

TEST(Tolerances, UnknownFacesAreErrors) {
  expect_error(R"({"face": {"13": {"profile_mm": 0.1}}})", {"face.13", "13", "1 to 12"});
  expect_error(R"({"surface": {"7": {"profile_mm": 0.1}}})", {"surface.7", "1 to 6"});
  expect_error(R"({"skip": [3, 40]})", {"skip[1]", "40", "1 to 12"});
  expect_error(R"({"face": {"three": {}}})", {"face.three"});
}

TEST(Tolerances, WrongValuesAreErrors) {
  expect_error("{\"default\": ", {"not readable as JSON"});
  expect_error(R"({"default": {"profile_mm": 1e999}})", {"1e999"});
  expect_error("[]", {"object"});
  expect_error(R"({"default": {"profile_mm": -0.1}})", {"default.profile_mm", "-0.1"});
  expect_error(R"({"default": {"profile_mm": "0.1"}})", {"default.profile_mm"});
  expect_error(R"({"default": 3})", {"default"});
  expect_error(R"({"skip": 3})", {"skip"});
  expect_error(R"({"skip": [1.5]})", {"skip[0]"});
  // As an int it would be face 1.
  expect_error(R"({"default": {"profile_mm": 1}, "skip": [4294967297]})", {"skip[0]", "4294967297"});
  const std::string deep = std::string(1'000'000, '[') + std::string(1'000'000, ']');
  expect_error("{\"default\": {\"profile_mm\": " + deep + "}}", {"nested"});
  expect_error(R"({"min_coverage": 2})", {"min_coverage"});
  const Result<Tolerances> missing = read_tolerances("/nonexistent/tolerances.json", model());
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().kind, ErrorKind::bad_input);
}

}  // namespace
}  // namespace tetragauge
