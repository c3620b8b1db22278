// SPDX-License-Identifier: GPL-3.0-or-later
// What an inspection leaves in doubt, and what the machine can do about it.
#pragma once

#include <map>
#include <span>
#include <vector>

#include "host/inspect/inspect.hpp"
#include "host/plan/plan_part.hpp"
#include "host/report/measuring_story.hpp"
#include "host/session/measure_rays.hpp"

namespace tetragauge {

// Directions that were shot at doubtful tetrahedra already: shooting the same again sees the same.
struct TriedRay {
  StagePlace place;
  Vec3 at_mm = Vec3::Zero();  // part frame
  int round = 0;              // in which it was shot
};

struct TetrahedronSum {
  size_t tetrahedra = 0;
  double volume_mm3 = 0;

  void add(double mm3) {
    ++tetrahedra;
    volume_mm3 += mm3;
  }
};

// Single directions that would decide tetrahedra in doubt, by place of the stage in the order of its way.
struct DoubtRays {
  std::vector<SingleRay> rays;
  std::vector<TriedRay> tried;   // what they add to it
  TetrahedronSum open;           // that a legal ray could still decide
  TetrahedronSum in_vain;        // that rays can reach and have been shot at: the doubt remains
  TetrahedronSum known;          // that rays can reach, but only where the points there have said it already
  TetrahedronSum in_noise;       // no larger than what the noise of their corners makes
  TetrahedronSum not_looked_at;  // smaller than those that one round looks at
};

// A ray is legal when the mirrors reach, nothing of the model is in its way before the tetrahedron, beam and
// a camera meet the surface where it ends within the largest incidence, both cameras are free, and no edge
// cuts its spot. What it can decide: README.md. Needs a reconstruction that keeps its tetrahedra.
DoubtRays rays_at_doubts(const PlanningMachine& machine, const RayCaster& caster,
                         const RigidTransform& T_part_model, const Reconstruction& reconstruction,
                         double max_incidence_rad, std::span<const TriedRay> tried,
                         const MachineStance& stance);

// Rasters for faces that are not measured, or not where they could be seen, and for faces whose verdict more
// points can decide.
struct FaceLooks {
  ScanPlan views;
  std::vector<int> uncovered, undecided;  // ids of the faces they are for; datums of undecided ones too
};
struct FaceLooksInput {
  const PlanningMachine& machine;
  const Solid& model;
  const RayCaster& caster;
  const RigidTransform& T_part_model;
  const Tolerances& tolerances;
  const Inspection& inspection;
  const PlanPartOptions& options;
  std::span<const Vec3> points_mm;  // of the scan, part frame
  double u_cal_mm = 0;
  const std::map<int, int>& looked_at;  // how often each face was gone back to already
};
FaceLooks looks_at_faces(const FaceLooksInput& in, const MachineStance& stance);

// Takes out of what such rasters gave the points whose spot an edge cuts, by the model: a fine raster would
// make faces of them.
void drop_cut_spots(const FaceLooksInput& in, const ScanPlan& views, Scan& scan);

// Counted for the report.
Doubts count_doubts(const InspectionRun& run, const DoubtRays& open);

}  // namespace tetragauge
