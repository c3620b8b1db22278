// SPDX-License-Identifier: GPL-3.0-or-later
// The whole way of the host, from raw points to the verdict (DESIGN section 1, steps 5 to 8). Start here.
#include "host/inspect/inspect.hpp"

#include "host/inspect/decide.hpp"
#include "host/inspect/find_material_faults.hpp"
#include "host/inspect/hold_by_datums.hpp"
#include "host/inspect/judge_faces.hpp"
#include "host/inspect/judge_misplaced.hpp"
#include "host/inspect/measure_faces.hpp"
#include "host/inspect/relate_faces.hpp"

namespace tetragauge {
namespace {

// Which of several scans an error is about.
Error of_scan(size_t index, std::span<const Scan> scans, Error error) {
  if (scans.size() > 1)
    error.message =
        "scan " + std::to_string(index + 1) + " of " + std::to_string(scans.size()) + ": " + error.message;
  return error;
}

}  // namespace

Result<InspectionRun> inspect(std::span<const Scan> scans, const Solid& model, const Tolerances& tolerances,
                              const InspectOptions& options) {
  InspectionRun run;
  Inspection& out = run.inspection;
  const RayCaster caster(model);
  const auto begin = [&](const char* stage, const char* in_words) {
    out.timing.begin(stage);
    if (options.on_stage) options.on_stage(in_words);
  };

  for (const Scan& scan : scans) {
    // 5. The surface between solid and air.
    begin("reconstruct", "reconstructing the surface");
    Result<Reconstruction> reconstruction = reconstruct(scan, options.reconstruct);
    if (!reconstruction) return of_scan(run.set_ups.size(), scans, reconstruction.error());

    // 6. The part's real faces, each fitted to all its raw points.
    begin("faces", "finding the faces");
    Result<MeasuredFaces> measured = find_faces(scan, *reconstruction, options.faces);
    if (!measured) return of_scan(run.set_ups.size(), scans, measured.error());

    // 7. Where the part lies: measured faces against the model's, with no initial pose.
    begin("match", "matching them with the model");
    Result<Match> match = match_scan(model, caster, scan, *measured, options.match);
    if (!match) return of_scan(run.set_ups.size(), scans, match.error());

    run.set_ups.push_back({std::move(*reconstruction), std::move(*measured), std::move(*match)});
  }

  // 8. All scans in the model's frame: each face's deviations with their uncertainty ...
  begin("inspect", "inspecting the faces");
  const std::vector<FaceOutline> outlines = face_outlines(model);
  JoinedScan joined = join_set_ups(scans, model, caster, run.set_ups);
  PartPose pose = best_fit(run.set_ups);
  MeasuredPart part = measure_faces(joined, model, caster, outlines, pose, tolerances);
  if (!tolerances.datums.empty()) {
    // ... and again with the part held by its datums, as they were found.
    hold_by_datums(model, tolerances.datums, part.faces, part.share, run.set_ups, pose, out.alignment);
    joined = join_set_ups(scans, model, caster, run.set_ups);
    part = measure_faces(joined, model, caster, outlines, pose, tolerances);
  }

  // ... against its tolerance.
  out.rule = options.rule;
  out.relations = relate_faces(model, part.faces);
  out.faces = std::move(part.faces);
  out.missing_faces = std::move(part.missing);
  out.extra_faces = extra_faces(joined, model, run.set_ups, out.faces, tolerances);
  judge_faces(model, outlines, tolerances, out);
  judge_distances(model, tolerances, out.faces, out.rule);
  judge_misplaced(model, outlines, run.set_ups, tolerances, out);
  find_material_faults(model, joined, outlines, tolerances, out);
  out.verdict = judge_part(out, model, tolerances);
  out.point_deviation_mm = std::move(part.point_deviation_mm);
  out.point_face = std::move(part.point_face);
  out.timing.end();
  return run;
}

}  // namespace tetragauge
