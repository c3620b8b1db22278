// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/join_set_ups.hpp"

#include <algorithm>
#include <set>

#include "host/inspect/held_faces.hpp"

namespace tetragauge {
namespace {

template <class T>
void append(std::vector<T>& to, const std::vector<T>& more) {
  to.insert(to.end(), more.begin(), more.end());
}

void add_patches(const SetUp& set_up, size_t index, uint32_t first_point, std::vector<MeasuredPatch>& out) {
  std::set<int> misplaced;
  for (const MisplacedFeature& feature : set_up.match.misplaced)
    for (const FaceIds& pair : feature.pairs) misplaced.insert(pair.measured);
  const auto add = [&](int measured_id, int model_id) {
    const size_t k = static_cast<size_t>(measured_id) - 1;
    MeasuredPatch patch{index,
                        measured_id,
                        model_id,
                        misplaced.contains(measured_id),
                        set_up.measured.faces()[k].area_mm2,
                        set_up.measured.face_points[k]};
    for (uint32_t& i : patch.points) i += first_point;
    out.push_back(std::move(patch));
  };
  for (const FacePair& pair : set_up.match.pairs) add(pair.measured, pair.model);
  for (const int id : set_up.match.unmatched_measured) add(id, 0);
}

}  // namespace

JoinedScan join_set_ups(std::span<const Scan> scans, const Solid& model, const RayCaster& caster,
                        const std::vector<SetUp>& set_ups) {
  JoinedScan joined;
  for (size_t s = 0; s < set_ups.size(); ++s) {
    const Match& match = set_ups[s].match;
    add_patches(set_ups[s], s, static_cast<uint32_t>(joined.set_up.size()), joined.patches);
    const CastScan cast = cast_scan(scans[s], model, caster, match.T_model_part);
    append(joined.cast.points_mm, cast.points_mm);
    append(joined.cast.face, cast.face);
    append(joined.cast.hit_mm, cast.hit_mm);
    append(joined.cast.origin_mm, cast.origin_mm);
    append(joined.cast.direction, cast.direction);
    append(joined.cast.deviation_mm, cast.deviation_mm);
    append(joined.cast.sigma_mm, cast.sigma_mm);
    append(joined.cast.cosine, cast.cosine);
    append(joined.cast.beyond_mm, cast.beyond_mm);
    joined.set_up.resize(joined.cast.face.size(), static_cast<uint32_t>(s));
    joined.u_cal_mm = std::max(joined.u_cal_mm, scans[s].header.u_cal_mm);
    joined.spot_mm = std::max(joined.spot_mm, scans[s].header.spot_mm);
    joined.max_offset_mm = std::max(joined.max_offset_mm, match.max_offset_mm);
    for (const FreeDirection& free : match.undetermined)
      joined.is_free_to_shift = joined.is_free_to_shift || free.kind == FreeDirection::Kind::translation;
  }
  joined.held = held_faces(model, set_ups);
  joined.is_determined = !joined.is_free_to_shift &&
                         std::find(joined.held.begin(), joined.held.end(), false) == joined.held.end();
  return joined;
}

}  // namespace tetragauge
