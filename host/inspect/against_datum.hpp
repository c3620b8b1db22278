// SPDX-License-Identifier: GPL-3.0-or-later
// Position and orientation of a face against a datum face as measured: the pose does not enter, but for the
// position of what is not parallel to its datum.
#pragma once

#include <optional>

#include "host/inspect/face_inspection.hpp"
#include "host/solid/face_outline.hpp"

namespace tetragauge {

struct FaceAgainstDatum {
  const Face& face;  // of the model
  const FaceOutline& outline;
  const FaceInspection& measured;  // with `plane` or `curve`
  const Face& datum;               // of the model
  const FaceInspection& datum_measured;
};

// `key` is one of kDatumLimitKeys that means something here (applies_to.hpp). Deviation and U, without limit
// and verdict; zones as they compare with the full one, but for position, which compares with half of it.
// Nothing where the face or the datum was not measured.
std::optional<Criterion> against_datum(std::string_view key, const FaceAgainstDatum& in);

}  // namespace tetragauge
