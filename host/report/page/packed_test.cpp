// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/report/page/packed.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "host/report/page/histogram.hpp"
#include "host/report/page/html_number.hpp"
#include "host/report/page/html_text.hpp"

namespace tetragauge {
namespace {

TEST(Packed, Base64IsThatOfTheStandard) {
  // RFC 4648, section 10.
  const char* const pairs[][2] = {{"", ""},
                                  {"f", "Zg=="},
                                  {"fo", "Zm8="},
                                  {"foo", "Zm9v"},
                                  {"foob", "Zm9vYg=="},
                                  {"fooba", "Zm9vYmE="},
                                  {"foobar", "Zm9vYmFy"}};
  for (const auto& [plain, coded] : pairs) EXPECT_EQ(base64(plain), coded);
}

std::string little_endian(std::initializer_list<int> values) {
  std::string bytes;
  for (const int value : values) {
    bytes += static_cast<char>(value & 255);
    bytes += static_cast<char>(value >> 8 & 255);
  }
  return base64(bytes);
}

TEST(Packed, LengthsAndTheirExceptions) {
  const float infinity = std::numeric_limits<float>::infinity();
  const std::vector<float> lengths{0, 0.25f, -0.3f, 1e6f, -1e6f, std::nanf(""), infinity, -infinity};
  EXPECT_EQ(packed_lengths(lengths, 0.1), little_endian({0, 3, -3, 32766, -32766, -32768, 32767, -32767}));
}

TEST(Packed, PlacesAreSharesOfTheBox) {
  const Box box{Vec3(-1, 0, 10), Vec3(1, 0, 20)};  // flat in y
  const std::vector<Vec3> places{{-1, 0, 20}, {0, 0, 10}, {5, 0, 12}};
  EXPECT_EQ(packed_places(places, box), little_endian({0, 0, 65535, 32768, 0, 0, 65535, 0, 13107}));
  EXPECT_TRUE(box.holds(Vec3(0.5, 0, 10)));
  EXPECT_FALSE(box.holds(Vec3(0.5, 0.1, 10)));
}

TEST(Histogram, CountsEveryValueOnce) {
  const std::vector<float> values{-0.9f, -0.11f, -0.01f, 0.01f, 0.012f, 0.35f, 40};
  const Histogram bins = histogram(values, 0.5, 12);
  // The limit is wider than 99 of 100 would be, were it not for the one at 40, which is the largest of seven.
  EXPECT_DOUBLE_EQ(bins.half_width_mm, 1.2 * static_cast<double>(0.9f));
  size_t all = 0;
  for (const uint32_t count : bins.counts) all += count;
  EXPECT_EQ(all, values.size());
  EXPECT_EQ(bins.counts.front() + bins.counts[1], 1u);
  EXPECT_EQ(bins.counts.back(), 1u);               // what lies beyond
  EXPECT_EQ(bins.counts[5] + bins.counts[6], 4u);  // within 0.18 of 0
  EXPECT_TRUE(histogram({}, 0.5).counts.empty());
  EXPECT_DOUBLE_EQ(histogram(std::vector<float>{0.001f}, 0.5).half_width_mm, 0.6);
}

TEST(HtmlText, MarkupBecomesText) {
  EXPECT_EQ(html_text("a<b>&\"'\x01"), "a&lt;b&gt;&amp;&quot;&#39; ");
  EXPECT_EQ(script_json({{"k", "</script><!--"}}), "{\"k\":\"\\u003c/script>\\u003c!--\"}");
}

TEST(HtmlNumber, SignsAndZeros) {
  EXPECT_EQ(html_number(0.4016, 3, true), "+0.402");
  EXPECT_EQ(html_number(-0.4016, 3), "−0.402");
  EXPECT_EQ(html_number(-0.0001, 3, true), "0.000");
  EXPECT_EQ(html_number(0.0001, 3, true), "0.000");
  EXPECT_EQ(html_number(nullptr, 3), "–");
  EXPECT_EQ(html_number(12, 0), "12");
}

}  // namespace
}  // namespace tetragauge
