// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/check_step_numbers.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "host/solid/solid.hpp"
#include "host/solid/test_solids.hpp"

namespace tetragauge {
namespace {

std::string message_of(const std::string& content) {
  const Status status = check_step_numbers(content, "part.step");
  if (status) return "";
  EXPECT_EQ(status.error().kind, ErrorKind::bad_input);
  return status.error().message;
}

TEST(CheckStepNumbers, NamesFileLineAndNumber) {
  for (const char* number : {"NaN", "nan(ind)", "nan", "INF", "Infinity", "1.E400", "1E+309", "2.5e120",
                             "1.#QNAN", "1.#INF", "1.#IND00", "-NaN", "-1.E400", "+inf"}) {
    const std::string message =
        message_of(std::string("DATA;\n/* two\nlines */\n#1=CARTESIAN_POINT('',(0.,") + number + ",0.));\n");
    EXPECT_EQ(message.find("part.step:4: '"), 0u) << number << ": " << message;
    EXPECT_NE(message.find("a part can have"), std::string::npos);
  }
  EXPECT_NE(message_of("#1=A((1.E400));").find("'1.E400'"), std::string::npos);
  EXPECT_NE(message_of("#1=A((NaN));").find("'NaN'"), std::string::npos);
  EXPECT_NE(message_of("#1=A('it''s',\nNaN);").find("part.step:2:"), std::string::npos);
}

TEST(CheckStepNumbers, LetsEverythingElsePass) {
  for (const char* text :
       {"#1=PRODUCT('NaN','1.E400','it''s INF',$);", "/* NaN 1.E400 */", "#1=A(.INF.,.NAN.,.T.,.F.,*,$);",
        "#10=A(1.,-1.E-400,0.,+1.E+10,1E5,.5,2.E+099,123456789012345678901234567890.);", "#1=NAN(1.);",
        "#1=INF ( #2 );", "#400=(A()B(1.)C(#1));", "#1=A(\"1FE400\");", "#1=NANOMETRE(1.E-9);",
        "ISO-10303-21;\nHEADER;\nFILE_NAME('','2020-01-01T00:00:00',(''),(''),'','','');\nENDSEC;", "", "#",
        "'open", "/* open", "1.", "1.E", "."}) {
    EXPECT_EQ(message_of(text), "") << text;
  }
}

TEST(CheckStepNumbers, RefusesNoGoodFile) {
  const std::filesystem::path folder = std::filesystem::path(TETRAGAUGE_SHARED_DATA) / "step";
  if (!std::filesystem::exists(folder))
    GTEST_SKIP() << folder << " is not here; the folder shared is optional";
  size_t files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    std::stringstream content;
    content << file.rdbuf();
    if (content.str().find("ISO-10303-21") == std::string::npos) continue;
    EXPECT_EQ(message_of(content.str()), "") << entry.path();
    ++files;
  }
  EXPECT_GT(files, 20u);
}

TEST(CheckStepNumbers, AModelWithANumberThatIsNoneIsRefusedAtOnce) {
  const std::filesystem::path path =
      std::filesystem::path(TETRAGAUGE_SHARED_DATA) / "step/occt_import_js/cube-mm.step";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here; the folder shared is optional";
  std::ifstream file(path, std::ios::binary);
  std::stringstream content;
  content << file.rdbuf();
  for (const char* number : {"NaN", "1.E400", "1.E308"}) {
    std::string text = content.str();
    const size_t point = text.find("CARTESIAN_POINT"), first = text.find("(", text.find(",", point)) + 1;
    text.replace(first, text.find(",", first) - first, number);
    EXPECT_NE(test::error_of(text, ".step").find(std::string("'") + number + "'"), std::string::npos);
  }
}

}  // namespace
}  // namespace tetragauge
