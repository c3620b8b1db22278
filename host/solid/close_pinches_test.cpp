// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/close_pinches.hpp"

#include <gtest/gtest.h>

namespace tetragauge {
namespace {

// A tetrahedron whose corner at the origin two of its faces hold 3e-4 mm apart.
const std::vector<Vec3> kVertices{{-3e-4, 0, 0}, {0, 0, 0}, {0, 0, 10}, {0, 10, 0}, {10, 0, 0}};
const std::vector<std::array<uint32_t, 3>> kSplit{{1, 3, 4}, {1, 4, 2}, {0, 2, 3}, {2, 4, 3}};

TEST(ClosePinches, DrawsTogetherWhatIsNearEnough) {
  EXPECT_FALSE(is_closed(kSplit));
  const std::vector<uint32_t> vertex = close_pinches(kVertices, kSplit, 1e-3);
  EXPECT_EQ(vertex, (std::vector<uint32_t>{0, 0, 2, 3, 4}));
}

TEST(ClosePinches, LeavesWhatIsFurtherApart) {
  EXPECT_TRUE(close_pinches(kVertices, kSplit, 1e-4).empty());
}

TEST(ClosePinches, AMissingFaceStaysMissing) {
  const std::vector<std::array<uint32_t, 3>> open{{1, 3, 4}, {1, 4, 2}, {2, 4, 3}};
  EXPECT_TRUE(close_pinches(kVertices, open, 1e-2).empty());
}

}  // namespace
}  // namespace tetragauge
