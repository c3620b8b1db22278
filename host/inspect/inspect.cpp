// SPDX-License-Identifier: GPL-3.0-or-later
// The whole way of the host, from raw points to the verdict (DESIGN section 1, steps 5 to 8). Start here.
#include "host/inspect/inspect.hpp"

#include "host/inspect/cast_scan.hpp"
#include "host/inspect/decide.hpp"
#include "host/inspect/find_material_faults.hpp"
#include "host/inspect/inspect_faces.hpp"

namespace tetragauge {

Result<InspectionRun> inspect(const Scan& scan, const Solid& model, const Tolerances& tolerances,
                              const InspectOptions& options) {
  StageTimer timer;

  // 5. The surface between solid and air.
  timer.begin("reconstruct");
  Result<Reconstruction> reconstruction = reconstruct(scan, options.reconstruct);
  if (!reconstruction) return reconstruction.error();

  // 6. The part's real faces, each fitted to all its raw points.
  timer.begin("faces");
  Result<MeasuredFaces> measured = find_faces(scan, *reconstruction, options.faces);
  if (!measured) return measured.error();

  // 7. Where the part lies: measured faces against the model's, with no initial pose.
  timer.begin("match");
  const RayCaster caster(model);
  Result<Match> match = match_scan(model, caster, scan, *measured, options.match);
  if (!match) return match.error();

  // 8. Each face's deviation with its uncertainty against its tolerance.
  timer.begin("inspect");
  Inspection inspection;
  const CastScan cast = cast_scan(scan, model, caster, match->T_model_part);
  inspection.match = std::move(*match);
  inspection.rule = rule_name(options.rule);
  inspect_faces(scan, model, *measured, cast, tolerances, options, inspection);
  judge_distances(model, tolerances, inspection.faces, options.rule);
  judge_extra_faces(model, *measured, cast, tolerances, inspection);
  find_material_faults(model, *measured, cast, face_outlines(model), tolerances, inspection);
  inspection.verdict = judge_part(inspection, model, tolerances);
  timer.end();

  inspection.timing = std::move(timer);
  return InspectionRun{std::move(*reconstruction), std::move(*measured), std::move(inspection)};
}

}  // namespace tetragauge
