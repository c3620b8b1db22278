// SPDX-License-Identifier: GPL-3.0-or-later
// Pairs that a person fixes or forbids.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "host/match/match_procrustes.hpp"
#include "host/match/pair_changes.hpp"
#include "host/match/pair_rules_file.hpp"
#include "host/match/test_parts.hpp"

namespace tetragauge {
namespace {

using namespace test;

bool has(const Match& match, FaceIds ids) {
  return std::any_of(match.pairs.begin(), match.pairs.end(), [&](const FacePair& pair) {
    return pair.model == ids.model && pair.measured == ids.measured;
  });
}

TEST(PairRules, AFixedPairLeavesThePosesThatHoldIt) {
  // A cube has 24 poses; with one face told, 4 turns about its normal are left; with two, one.
  const FaceList cube = box(40, 40, 40);
  MatchOptions options;
  for (const FaceIds ids : {FaceIds{1, 3}, FaceIds{2, 5}}) {
    options.rules.fixed.push_back(ids);
    const Result<Match> match = match_face_lists(cube, cube, options);
    ASSERT_TRUE(match.ok());
    EXPECT_EQ(match->equivalents.size() + 1, options.rules.fixed.size() == 1 ? 4u : 1u);
    for (const FaceIds& fixed : options.rules.fixed) EXPECT_TRUE(has(*match, fixed));
  }
}

TEST(PairRules, AForbiddenPairIsNotMade) {
  const FaceList model = staircase();
  MatchOptions options;
  options.rules.forbidden.push_back({11, 11});
  const Result<Match> free = match_face_lists(model, model), match = match_face_lists(model, model, options);
  ASSERT_TRUE(free.ok() && match.ok());
  EXPECT_TRUE(has(*free, {11, 11}));
  EXPECT_FALSE(has(*match, {11, 11}));
  const PairChanges changes = pair_changes(*free, *match);
  EXPECT_EQ(changes.broken, (std::vector<FaceIds>{{11, 11}}));
  EXPECT_TRUE(changes.made.empty());
  EXPECT_LT(changes.turn_rad, 1e-6);
}

TEST(PairRules, AFixedPairMayBeFartherFromItsPlaceThanTheSearchBelieves) {
  FaceList measured = staircase();
  Face& face = measured.faces[2];
  face.point_mm += 3 * face.normal;  // the gate is 1.7 mm
  face.d_mm += 3;
  MatchOptions options;
  EXPECT_FALSE(has(*match_face_lists(staircase(), measured, options), {3, 3}));
  options.rules.fixed.push_back({3, 3});
  const Result<Match> match = match_face_lists(staircase(), measured, options);
  ASSERT_TRUE(match.ok());
  EXPECT_TRUE(has(*match, {3, 3}));
  for (const FacePair& pair : match->pairs) EXPECT_EQ(pair.used_in_pose, pair.model != 3) << pair.model;
}

TEST(PairRules, RulesThatCannotHoldAreErrors) {
  const FaceList model = staircase();
  MatchOptions options;
  options.rules.fixed = {{1, 1}, {5, 2}};  // bottom and left side cannot be each other's
  EXPECT_FALSE(match_face_lists(model, model, options).ok());
  const std::pair<PairRules, const char*> bad[] = {
      {{{{1, 1}, {99, 1}}, {}, "mine.json"}, "mine.json: fix[1] names model face 99,"},
      {{{}, {{1, 1}, {2, 2}, {3, 98}}, "mine.json"}, "mine.json: forbid[2] names measured face 98,"},
      {{{{1, 99}}, {}, ""}, "fix[0] names measured face 99,"},
      {{{{3, 3}, {1, 1}, {2, 1}}, {}, "mine.json"}, "mine.json: fix[2] fixes measured face 1 to a second"},
      {{{{1, 1}}, {{1, 2}, {1, 1}}, "mine.json"}, "mine.json: forbid[1] forbids model face 1 with"}};
  for (const auto& [wrong, says] : bad) {
    options.rules = wrong;
    const Result<Match> match = match_face_lists(model, model, options);
    ASSERT_FALSE(match.ok());
    EXPECT_EQ(match.error().kind, ErrorKind::bad_input);
    EXPECT_EQ(match.error().message.find(says), 0u) << match.error().message;
    ProcrustesOptions how;
    how.rules = wrong;
    EXPECT_FALSE(match_procrustes(model, model, how).ok());
  }
}

TEST(PairRules, ProcrustesKeepsThem) {
  const FaceList model = staircase();
  ProcrustesOptions how;
  how.rules.fixed.push_back({4, 6});
  how.rules.forbidden.push_back({1, 1});
  for (const auto links : {ProcrustesOptions::Links::all, ProcrustesOptions::Links::modes}) {
    how.links = links;
    const Result<ProcrustesMatch> found = match_procrustes(model, model, how);
    ASSERT_TRUE(found.ok());
    EXPECT_TRUE(has(found->match, {4, 6}));
    EXPECT_FALSE(has(found->match, {1, 1}));
  }
}

TEST(PairRules, TheFileSaysWhatIsWrong) {
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "tetragauge_pairs.json";
  const auto read = [&](const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
    return read_pair_rules(path);
  };
  const Result<PairRules> rules = read(R"({"fix": [[1, 2], [3, 4]], "forbid": [[5, 6]]})");
  ASSERT_TRUE(rules.ok());
  EXPECT_EQ(rules->file, path.string());
  EXPECT_EQ(rules->fixed, (std::vector<FaceIds>{{1, 2}, {3, 4}}));
  EXPECT_EQ(rules->forbidden, (std::vector<FaceIds>{{5, 6}}));
  const std::pair<const char*, const char*> bad[] = {{R"({"fixed": []})", "did you mean fix"},
                                                     {R"({"fix": [[1]]})", "fix[0]"},
                                                     {R"({"fix": [[1, 0]]})", "fix[0]"},
                                                     {R"({"fix": [[1, 2.5]]})", "fix[0]"},
                                                     {R"([1])", "expected"},
                                                     {R"({"forbid": 3})", "forbid"}};
  for (const auto& [text, says] : bad) {
    const Result<PairRules> wrong = read(text);
    ASSERT_FALSE(wrong.ok()) << text;
    EXPECT_NE(wrong.error().message.find(says), std::string::npos) << wrong.error().message;
  }
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace tetragauge
