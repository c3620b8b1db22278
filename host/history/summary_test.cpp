// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/history/summary.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "host/report/print_text.hpp"

namespace tetragauge {
namespace {

PartRecord part(int64_t number, double offset_mm, const std::string& model = "aa") {
  PartRecord record;
  record.number = number;
  record.part = "P" + std::to_string(number);
  record.model_sha256 = model;
  record.model_name = model + ".step";
  record.held_by = "best fit";
  record.verdict = Verdict::pass;
  FaceRecord face{
      .face = 7, .type = "plane", .measured = true, .verdict = Verdict::pass, .reason = "", .quantities = {}};
  face.quantities.push_back(
      {.name = "offset", .unit = "mm", .value = offset_mm, .U = 0.004, .lower = -0.1, .upper = 0.1});
  face.quantities.push_back({.name = "flatness", .unit = "mm", .value = 0.01, .U = 0.004, .upper = 0.02});
  record.faces.push_back(face);
  return record;
}

// Characters, not bytes, and no colour codes.
size_t columns_of(const std::string& line) {
  size_t columns = 0;
  bool in_code = false;
  for (const char c : line) {
    if (c == '\x1b') in_code = true;
    if (!in_code && (static_cast<unsigned char>(c) & 0xC0) != 0x80) ++columns;
    if (in_code && c == 'm') in_code = false;
  }
  return columns;
}

void expect_fits(const std::string& text) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(columns_of(line), kColumns) << line;
}

TEST(Summary, ModelsAndWaysOfHoldingAreKeptApart) {
  std::vector<PartRecord> parts{part(1, 0.01), part(2, 0.02, "bb"), part(3, 0.03), part(4, 0.04)};
  parts[3].held_by = "A face 3";
  const std::vector<ModelHistory> models = summarise(parts);
  ASSERT_EQ(models.size(), 3u);
  EXPECT_EQ(models[0].parts.size(), 2u);
  EXPECT_NEAR(models[0].faces.at(0).quantities.at(0).capability.mean, 0.02, 1e-12);
  EXPECT_EQ(models[1].model_sha256, "bb");
  EXPECT_EQ(models[2].held_by, "A face 3");
}

TEST(Summary, WhatWasNotMeasuredIsCountedNotAveraged) {
  std::vector<PartRecord> parts{part(1, 0.01), part(2, 0.03), part(3, 9), part(4, 9), part(5, 0.05)};
  parts[2].faces[0].measured = false;
  parts[2].faces[0].verdict = Verdict::not_measured;
  parts[2].faces[0].quantities.clear();
  parts[3].faces[0].verdict = Verdict::undecided;
  parts[3].faces[0].quantities[0].is_known = false;
  parts[4].faces[0].verdict = Verdict::undecided;  // near its limit: a value like others
  PartRecord lost = part(6, 0);
  lost.faces.clear();
  lost.held_by = "";
  lost.reason = "the cable was pulled";
  parts.insert(parts.begin(), lost);

  const std::vector<ModelHistory> models = summarise(parts);
  ASSERT_EQ(models.size(), 1u);
  const FaceHistory& face = models[0].faces.at(0);
  EXPECT_EQ(face.not_measured, 1u);
  EXPECT_EQ(face.undecided, 2u);
  const QuantityHistory& offset = face.quantities.at(0);
  EXPECT_EQ(offset.capability.n, 3u);
  EXPECT_NEAR(offset.capability.mean, 0.03, 1e-12);
  EXPECT_EQ(offset.unknown, 1u);
  const std::string text = history_text(models[0], {});
  EXPECT_NE(text.find("the cable was pulled"), std::string::npos) << text;
  EXPECT_NE(text.find("undecided in 2"), std::string::npos) << text;
  EXPECT_NE(text.find("n too small"), std::string::npos) << text;
  EXPECT_NE(text.find("??"), std::string::npos) << "no value in the chart\n" << text;
}

TEST(Summary, ChangedLimitsAreSaid) {
  std::vector<PartRecord> parts{part(1, 0.01), part(2, 0.03)};
  parts[1].faces[0].quantities[0].upper = 0.05;
  const QuantityHistory offset = summarise(parts)[0].faces[0].quantities[0];
  EXPECT_TRUE(offset.limits_changed);
  EXPECT_EQ(offset.upper, 0.05);
  EXPECT_NE(history_text(summarise(parts)[0], {}).find("limits have changed"), std::string::npos);
}

TEST(Summary, TextFitsTheTerminal) {
  std::vector<PartRecord> parts;
  for (int k = 1; k <= 130; ++k) {
    parts.push_back(part(k, 0.03 * std::sin(12.9898 * k) - (k == 100 ? 0.35 : 0)));
    parts.back().part = "a serial number that is much longer than any column " + std::to_string(k);
    parts.back().model_name = "/a/very/long/path/to/the/model/of/the/part/that/" + std::string(60, 'm');
    parts.back().faces[0].quantities.push_back(
        {.name = "perpendicularity A", .unit = "mm", .value = 1e-5 * k, .U = 1e-3, .upper = 123.456});
  }
  for (const bool unicode : {false, true}) {
    for (const int face : {0, 7}) {
      const std::string text =
          history_text(summarise(parts)[0], {.unicode = unicode, .colour = unicode, .face = face});
      expect_fits(text);
      EXPECT_NE(text.find("100"), std::string::npos);
      EXPECT_EQ(text.find("nan"), std::string::npos);
    }
  }
  expect_fits(parts_table(parts));
}

TEST(Summary, TheChartShowsWhereAPointIs) {
  std::vector<PartRecord> parts;
  for (int k = 1; k <= 9; ++k) parts.push_back(part(k, k == 4 ? 0.2 : k == 6 ? -0.2 : k == 8 ? 0.09 : -0.09));
  const std::string text = history_text(summarise(parts)[0], {.unicode = true});
  EXPECT_NE(text.find("▁▁▁▲▁▼▁█▁"), std::string::npos) << text;
  EXPECT_NE(history_text(summarise(parts)[0], {}).find("___A_V_\"_"), std::string::npos);
}

TEST(Summary, JsonHasEveryNumber) {
  std::vector<PartRecord> parts;
  for (int k = 1; k <= 26; ++k) parts.push_back(part(k, 0.001 * (k % 5)));
  const nlohmann::ordered_json json = history_json(summarise(parts), 0);
  EXPECT_EQ(json["schema"], "tetragauge/history/1");
  const auto& offset = json["models"][0]["faces"][0]["quantities"][0];
  EXPECT_EQ(offset["n"], 26);
  EXPECT_EQ(offset["values"].size(), 26u);
  EXPECT_FALSE(offset["n_too_small"]);
  EXPECT_LT(offset["Cp_95"][0], offset["Cp"]);
  const auto& flatness = json["models"][0]["faces"][0]["quantities"][1];
  EXPECT_TRUE(flatness["Cp"].is_null());
  EXPECT_TRUE(flatness["Cpk"].is_null()) << "no spread";
  EXPECT_TRUE(history_json(summarise(parts), 8)["models"][0]["faces"].empty());
}

}  // namespace
}  // namespace tetragauge
